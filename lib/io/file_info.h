// Summary of a particle, mesh or curve file, for the info command.

#pragma once

#include "betamesh/vec3.h"
#include "io/file_contents.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// A file with polygons is a mesh, one with edges or open polygons only contains curves, any other particles.
struct FileInfo {
    FileKind kind = FileKind::particles;
    std::string format;       ///< "houdini json binary, blosc", "ply binary_little_endian", "vdb points, blosc"
    std::uint64_t bytes = 0;  ///< on disk
    std::size_t points = 0;
    std::size_t triangles = 0;  ///< after splitting polygons into fans
    std::size_t edges = 0;      ///< of curves: `element edge` of a .ply, open polygons of a .bgeo, lines of an .obj
    Vec3f lower{0, 0, 0};       ///< bounding box of all points, world units; zeros without points
    Vec3f upper{0, 0, 0};
    std::vector<AttributeInfo> attributes;  ///< point attributes in the order of the file
    std::vector<VolumeInfo> volumes;        ///< of a .vdb file without points
    std::vector<std::string> groups;        ///< point groups
    std::vector<GridInfo> grids;            ///< of a .vdb file, or several sets of points of another one
    std::vector<std::string> passed_over;   ///< what else is in the file: "12 primitives of type PackedGeometry"
    std::vector<double> times{};            ///< in frames, of the time samples, ascending; empty: none are told
    std::string note;                       ///< says so if the extension is that of another format; else empty
};

/// Reads a whole file in the format of its contents, whatever its extension, and summarises it.
///
/// in      frame: as ParticleInput::frame
/// out     particles: if not null, gets the positions of a file of particles
/// errors  as readParticles() and readMesh()
FileInfo inspectFile(const std::filesystem::path& path, std::vector<Vec3f>* particles = nullptr,
                     std::optional<double> frame = {});

}  // namespace betamesh
