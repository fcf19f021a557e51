// Necks between parts of the liquid that are about to part.

#pragma once

#include "skin/ball_boundary.h"
#include "skin/deforming_mesh.h"
#include "skin/face_points.h"

#include <vector>

namespace betamesh {

/// A circle in which two balls meet and that no other ball covers, or a place where two balls are about to meet: a thin
/// neck, or the tips of two drops before or after. World units.
struct Neck {
    Vec3 middle, axis;  ///< the circle's centre; a unit vector along the neck
    double spacing;     ///< of the particles there
    double thinness;    ///< 0 to 1: 1 at contact, 0 where the balls are far apart or the circle is large
    double least;       ///< radius that the neck has to have, particle spacings; 0 where the balls do not meet
};

/// The thin necks of a union of balls. points: those on its balls, with those towards balls near contact; spacing: of
/// the particles with the largest balls, world units.
///
/// cost    O(circles + points)
std::vector<Neck> thinNecks(const BallBoundary& boundary, const FacePoints& points, double spacing);

/// Keeps necks round and thicker than hairs. A neck that is thin compared with the kernels of smoothing is bent and
/// flattened by them; its vertices go back to where they were. Then space is pushed away from the axes, by an
/// increasing function of the distance: this does not fold. Both are continuous in time, also as balls begin to meet.
///
/// in      retracted: positions before smoothing
/// cost    O(necks · vertices near them)
void keepNecksThick(const std::vector<Neck>& necks, const std::vector<Vec3>& retracted, DeformingMesh& surface);

}  // namespace betamesh
