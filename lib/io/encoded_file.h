// Output files of an encoder, compressed as their extension says.

#pragma once

#include "io/bytes.h"
#include "io/output_file.h"

#include <filesystem>
#include <functional>

namespace betamesh {

/// Creates a file and fills it by calling encode, through gzip if the name ends in .gz, in a Blosc container if it ends
/// in .sc. The caller has to commit() it.
OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);
/// The same, and commits the file.
void writeEncoded(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);

}  // namespace betamesh
