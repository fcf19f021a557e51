// Binary STL, out: triangles and nothing else.

#pragma once

#include "betamesh/mesh.h"
#include "io/bytes.h"

#include <string>

namespace betamesh {

/// Each triangle with its normal and the positions of its corners as floats. Velocity, attributes, components and what
/// vertices triangles share are lost: the format has no place for them.
///
/// errors  2^32 triangles and more
void encodeStl(ByteWriter& out, const Mesh& mesh, const std::string& file);

}  // namespace betamesh
