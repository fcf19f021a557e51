// Stanford PLY: ascii and both binary orders in, binary little-endian out.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// Points are the element `vertex`: x y z, any other scalars as attributes. Neighbours a_x a_y (a_z a_w) or
/// a_0 a_1 … of one kind become one attribute a; vx vy vz becomes v. Faces are the list vertex_indices or
/// vertex_index of the element `face`, the whole number `component` beside it; edges are vertex1 vertex2 of
/// the element `edge`. Other elements and lists are passed over.
FileContents parsePly(Cursor in, const ReadOptions& options = {});

void encodePly(ByteWriter& out, const Particles& particles, const std::string& file);
void encodePly(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Edges as `element edge`, int vertex1 vertex2.
void encodePly(ByteWriter& out, const Curves& curves, const std::string& file);
void encodePly(ByteWriter& out, const Spheres& spheres, const std::string& file);

}  // namespace betamesh
