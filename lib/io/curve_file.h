// Reads and writes curves; the extension selects the format.

#pragma once

#include "betamesh/curves.h"

#include <filesystem>

namespace betamesh {

/// Reads the edges of a .ply, open polygons of Houdini's formats, lines of an .obj or of VTK's files.
///
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         curves. Messages begin with the file's name
Curves readCurves(const std::filesystem::path& path);

/// Writes the format of the extension, but not .svg. The file appears under its name only when it is complete.
/// Positions are rounded to float. Velocity is always written (zeros if the curves have none), except to .obj.
void writeCurves(const std::filesystem::path& path, const Curves& curves);

/// Throws Error unless curves can be written in the format of this extension, .svg included. Does not access the disk.
void requireCurveExtension(const std::filesystem::path& path);

}  // namespace betamesh
