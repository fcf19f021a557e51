// Wavefront OBJ: positions, faces and components, nothing else.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// Lines v, f (a, a/b, a//c, a/b/c; negative indices count back) and l; all others are passed over. Where every face
/// follows a line `o component_N`, these are the components.
FileContents parseObj(std::span<const std::byte> bytes, const std::string& file);

/// Positions with as many digits as a float needs to come back the same. Velocity and attributes are left out:
/// the format has no place for them. Components become objects: faces are sorted by component, otherwise in their
/// order.
void encodeObj(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Each line as an `l`; a closed one ends with the vertex that it begins with.
void encodeObj(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
