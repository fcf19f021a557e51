// Closed curves in a plane, made of straight edges. Row i of every array is vertex i.

#pragma once

#include "betamesh/particles.h"

#include <array>
#include <span>

namespace betamesh {

/// Two vertices; the liquid is on the left.
using Edge = std::array<std::uint32_t, 2>;

/// Lengths in world units, time in seconds.
/// position has n rows; velocity has n rows or none; every attribute has n rows. Edges of one line follow each other.
struct Curves {
    std::vector<Vec3> position;
    std::vector<Vec3> velocity;  ///< world units per second
    std::vector<Edge> edges;
    std::vector<Attribute> attributes;
};

/// The edges of each line: every edge begins where the one before it ends; once a line is back at its first vertex the
/// next one begins.
std::vector<std::span<const Edge>> linesOf(const Curves& curves);

}  // namespace betamesh
