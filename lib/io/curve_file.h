// Formats for curves.

#pragma once

#include "betamesh/io.h"

#include <filesystem>
#include <optional>

namespace betamesh {

/// Like readCurves(), for those who judge the curves: positions and velocities may be not finite.
Curves readUncheckedCurves(const std::filesystem::path& path, std::optional<double> frame = {});

/// Throws Error unless curves can be written in the format of this extension, .svg included. Does not access the disk.
void requireCurveExtension(const std::filesystem::path& path);

}  // namespace betamesh
