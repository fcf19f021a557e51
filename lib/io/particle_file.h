// Particle frames on disk, in whichever format the extension says.

#pragma once

#include "betamesh/particles.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace betamesh {

/// Which attributes of a file are the velocity and the id. Empty: the usual names, in this order:
/// v, velocity, vel (PLY: vx vy vz and velocity_x … too) and id. A name that is given must exist.
struct AttributeNames {
    std::string velocity;
    std::string id;
};

/// Reads .bgeo, .bgeo.gz, .bgeo.sc and .geo (Houdini's JSON or its classic format), .ply and .vdb.
///
/// out     valid particles: validate() has passed; rows in the order of the file
/// same    rows for the same bytes
/// errors  an unknown extension (lists the known ones); a file that is missing, damaged or of another
///         kind: the text begins with the file's name
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names = {});

/// The same of some rows, ascending. The others are looked at, too, but never all in memory, save for Houdini's JSON,
/// which stores attribute after attribute.
Particles readParticles(const std::filesystem::path& path, const AttributeNames& names,
                        const std::vector<std::uint32_t>& rows);

/// Calls visit(positions) for all particles, some thousands at a time in the order of their rows; finite ones.
void forPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit);

/// Loads what reading such a file takes: done before memory is limited, it does not count.
void prepareToReadParticles(const std::filesystem::path& path);

/// Writes .bgeo, .bgeo.gz, .bgeo.sc, .bhclassic, .ply or .vdb; nothing stands under that name before it is complete.
/// Velocity becomes `v` (PLY: vx vy vz), the id becomes `id`. An id that the format cannot hold
/// (.ply and .bhclassic: 32 bits) is an error.
void writeParticles(const std::filesystem::path& path, const Particles& particles);

/// Throws the Error for an unknown extension without touching the disk.
void requireParticleExtension(const std::filesystem::path& path);

}  // namespace betamesh
