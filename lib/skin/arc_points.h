// The ball boundary -> points along its arcs and circles.

#pragma once

#include "core/arc_network.h"
#include "core/ball_boundary.h"

namespace betamesh {

/// How finely arcs are cut.
struct ArcSubdivision {
    double max_angle = 0.28;  ///< radians per segment of a great circle: a sagitta of 0.01 r; larger on small circles
    int segments = 0;         ///< > 0: exactly so many segments on every arc instead
};

/// Cuts every arc into equal segments. The sagitta r·δ²/8 is the same on circles of any size: an arc of angle
/// θ on a circle of radius ρ gets ceil(θ sqrt(ρ/r) / δ). An arc between the two sides of one triplet gets at
/// least two, a full circle at least three, so that no two segments share both ends.
///
/// A point on two spheres moves with both: exactly along their normals, and along the circle with the mean of
/// the two balls.
///
/// in      a boundary; its balls and vertices with their motion
/// same    result for any thread count
/// cost    O(points)
ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<Moving>& balls, std::vector<Moving> vertices,
                     const ArcSubdivision& subdivision);

}  // namespace betamesh
