// Which attributes are directions or vectors, and the rotation between up axes.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/io.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"

namespace betamesh {

/// Whether an attribute of three floats is an acceleration (accel, acceleration) or a normal (N, normal, normals), in
/// upper or lower case.
bool isAcceleration(const Attribute& attribute);
bool isNormal(const Attribute& attribute);

/// A copy whose z axis points up where y did: positions, velocities, accelerations and normals are rotated by
/// 90 degrees about x, (x, y, z) -> (x, -z, y). Exact: only signs change.
Particles withZUp(Particles particles);
Mesh withZUp(Mesh mesh);
Curves withZUp(Curves curves);
Spheres withZUp(Spheres spheres);

/// The inverse of withZUp().
Particles withYUp(Particles particles);
Mesh withYUp(Mesh mesh);
Curves withYUp(Curves curves);

}  // namespace betamesh
