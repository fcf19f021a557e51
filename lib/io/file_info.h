// What is in a particle or mesh file, for a person to look at.

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace betamesh {

enum class FileKind { particles, mesh, curves };

/// One attribute as the file declares it, position included.
struct AttributeInfo {
    std::string name;
    std::string type;              ///< in the words of the format: "float", "vector", "int64"
    std::uint32_t components = 1;  ///< numbers in a row
    std::string codec;             ///< how the numbers are packed, empty when plainly
};

/// A file with polygons is a mesh, one with edges or open polygons alone holds curves, any other particles.
struct FileInfo {
    FileKind kind = FileKind::particles;
    std::string format;       ///< "houdini json binary, blosc", "ply binary_little_endian", "vdb points, blosc"
    std::uint64_t bytes = 0;  ///< on disk
    std::size_t points = 0;
    std::size_t triangles = 0;  ///< after polygons were split into fans
    std::size_t edges =
        0;  ///< of two-dimensional curves: `element edge` of a .ply, open polygons of a .bgeo, lines of an .obj
    Vec3f lower{0, 0, 0};  ///< of the box around all points, world units; zeros without points
    Vec3f upper{0, 0, 0};
    std::vector<AttributeInfo> attributes;  ///< of the points, in the order of the file
};

/// Reads the whole file and reports on it. .bgeo .ply .vdb .obj.
///
/// errors  as readParticles and readMesh
FileInfo inspectFile(const std::filesystem::path& path);

}  // namespace betamesh
