// Classic Houdini geometry (.bgeo, version 5, big-endian), as it was written until Houdini 11 and still is by
// partio, SPlisHSPlasH and many solvers.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// Points, point attributes (float, int, vector; strings are passed over) and polygons with their
/// attribute `component`, if it is one integer. Gzip is undone.
///
/// errors  a damaged file, with the byte; other formats
FileContents parseBgeo(Cursor in, const ReadOptions& options = {});

void encodeBgeo(ByteWriter& out, const Particles& particles, const std::string& file);
void encodeBgeo(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Each line as an open polygon; a closed one ends with the point that it begins with.
void encodeBgeo(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
