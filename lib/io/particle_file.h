// Reads particles with a summary of their file, or their positions alone, block by block.

#pragma once

#include "betamesh/error.h"
#include "betamesh/io.h"
#include "io/file_contents.h"
#include "io/particle_input.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

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

/// The same with the attributes that are not the id: blocks of particles without velocity and id.
void visitAttributes(const std::filesystem::path& path, const ParticleInput& input,
                     const std::function<void(const Particles&)>& visit);

/// The row in its file of a particle, given its row among the chosen ones. Reads the file if some may be left out.
std::uint64_t rowInFile(const std::filesystem::path& path, const ParticleInput& input, std::uint64_t chosen_row);

/// The message of an error about a chosen particle, with its row in the file.
std::string withRowInFile(const ParticleError& error, const std::filesystem::path& path, const ParticleInput& input);

/// The attributes of the particles in a file, without rows; nullopt if it has no particles. Reads no more than it has
/// to.
///
/// errors  those of readParticles()
std::optional<std::vector<Attribute>> attributesWithoutRows(const std::filesystem::path& path,
                                                            const ParticleInput& input);

/// Whether the file stores positions in double precision. Reads no more than it has to.
bool hasDoublePositions(const std::filesystem::path& path, std::optional<double> frame = {});

/// The localOrigin() of all positions in the file, in its units, if it stores them in double precision; zero otherwise.
/// Nothing if it has no particles whose position is finite. frame: as ParticleInput::frame.
std::optional<Vec3> localOriginOf(const std::filesystem::path& path, std::optional<double> frame = {});

/// The times, in frames, at which a file has other particles than before, ascending; with the kind mesh, another
/// surface, or other particles if it has no mesh. Empty: the file has no times.
///
/// errors  those of reading the file
std::vector<double> sampleTimes(const std::filesystem::path& path, const ParticleInput& input,
                                FileKind kind = FileKind::particles);

/// Throws Error unless particles can be written in the format of this extension. Does not access the disk.
void requireParticleExtension(const std::filesystem::path& path);

}  // namespace betamesh
