// Reads and writes particles, meshes and curves. The extension selects the format; the manual lists them. Needs the
// target betamesh::io.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// What to do with particles whose position or velocity is NaN or infinite.
enum class OnBadParticle { error, drop };

/// The axis that points up.
enum class UpAxis { y, z };

/// How particle files are read. The defaults take every particle as it is in the file.
///
/// Particles are chosen by the numbers in the file: those in any of the grids and any of the groups, inside the box,
/// for which the condition is true. Then, with R the identity, or for up axis z the rotation (x, y, z) -> (x, z, -y):
///   positions       scale R (P - origin)
///   velocities      scale velocity_scale time_scale R v
///   accelerations   scale time_scale² R a, of attributes named accel or acceleration with three floats
///   normals         R N, of attributes named N, normal or normals with three floats
/// Other attributes keep their numbers.
struct ParticleInput {
    std::string velocity{};  ///< an attribute of three floats, or three of one float separated by commas; empty: the
                             ///< first usual name, see the manual. A name that is given must exist
    std::string id{};        ///< a whole-number attribute, which must exist; empty: `id`, if it exists
    std::string where{};     ///< condition such as `type == 1 && P.y > 0.5`; empty: none
    std::optional<std::array<double, 6>> box{};  ///< lowest x y z and highest x y z, both inside; units of the file
    std::vector<std::string> group{};            ///< point groups; empty: all particles
    std::vector<std::string> grid{};             ///< point grids of .vdb, prims of .usda; empty: all. Objects of .abc;
                                                 ///< empty: the only one
    OnBadParticle on_bad_particle = OnBadParticle::error;
    double scale = 1;           ///< world units per unit of the file
    double velocity_scale = 1;  ///< corrects the unit of velocities
    double time_scale = 1;      ///< simulated seconds per second of playback
    UpAxis up_axis = UpAxis::y;
    Vec3 origin{0, 0, 0};           ///< subtracted from positions in double precision; units of the file
    std::optional<double> frame{};  ///< of a file with time samples; nullopt: that of its name (.usda), or the first

    /// Are all members equal?
    bool operator==(const ParticleInput&) const = default;
};

/// How a mesh becomes a level set, the .vdb file of a mesh.
struct LevelSetOptions {
    double voxel = 0;                ///< size of a voxel, world units; 0: the median length of the edges of the mesh
    double band = 3;                 ///< voxels on each side of the surface that have a distance, at least 1
    bool velocity = false;           ///< write a grid of velocities, too
    std::uint64_t memory_limit = 0;  ///< bytes that may be needed; 0: as many as can be allocated
};

/// Is called with a warning: a sentence without its full stop.
using WarningHandler = std::function<void(const std::string&)>;

/// How files are written. Formats without a place for a frame rate, a frame or a unit of length leave these out.
/// Attributes whose names a format cannot store, or uses itself, get other names: "a b" becomes "a_b".
///
/// For up axis z, positions, velocities, accelerations (attributes named accel or acceleration) and normals (N, normal,
/// normals) are rotated as they are written: (x, y, z) -> (x, -z, y), the inverse of ParticleInput::up_axis z. No bit
/// of a number changes but its sign.
struct WriteOptions {
    double frames_per_second = 24;
    std::optional<int> frame{};  ///< frame number, which is the time of the file in frames; nullopt: a still
    UpAxis up_axis = UpAxis::y;  ///< of the file; in memory y is up
    double meters_per_unit = 1;  ///< length of a world unit in metres
    LevelSetOptions level_set{};
    const WarningHandler* warn = nullptr;  ///< gets a sentence about what the file does not show; may be null
};

/// Reads a file in the format of its extension; the manual lists them.
///
/// out     the chosen particles in the order of the file, in world units; validate() has passed
/// same    rows for the same bytes
/// errors  an unknown extension (the message lists the known ones); a file that is missing or damaged; attributes,
///         groups and grids that are asked for and not there; a chosen particle that is not finite, with its row in the
///         file, unless such particles are to be dropped. Messages begin with the file's name
Particles readParticles(const std::filesystem::path& path, const ParticleInput& input = {});

/// Reads only the given rows (ascending) of the chosen particles. The other ones are checked, too, but never all in
/// memory at once, except for JSON geometry of Houdini, which stores one attribute after another.
Particles readParticles(const std::filesystem::path& path, const ParticleInput& input,
                        const std::vector<std::uint32_t>& rows);

/// Writes the format of the extension. The file appears under its name only when it is complete. Velocity is named `v`
/// (PLY and tables: vx vy vz; VTK: velocity), the id `id`.
///
/// errors  an extension whose format cannot be written or does not hold particles; an id of more bits than the format
///         has
void writeParticles(const std::filesystem::path& path, const Particles& particles, const WriteOptions& options = {});

/// Reads a file in the format of its extension; the manual lists them. Polygons with more than three corners are
/// split into fans of triangles.
///
/// in      frame: as ParticleInput::frame
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         mesh. Messages begin with the file's name
Mesh readMesh(const std::filesystem::path& path, std::optional<double> frame = {});

/// Writes the format of the extension. The file appears under its name only when it is complete. Positions are rounded
/// to float. Velocity is always written (zeros if the mesh has none), so that all frames of a sequence have the same
/// attributes. Formats without a place for it leave it out. Components become a face property in .ply, a primitive
/// attribute in .bgeo, cell data in .vtp, a primvar in .usda, a parameter of faces in .abc, an object `component_N`
/// each in .obj. A .vtp, .usda, .abc or .obj has vertex normals: the attribute `N` of three floats, or vertexNormals()
/// if there is none. A .vdb is a level set, see LevelSetOptions.
///
/// errors  an extension whose format cannot be written or does not hold meshes; numbers that are not finite; a file
///         that cannot be written; MemoryError if a level set would exceed LevelSetOptions::memory_limit
void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options = {});
/// Writes points with a radius (`pscale` in formats of Houdini, `radius` in others), velocity and id. Ids that the
/// format cannot hold are left out.
///
/// errors  a format that cannot hold a radius
void writeSpheres(const std::filesystem::path& path, const Spheres& spheres, const WriteOptions& options = {});
/// Reads the edges of a .ply, open polygons of Houdini's formats, lines of an .obj or of VTK's files.
///
/// in      frame: as ParticleInput::frame
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         curves. Messages begin with the file's name
Curves readCurves(const std::filesystem::path& path, std::optional<double> frame = {});

/// Writes the format of the extension, but not .svg. The file appears under its name only when it is complete.
/// Positions are rounded to float. Velocity is always written (zeros if the curves have none), except to .obj.
void writeCurves(const std::filesystem::path& path, const Curves& curves, const WriteOptions& options = {});

}  // namespace betamesh
