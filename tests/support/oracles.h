// Oracles: slow, obvious algorithms against which fast ones are tested.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"

#include <set>

namespace betamesh {

/// Oriented triangles of particle rows, each rotated so that its smallest row comes first.
using TriangleSet = std::set<Triangle>;

TriangleSet canonical(const std::vector<Triangle>& triangles);

/// The paper's Algorithm 1 with exact predicates: every triplet, both sides, every other particle. Triangles are of
/// input rows. O(n⁴).
TriangleSet bruteForceAlphaTriangles(const SnappedParticles& particles);

/// The same without tie rules: in floating point of 3,000 bits, for balls whose squared radii differ by the tiny
/// amounts that break ties. O(n⁴), for at most 12 particles.
TriangleSet perturbedAlphaTriangles(const SnappedParticles& particles);

/// Expects each cycle of a boundary to bound one face, and each component to be a closed orientable surface: V - E + F
/// is even and at most two per component.
void expectClosedSurfaces(const BallBoundary& boundary);

/// The generalised winding number of a closed mesh about a point, from solid angles.
double windingNumber(const Mesh& mesh, const Vec3& point);

/// Distance from a point to the nearest triangle, by brute force.
double distanceTo(const Mesh& mesh, const Vec3& point);
/// Likewise to the nearest edge.
double distanceTo(const Curves& curves, const Vec3& point);

/// Do any two triangles cross? By brute force over all pairs.
bool crossesItself(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles);

}  // namespace betamesh
