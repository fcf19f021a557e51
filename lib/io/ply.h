// Stanford PLY.
//
// Read: ascii and both binary encodings; elements vertex, face and edge. Other elements and lists are skipped.
// Written: binary little-endian.
// Format: Greg Turk, "The PLY Polygon File Format", 1994. Type names with sizes (int32, float64) are later usage.
// Files: the reader is ply_reader.cpp with ply_header and ply_numbers, the writer ply_writer.cpp.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// Points are the element `vertex`: x y z, or px py pz, are the position, other scalar properties become attributes.
/// Adjacent properties a_x a_y (a_z a_w) or a_0 a_1 … of the same kind become one attribute a; vx vy vz becomes v, nx
/// ny nz the normals N, which are written so. Faces are the list vertex_indices or vertex_index of the element `face`,
/// with the integer property `component`; edges are vertex1 and vertex2 of the element `edge`.
///
/// errors  a damaged file, with the header line or byte offset
FileContents parsePly(Cursor in, const ReadOptions& options = {});

void encodePly(ByteWriter& out, const Particles& particles, const std::string& file);
void encodePly(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Writes edges as the element `edge` with int vertex1 vertex2.
void encodePly(ByteWriter& out, const Curves& curves, const std::string& file);
void encodePly(ByteWriter& out, const Spheres& spheres, const std::string& file);

}  // namespace betamesh
