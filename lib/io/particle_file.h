// Reads and writes particles; the extension selects the format.

#pragma once

#include "betamesh/particles.h"
#include "io/particle_input.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace betamesh {

/// Reads a file in the format of its extension; fileFormats() lists them.
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

/// Particles with a summary of the file that they are from.
struct SummarisedParticles {
    Particles particles;
    InputSummary summary;
};

/// Like readParticles(). rows: those of the chosen particles to read; null: all.
SummarisedParticles readSummarised(const std::filesystem::path& path, const ParticleInput& input,
                                   const std::vector<std::uint32_t>* rows = nullptr);

/// Calls visit(positions) for blocks of the chosen particles, in the order of the file. Throws Error if one of their
/// positions is not finite, unless such particles are to be dropped.
void visitPositions(const std::filesystem::path& path, const ParticleInput& input,
                    const std::function<void(std::span<const Vec3f>)>& visit);
void visitPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit);

/// Whether the file stores positions in double precision. Reads no more than it has to.
bool hasDoublePositions(const std::filesystem::path& path);

/// Writes the format of the extension. The file appears under its name only when it is complete. Velocity is named `v`
/// (PLY and tables: vx vy vz; VTK: velocity), the id `id`.
///
/// errors  an extension whose format cannot be written or does not hold particles; an id of more bits than the format
///         has
void writeParticles(const std::filesystem::path& path, const Particles& particles);

/// Throws Error unless particles can be written in the format of this extension. Does not access the disk.
void requireParticleExtension(const std::filesystem::path& path);

}  // namespace betamesh
