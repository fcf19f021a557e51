// Converts a file from one format to another.

#pragma once

#include "io/file_contents.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// What was written, and what of the input was not.
struct Conversion {
    FileKind kind = FileKind::particles;
    std::size_t points = 0, triangles = 0, edges = 0;
    std::vector<std::string> warnings;  ///< a sentence for each loss, without the names of the files
};

/// How a file is converted.
struct ConversionOptions {
    WriteOptions write{};  ///< of the output; its frame rate, up axis and unit are replaced by those below
    FileUnits units{};     ///< of the output; nullopt: those of the input if both formats store them
    std::optional<UpAxis> input_up_axis{};  ///< nullopt: as the input says, or else y
    std::vector<std::string> grids{};       ///< as ReadOptions::grids
    OnBadParticle on_bad_particle = OnBadParticle::error;
    std::optional<double> frame{};  ///< as ReadOptions::frame
};

/// Reads particles, a mesh or curves in the format of the file's contents, and writes the same in the format of the
/// output's extension. A file with faces is a mesh, one with edges only contains curves, any other particles. Where the
/// up axis of the output is that of the input, or neither is known, nothing is rotated.
///
/// same    positions and velocities bit for bit, and triangles; attributes that both formats can hold keep their type
/// errors  an output format that cannot hold what the input contains; a level set of an open mesh without an inside;
///         those of readers and writers
Conversion convertFile(const std::filesystem::path& from, const std::filesystem::path& to,
                       const ConversionOptions& options = {});

}  // namespace betamesh
