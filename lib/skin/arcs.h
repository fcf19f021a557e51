// Points along every arc and full circle of the ball boundary, shared by the two faces that meet there.

#pragma once

#include "base/dual.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"
#include "skin/constants.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace betamesh {

/// An arc or full circle.
struct ArcLine {
    std::array<std::uint32_t, 2> balls;
    Dual radius, length;  ///< world units
    DualVec3 outwards;    ///< integral along the line of the unit vector from the circle's centre, world units
};

/// Point v < vertices is vertex v of the ball boundary; then come the points inside arcs, then those on full circles.
/// Arc a runs counter-clockwise round the axis from its lower to its higher ball, from one vertex to another; circle k
/// likewise, without ends.
struct ArcNetwork {
    std::size_t vertices = 0;
    std::vector<DualVec3> point;

    std::vector<std::uint32_t> arc_of;        ///< of each half-edge of the boundary
    std::vector<std::uint32_t> arc_start;     ///< of each arc: the half-edge, from the lower ball, at which it begins
    std::vector<Dual> arc_angle;              ///< of each arc, radians
    std::vector<std::uint32_t> arc_begin;     ///< first point inside each arc, and one entry past the last
    std::vector<std::uint32_t> circle_begin;  ///< first point on each circle, and one entry past the last

    std::vector<ArcLine> line;         ///< each arc, then each circle
    IndexRows at_ball;                 ///< the lines round each ball, ascending
    std::vector<FadingVertex> fading;  ///< points that are between the chord and the arc

    std::uint32_t arcSize(std::size_t a) const { return arc_begin[a + 1] - arc_begin[a]; }
    std::uint32_t circleSize(std::size_t k) const { return circle_begin[k + 1] - circle_begin[k]; }
    /// Mean of BallBoundary::scaleOf() over the two balls of a line.
    double scaleOfLine(std::size_t l, const BallBoundary& boundary) const {
        return (boundary.scaleOf(line[l].balls[0]) + boundary.scaleOf(line[l].balls[1])) / 2;
    }
    /// For each point the mean of a number that each ball has: over two balls on arcs and circles, over three at
    /// vertices.
    std::vector<float> pointMeans(const BallBoundary& boundary, const std::function<double(std::size_t)>& ofBall) const;
    /// These means of BallBoundary::scaleOf(). Empty if all are 1.
    std::vector<float> pointScales(const BallBoundary& boundary) const;
    /// Radius of a line's circle in radii of the smaller of its balls.
    Dual relativeRadius(std::size_t l, const BallBoundary& boundary) const {
        const Dual a = boundary.worldRadiusOf(line[l].balls[0]), b = boundary.worldRadiusOf(line[l].balls[1]);
        return line[l].radius / (a.value < b.value ? a : b);
    }
};

/// How finely arcs are subdivided.
struct ArcSubdivision {
    double max_angle = kBoundaryArcAngle;  ///< radians per segment of a great circle; larger on small circles
    int segments = 0;                      ///< > 0: this many on every arc, and as many per kMaxSegmentAngle on longer
                                           ///< arcs and on circles; max_angle is not used then
    Appearance appearance = Appearance::on_boundary;
    bool is_retracted = false;  ///< the mesh is retracted far below the balls afterwards: face points are lowered below
                                ///< the chords of arcs, and edge flips begin sooner
};

/// Subdivides every arc. The sagitta r·δ²/8 is the same on circles of any size: an arc of angle θ on a circle of radius
/// ρ needs θ sqrt(ρ/r) / δ segments, where r is the radius of the smaller of its two balls. With
/// Appearance::on_boundary that is rounded up, and all segments are equal. With Appearance::gradual it is rounded up to
/// one or an even number: new points fade in from the chords in the middle as the arc grows, then move apart until all
/// segments are equal again, symmetrically, so either end may grow. An arc between the two sides of one triplet gets at
/// least two segments, half a circle likewise, so that no two segments share both ends.
///
/// Points have the motion that their arc's ends and its circle give them.
///
/// in      a boundary; its balls and its vertices with their motion
/// same    result for any thread count
/// cost    O(points)
ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<DualVec3>& balls, std::vector<DualVec3> vertices,
                     const ArcSubdivision& subdivision);

}  // namespace betamesh
