// Which format a name asks for, and writing it.

#pragma once

#include "io/bytes.h"
#include "io/output_file.h"

#include <filesystem>
#include <functional>

namespace betamesh {

/// bgeo: any format of Houdini to read, its JSON to write; bhclassic: its classic format to write.
enum class Extension { bgeo, bhclassic, ply, vdb, obj, svg };

/// By the name alone, as below; false for names of no format.
bool isVdb(const std::filesystem::path& path);

/// By the name alone, in upper or lower case; .bgeo.gz, .bgeo.sc and .geo are .bgeo. Throws Error that lists the
/// known ones.
Extension particleExtension(const std::filesystem::path& path);  ///< .bgeo .bhclassic .ply .vdb
Extension meshExtension(const std::filesystem::path& path);      ///< .bgeo .bhclassic .obj .ply
Extension curveExtension(const std::filesystem::path& path);     ///< .bgeo .bhclassic .obj .ply .svg
Extension anyExtension(const std::filesystem::path& path);       ///< .bgeo .bhclassic .obj .ply .vdb

/// Writes what encode writes, through gzip when the name ends in .gz, in Houdini's container when it ends
/// in .sc. All that is left to do is to commit().
OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);
/// The same with commit(): whole or not at all.
void writeEncoded(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);

}  // namespace betamesh
