// skinFrame() for clouds that do not fit into memory. The source file has the order of the stages.

#pragma once

#include "betamesh/skin.h"
#include "skin/near_surface.h"

namespace betamesh {

/// The same bytes for clouds that do not fit into memory. `near` is the result of a NearSurfaceFinder with these
/// parameters that has seen all particles; `particles` are only those listed in near.row.
SkinnedFrame skinFrame(const Particles& particles, const NearSurface& near, const SkinParams& params,
                       const Watch& watch = {});

}  // namespace betamesh
