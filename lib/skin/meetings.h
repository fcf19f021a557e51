// Places where parts of the liquid are about to meet or to part: necks, tips of drops, and holes.

#pragma once

#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/deforming_mesh.h"
#include "skin/face_points.h"
#include "skin/place.h"

#include <vector>

namespace betamesh {

/// A place where two or three balls meet in little more than a point, or are about to meet. Two: a thin neck, or the
/// tips of two drops. Three, around a point between them: a thin membrane, or a hole that is about to close. The axis
/// is along the neck, or perpendicular to the membrane; the unit of lengths is the particle spacing there.
struct Meeting : Place {
    double nearness;  ///< 0 to 1: 1 where the balls touch in a point, 0 far from that
    double least;     ///< radius that a neck has to have; 0 where there is none
};

/// The meetings of a union of balls. network: its arcs and circles; points: those on its balls, with those towards
/// balls near contact; spacing: of the particles with the largest balls, world units.
///
/// same    for any thread count
/// cost    O(arcs + circles + points)
std::vector<Meeting> meetings(const BallBoundary& boundary, const ArcNetwork& network, const FacePoints& points,
                              double spacing);

/// Keeps the surroundings of meetings as they were before smoothing, whose kernels are far wider: it bends and flattens
/// thin necks, blunts the rims of small holes and fills the dimples of thin membranes, so the surface would jump as a
/// neck parts or a hole opens. Then space is pushed away from the axes of necks, by an increasing function of the
/// distance, which does not fold: necks are no hairs. Both are continuous in time, also as balls begin to meet.
///
/// in      retracted: positions before smoothing
/// out     the share of its displacement by smoothing that each vertex has kept: 1 far from meetings
/// cost    O(meetings · vertices near them)
std::vector<float> keepMeetings(const std::vector<Meeting>& meetings, const std::vector<Vec3>& retracted,
                                DeformingMesh& surface);

}  // namespace betamesh
