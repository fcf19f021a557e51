// Text files of USD: .usda in and out.

#pragma once

#include "betamesh/io.h"
#include "io/bytes.h"
#include "io/file_contents.h"

#include <string>
#include <vector>

namespace betamesh {

/// One prim `/geometry/mesh` or `/geometry/points` of type Mesh or Points. With options.frame the values are time
/// samples at that frame, as value clips need them; without it they are default values. Every attribute is declared
/// before the first value, so that the beginning of a file tells what it holds (see usd_clips.h).
///
/// Positions become `points`, velocity `velocities` (per second), ids `ids`, an attribute N of three floats `normals`
/// (a mesh without it gets vertexNormals()), accel `accelerations`, Cd `primvars:displayColor`, pscale (a radius)
/// `widths`, and any other attribute a primvar of usdNames(). Components become the primvar `component` of faces.
/// Floats are written with as few digits as give the same float again.
///
/// errors  those of requireWritable()
void encodeUsda(ByteWriter& out, const Mesh& mesh, const std::string& file, const WriteOptions& options);
void encodeUsda(ByteWriter& out, const Particles& particles, const std::string& file, const WriteOptions& options);

/// The opening of a .usda file: its first line and the metadata of the stage from frame `first` to `last`, both nullopt
/// for a file without time. more: further lines of metadata.
std::string usdaHeader(const WriteOptions& options, std::optional<int> first, std::optional<int> last,
                       const std::string& more = "");

/// The names of attributes as identifiers of USD, which are distinct: characters other than letters, digits and
/// underscores become underscores. `displayColor` and `component` are those of Cd and of Mesh::component.
///
/// same    names that are identifiers keep theirs
std::vector<std::string> usdNames(const std::vector<std::string>& names);

/// Reads the prims of type Points, or else the points of those of type Mesh; as a surface, the prims of type Mesh. A
/// time sample is taken at options.frame: the latest until then, as USD does. Without that it is the one at the frame
/// in the file's name, or else the earliest. Names are those of encodeUsda() in
/// reverse. Transforms of the prims and their parents are applied. A prim without velocities or accelerations that
/// others have gets zeros, with a warning; other attributes that not all prims have are passed over.
///
/// in      options.grids: paths or names of the prims to read; empty: all
/// errors  text that cannot be parsed, by line; references, payloads, sublayers, variants, inherits and value clips,
///         which are not composed; a file without points; a prim that is asked for and not there; transforms other than
///         translations, scales and matrices; arrays whose lengths do not match
/// source  "Usda File Format" in the documentation of OpenUSD
FileContents parseUsda(Cursor in, const ReadOptions& options = {});

/// The times of the samples of points and transforms that parseUsda() reads, ascending, each once.
std::vector<double> usdaSampleTimes(Cursor in, const ReadOptions& options = {});

}  // namespace betamesh
