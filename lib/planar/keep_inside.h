// Keeps particles inside the curve around them.

#pragma once

#include "planar/boundary_curves.h"

#include <vector>

namespace betamesh {

/// A particle and the depth inside the curve that it has to keep, world units.
struct DeepPoint {
    Vec3 position;
    double least_depth;
};

/// Moves the curve outwards near particles that are not as deep inside as they have to be, by smooth bumps as high as
/// what is missing. Where one is outside even so, displacements nearby are taken back, which is not continuous in time.
///
/// in      a curve without crossings. before: its vertices on the boundary of the discs, where all particles are
///         inside. reach: farther than any particle is outside, world units; unit: as of moveWithoutCrossings()
/// same    bytes for any thread count
/// cost    O(particles · edges within reach)
void keepInside(const std::vector<DeepPoint>& particles, const std::vector<DualVec3>& before, double reach, double unit,
                BetaCurve& curve);

}  // namespace betamesh
