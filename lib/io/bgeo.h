// Classic Houdini geometry: .bgeo version 5, binary, big-endian. Houdini wrote it up to version 11; partio,
// SPlisHSPlasH and many solvers still do.
//
// Read: points, point attributes (float, int, vector; strings are skipped), polygons and particle systems, and the
// integer primitive attribute `component`; gzip is decompressed. Written: the same, without particle systems. Format:
// "GPD, version 5", once shipped with Houdini, and files of Houdini, partio and SPlisHSPlasH. The layout is described
// in bgeo.cpp.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// errors  a damaged file, with the byte offset; the JSON formats of Houdini 12 and later, with advice
FileContents parseBgeo(Cursor in, const ReadOptions& options = {});

void encodeBgeo(ByteWriter& out, const Particles& particles, const std::string& file);
void encodeBgeo(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Writes each curve as an open polygon; a closed curve ends with its first point.
void encodeBgeo(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
