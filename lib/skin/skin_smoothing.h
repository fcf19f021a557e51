// What makes the skin calm: narrow smoothing that shrinks nothing, and wide fits where the liquid is wide.

#pragma once

#include "skin/surface_measure.h"

namespace betamesh {

/// How long edges may be at each vertex, units: longer where the surface is flat.
std::vector<float> wantedLengths(MovedSurface& surface);

/// Smooths a retracted surface.
void smoothSkin(MovedSurface& surface, double widest, int passes);

}  // namespace betamesh
