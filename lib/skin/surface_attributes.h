// Attributes of the vertices that are measured on the finished surface: normals, curvature, thickness, shape.

#pragma once

#include "betamesh/skin_params.h"
#include "skin/beta_mesh.h"

#include <vector>

namespace betamesh {

/// The columns of `wanted` without rows, as an empty mesh has them.
std::vector<Attribute> emptyColumns(const SurfaceAttributes& wanted);

/// errors  an attribute of the particles is to be interpolated that has the name of one that is measured
void requireDistinctNames(const SkinParams& params);

/// The columns of emptyColumns(), with one row for each vertex that a triangle uses, as in asMesh().
///
/// Normals and curvatures come from a linear fit, in the tangent plane, of the normals of the vertices near that face
/// the same way, weighted by area: its value and its rates of change at the vertex. It is exact on planes, spheres and
/// cylinders. The thickness D of a plane sheet follows from the sum of area / distance⁴ over the opposite side, π / D²;
/// the same sum gives 2 r on a sphere and 1.87 r on a cylinder. Shapes are told apart by the thickness, and by the
/// principal curvatures times the thickness: both are 0 on sheets, one is about 2 on threads, both are 2 on drops.
///
/// A vertex that fades in takes its values from its supports, as it does with displacements, so
/// shading does not change when a vertex appears or vanishes.
///
/// Widths, the largest thickness and the thicknesses at which shapes differ are in the particle spacings at the vertex.
///
/// in      spacing: of the particles, of the largest if their sizes differ, world units
/// out     finite numbers; normals of unit length; thickness in world units, curvature per world unit
/// same    bytes for any thread count and instruction set
/// cost    O(vertices · vertices within 1.2 spacings, for thickness and shape 5 spacings, 16,384 at most)
std::vector<Attribute> surfaceAttributes(BetaMesh mesh, double spacing, const SurfaceAttributes& wanted);

}  // namespace betamesh
