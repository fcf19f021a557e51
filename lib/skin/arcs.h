// The ball boundary -> points along its arcs and circles.

#pragma once

#include "skin/arc_network.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// How finely arcs are cut.
struct ArcSubdivision {
    double max_angle = 0.25;  ///< radians per segment of a great circle: a sagitta of 0.008 r; larger on small circles
    int segments = 0;         ///< > 0: so many on every arc, half on half a circle; more above 2 radians
    Appearance appearance = Appearance::on_boundary;
    double flat_angle = 0;  ///< > max_angle: the same between faces that are only small patches of their balls
    bool moves_far = false;  ///< what is made of this goes far from the balls: points sink below the chords of arcs, and
                             ///< edges begin to turn sooner, so that what comes and goes does so from where it is held
};

/// Cuts every arc into segments. The sagitta r·δ²/8 is the same on circles of any size: an arc of angle θ on a circle
/// of radius ρ wants θ sqrt(ρ/r) / δ segments. Appearance::on_boundary gives it the next whole number, all equal;
/// Appearance::gradual one or the next even number, whose points rise from chords in the middle as the arc grows, then
/// part until all segments are equal again: the same from either end, wherever it grows. An arc between the two sides
/// of one triplet gets at least two, half a circle likewise, so that no two segments share both ends.
///
/// Faces that are only small patches of their balls are in the surface of a liquid or on a side of a sheet, as a rule.
/// Smoothing lays that flat, chords and all, so that arcs between two of them can have longer segments, and the surface
/// still jumps less where balls begin to meet there than round drops and edges. In between segments are shorter by
/// degrees, which change continuously but where faces of one ball become one.
///
/// Points move as the ends of their arc and its circle do.
///
/// in      a boundary, where there is a calm angle with its faces; its balls with their motion; its vertices with
///         theirs
/// same    result for any thread count
/// cost    O(points)
ArcNetwork arcPoints(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                     std::vector<DualVec3> vertices, const ArcSubdivision& subdivision);

}  // namespace betamesh
