// Formats for curves.

#pragma once

#include "betamesh/io.h"

#include <filesystem>

namespace betamesh {

/// Throws Error unless curves can be written in the format of this extension, .svg included. Does not access the disk.
void requireCurveExtension(const std::filesystem::path& path);

}  // namespace betamesh
