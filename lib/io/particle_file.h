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

/// Reads a file in the format of its extension; fileFormats() lists them.
///
/// out     valid particles (validate() has passed) in the order of the file
/// same    rows for the same bytes
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         particles. Messages begin with the file's name
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names = {});

/// Reads only the given rows (ascending). The other rows are checked, too, but never all in memory at once, except for
/// JSON geometry of Houdini, which stores one attribute after another.
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names,
                        const std::vector<std::uint32_t>& rows);

/// Calls visit(positions) for blocks of particles, in the order of the file. Throws Error if a position
/// is not finite.
void visitPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit);

/// Writes the format of the extension. The file appears under its name only when it is complete. Velocity is named `v`
/// (PLY and tables: vx vy vz; VTK: velocity), the id `id`.
///
/// errors  an extension whose format cannot be written or does not hold particles; an id of more bits than the format
///         has
void writeParticles(const std::filesystem::path& path, const Particles& particles);

/// Throws Error unless particles can be written in the format of this extension. Does not access the disk.
void requireParticleExtension(const std::filesystem::path& path);

}  // namespace betamesh
