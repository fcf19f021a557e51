// Reads and writes particles; the extension selects the format.

#pragma once

#include "betamesh/particles.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace betamesh {

/// Names of the velocity and id attributes in a file. Empty: the first that exists of v, velocity, vel (in PLY also vx
/// vy vz and velocity_x …), and id. A velocity name that is given must exist.
struct AttributeNames {
    std::string velocity;
    std::string id;
};

/// Reads .bgeo (plain or gzip, classic), .ply and .vdb.
///
/// out     valid particles (validate() has passed) in the order of the file
/// same    rows for the same bytes
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         particles. Messages begin with the file's name
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names = {});

/// Reads only the given rows (ascending). The other rows are checked, too, but never all in memory at once.
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names,
                        const std::vector<std::uint32_t>& rows);

/// Calls visit(positions) for blocks of a few thousand particles, in the order of the file. Throws Error if a position
/// is not finite.
void forPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit);

/// Loads the libraries that reading this format needs. Call before limiting memory, so that they do not count.
void prepareToReadParticles(const std::filesystem::path& path);

/// Writes .bgeo, .bgeo.gz, .ply or .vdb. The file appears under its name only when it is complete.
/// Velocity is named `v` (PLY: vx vy vz), the id `id`.
///
/// errors  an id of more than 32 bits in PLY or BGEO
void writeParticles(const std::filesystem::path& path, const Particles& particles);

/// Throws Error unless particles can be written in the format of this extension. Does not access the disk.
void requireParticleExtension(const std::filesystem::path& path);

}  // namespace betamesh
