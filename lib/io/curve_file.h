// Curves on disk, in whichever format the extension says.

#pragma once

#include "betamesh/curves.h"

#include <filesystem>

namespace betamesh {

/// Reads the edges of a .ply, open polygons of a .bgeo or lines of an .obj.
///
/// errors  an unknown extension (lists the known ones); a file that is missing, damaged or of another
///         kind: the text begins with the file's name
Curves readCurves(const std::filesystem::path& path);

/// Writes .ply, .bgeo, .bgeo.gz, .bgeo.sc, .bhclassic or .obj; nothing stands under that name before it is complete.
/// Positions are rounded to float. Velocity is always declared (zeros where the curves have none).
void writeCurves(const std::filesystem::path& path, const Curves& curves);

/// Throws the Error for an extension that neither curves nor pictures of them have, without touching the disk.
void requireCurveExtension(const std::filesystem::path& path);

}  // namespace betamesh
