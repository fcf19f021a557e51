// Wavefront OBJ.
//
// Read: v, f (a, a/b, a//c, a/b/c; negative indices count from the last vertex), l, o for components, and vn if each
// face gives each vertex the normal of the same index. FileContents::passed_over tells of everything else. Written: v,
// vn, f, l and o. The format has no velocity and no attributes but normals. Format: Wavefront, "Advanced Visualizer"
// manual, appendix B1.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// If every face belongs to an object `component_N`, these become the components. Normals become the attribute `N`.
///
/// errors  not a text file; a damaged line, with its number
FileContents parseObj(std::span<const std::byte> bytes, const std::string& file);

/// Writes positions with as many digits as needed to read the same floats, and vertex normals: the attribute `N` of
/// three floats, or vertexNormals() without it. Leaves out velocity and other attributes. Each component becomes an
/// object `component_N`: faces are sorted by component and keep their order within it.
void encodeObj(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Writes each curve as one `l`; a closed curve ends with its first vertex.
void encodeObj(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
