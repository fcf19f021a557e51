// Slow and obvious answers to judge fast ones by.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"

#include <set>

namespace betamesh {

/// Oriented triangles of particle rows, each turned so that its smallest row comes first.
using TriangleSet = std::set<Triangle>;

TriangleSet canonical(const std::vector<Triangle>& triangles);

/// The paper's Algorithm 1: every triplet, both sides, every other particle; with exact predicates.
/// Coincident particles count once, as the smallest row. O(n⁴).
TriangleSet bruteForceAlphaTriangles(const Particles& particles, double radius);

/// The same for balls whose squared radii really differ by the tiny amounts that break ties, in floating
/// point of 3,000 bits: knows nothing of tie rules. O(n⁴), for at most 12 particles.
TriangleSet perturbedAlphaTriangles(const Particles& particles, double radius);

/// How often a point is enclosed by a closed mesh: its generalised winding number, from solid angles.
double windingNumber(const Mesh& mesh, const Vec3& point);

/// From a point to the nearest point of any triangle, by looking at all of them.
double distanceTo(const Mesh& mesh, const Vec3& point);

/// Does a triangle cross another one? By all pairs of them.
bool crossesItself(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles);

}  // namespace betamesh
