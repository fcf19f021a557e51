// The boundary of discs -> closed curves that hold all of it.

#pragma once

#include "planar/beta_curve.h"
#include "planar/disc_boundary.h"

#include <functional>

namespace betamesh {

/// Every arc from vertex to vertex, with a point wherever it passes one of `directions` (>= 8) fixed directions from
/// its centre; bare circles are polygons of these. A point comes and goes where it coincides with the end of its arc,
/// so the curve moves continuously, and before smoothing nothing of it crosses anything: all points of a disc lie on
/// one circle and in its Voronoi cell.
///
/// out     a line for each cycle, then one for each bare disc
/// cost    O(points)
BetaCurve completeCurve(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                        const std::vector<DualVec3>& vertices, int directions);

/// Leaves out lines that run round small holes, and whatever is inside them. All others stay as they are, in their
/// order.
///
/// in      the complete curve of discs of that radius, on them; isSmall: asked of lines that run round holes, with the
///         area inside, world units squared
/// out     how many holes were filled
/// cost    O(points), and more where holes are large enough to hold drops
std::size_t fillHoles(BetaCurve& curve, double radius,
                      const std::function<bool(std::size_t line, double area)>& isSmall);

}  // namespace betamesh
