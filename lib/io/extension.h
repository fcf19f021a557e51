// File formats by extension, and writing a file in its format.

#pragma once

#include "io/bytes.h"
#include "io/output_file.h"

#include <filesystem>
#include <functional>

namespace betamesh {

enum class Extension { bgeo, ply, vdb, obj, svg };

/// Whether the extension is .vdb, in upper or lower case.
bool isVdb(const std::filesystem::path& path);

/// The format that a file name selects, in upper or lower case; .bgeo.gz counts as .bgeo. Throws Error with the
/// extensions allowed, which are named on the right.
Extension particleExtension(const std::filesystem::path& path);  ///< .bgeo .ply .vdb
Extension meshExtension(const std::filesystem::path& path);      ///< .bgeo .obj .ply
Extension curveExtension(const std::filesystem::path& path);     ///< .bgeo .obj .ply .svg
Extension anyExtension(const std::filesystem::path& path);       ///< .bgeo .obj .ply .vdb

/// Creates a file and fills it by calling encode, through gzip if the name ends in .gz. The caller has to commit() it.
OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);
/// The same, and commits the file.
void writeEncoded(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);

}  // namespace betamesh
