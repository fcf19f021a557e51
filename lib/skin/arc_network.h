// Points along every arc and full circle of the ball boundary, shared by the two faces that meet there.

#pragma once

#include "base/dual.h"
#include "skin/beta_mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace betamesh {

/// An arc or full circle.
struct ArcLine {
    std::array<std::uint32_t, 2> balls;
    Dual radius, length;  ///< world units
    DualVec3 outwards;      ///< unit vectors from the centre of the circle, summed along it: times a length
};

/// Point v < vertices is vertex v of the ball boundary; then come the points inside arcs, then those on full
/// circles. Arc a runs counter-clockwise round the axis from its lower to its higher ball, from one vertex
/// to another; circle k likewise, and has no end.
struct ArcNetwork {
    std::size_t vertices = 0;
    std::vector<DualVec3> point;

    std::vector<std::uint32_t> arc_of;        ///< of each half-edge of the boundary
    std::vector<std::uint32_t> arc_start;     ///< the half-edge, from the lower ball, at which each arc begins
    std::vector<Dual> arc_angle;              ///< radians, of each arc
    std::vector<std::uint32_t> arc_begin;     ///< first point inside each arc, and one entry past the last
    std::vector<std::uint32_t> circle_begin;  ///< first point on each circle, and one entry past the last

    std::vector<ArcLine> line;  ///< each arc, then each circle
    IndexRows at_ball;               ///< lines round each ball, ascending
    /// Of the face that each half-edge goes round, from 0 to 1, where it is only a small patch of its ball: in the
    /// surface of a liquid, as a rule, which smoothing lays flat, so that it need not be cut finely. None: all 0.
    std::vector<Dual> flatness;

    std::vector<FadingVertex> fading;  ///< points that are still on their way from the chord to the arc

    std::uint32_t arcSize(std::size_t a) const { return arc_begin[a + 1] - arc_begin[a]; }
    std::uint32_t circleSize(std::size_t k) const { return circle_begin[k + 1] - circle_begin[k]; }
};

}  // namespace betamesh
