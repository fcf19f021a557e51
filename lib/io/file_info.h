// Summary of a particle, mesh or curve file, for the info command.

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace betamesh {

enum class FileKind { particles, mesh, curves };

/// One point attribute as the file declares it; position is one of them.
struct AttributeInfo {
    std::string name;
    std::string type;              ///< as the format names it: "float", "vector", "int64"
    std::uint32_t components = 1;  ///< numbers per row
    std::string codec;             ///< how the numbers are compressed; empty: they are not
};

/// A file with polygons is a mesh, one with edges or open polygons only contains curves, any other particles.
struct FileInfo {
    FileKind kind = FileKind::particles;
    std::string format;       ///< "bgeo V5, gzip", "ply binary_little_endian", "vdb points, blosc"
    std::uint64_t bytes = 0;  ///< on disk
    std::size_t points = 0;
    std::size_t triangles = 0;  ///< after splitting polygons into fans
    std::size_t edges = 0;      ///< of curves: `element edge` of a .ply, open polygons of a .bgeo, lines of an .obj
    Vec3f lower{0, 0, 0};       ///< bounding box of all points, world units; zeros without points
    Vec3f upper{0, 0, 0};
    std::vector<AttributeInfo> attributes;  ///< point attributes in the order of the file
};

/// Reads a whole .bgeo, .ply, .vdb or .obj file and summarises it.
///
/// errors  as readParticles() and readMesh()
FileInfo inspectFile(const std::filesystem::path& path);

}  // namespace betamesh
