// Houdini's geometry files: points, polygons and their attributes, as written since Houdini 12 (.bgeo, .geo and
// .bgeo.sc) and before (the classic format, io/bgeo.h).

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_contents.h"

namespace betamesh {

/// Reads geometry of any of Houdini's formats, which are told apart by their first bytes: JSON in binary or as text,
/// the .sc container, the classic format; each may be inside gzip.
///
/// Points, point attributes and point groups come out as follows. All numeric attributes are read; fpreal64 is rounded
/// to float and int64 to int32, or to float where it does not fit (FileContents::declared names the storage of the
/// file). The id keeps its 64 bits. The point group NAME becomes the integer attribute `group:NAME` of ones and zeros.
/// Polygons become fans of triangles, open polygons edges; `component` is one integer for each polygon. Text
/// attributes and attributes of vertices, other attributes of primitives and of the whole geometry are passed over.
/// Volumes are no particles: where there are no polygons, the points that volumes alone refer to are left out.
///
/// errors  a damaged file, with the byte; packed primitives, whose points are stored elsewhere; when faces are read,
///         primitives other than polygons and particle systems
FileContents parseHoudini(Cursor in, const ReadOptions& options = {});

// Binary JSON as Houdini 16 and later read it, without compression. `v` is a vector, `N` a normal, `Cd` a colour;
// the integer attribute `group:NAME` becomes the point group NAME if all its numbers are 0 or 1.
// same    bytes for the same input
void encodeBgeoJson(ByteWriter& out, const Particles& particles, const std::string& file);
void encodeBgeoJson(ByteWriter& out, const Mesh& mesh, const std::string& file);
/// Each line as an open polygon; a closed one ends with the point that it begins with.
void encodeBgeoJson(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
