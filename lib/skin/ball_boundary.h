// Snapped particles -> the boundary of the union of their balls.

#pragma once

#include "core/ball_boundary.h"
#include "exact/snapped_particles.h"

#include <string_view>
#include <variant>

namespace betamesh {

/// Why floating-point predicates gave no valid boundary: an edge between two particles, by their rows, and
/// what is wrong with it, to follow "the edge from … to … ".
struct UnpairedEdge {
    std::uint32_t from, to;
    std::string_view fault;
};

/// Twins and cycles; the alpha mesh has no use for them.
enum class Arcs { left_out, traced };

/// With exact predicates, for every input. All but the faces of cycles, which groupFaces finds. Of the given directions
/// those that are exposed: while a ball's neighbours are at hand this takes a quarter of what it would later.
///
/// in      n >= 0 snapped particles, the rows of those that may be exposed, and unit vectors
/// same    result for any thread count
/// cost    O(n) for a bounded number of neighbours; 1-4 µs per exposed ball
/// source  beta mesh paper, sections 3.2 and 3.3; Edelsbrunner 1993
BallBoundary ballBoundary(const SnappedParticles& particles, const std::vector<std::uint32_t>& exposed,
                          const std::vector<Vec3>& directions = {}, Arcs arcs = Arcs::traced);

/// With the paper's floating-point test, validated by its edge count, and by what the edge count cannot see:
/// that the triangles round an edge close in turn, and that no exposed ball was left without a triangle.
std::variant<BallBoundary, UnpairedEdge> ballBoundaryInFloats(const SnappedParticles& particles,
                                                              const std::vector<std::uint32_t>& exposed,
                                                              const std::vector<Vec3>& directions = {});

}  // namespace betamesh
