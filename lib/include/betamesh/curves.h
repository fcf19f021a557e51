// Closed curves in a plane, made of straight edges.

#pragma once

#include "betamesh/particles.h"

#include <array>
#include <span>

namespace betamesh {

/// Two vertices, directed so that the liquid is on the left.
using Edge = std::array<std::uint32_t, 2>;

/// Row i of every array but edges is vertex i. Lengths in world units, time in seconds.
/// position has n rows; velocity has n rows or none; every attribute has n rows. Edges of one line are consecutive.
struct Curves {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<Edge> edges;
    std::vector<Attribute> attributes;  ///< of vertices
};

/// Splits the edges into lines. Within a line every edge begins where the previous one ends; a line ends when it
/// returns to its first vertex.
std::vector<std::span<const Edge>> linesOf(const Curves& curves);

}  // namespace betamesh
