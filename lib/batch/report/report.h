// Reports as JSON: of frames, progress, checks, coherence and file contents.

#pragma once

#include "batch/job/frame_task.h"
#include "batch/job/provenance.h"
#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "io/file_info.h"
#include "io/particle_input.h"
#include "mesh/jump_sites.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// Wall-clock seconds of each stage of a frame.
struct StageSeconds {
    std::array<double, kStages> of_stage{};
    double total = 0;

    double& operator[](Stage stage) { return of_stage[static_cast<std::size_t>(stage)]; }
    double operator[](Stage stage) const { return of_stage[static_cast<std::size_t>(stage)]; }
};

/// Calls visit(stage) for all stages in order.
template <typename Visit>
void forStages(const Visit& visit) {
    for (std::size_t i = 0; i < kStages; ++i) visit(static_cast<Stage>(i));
}

/// Results of a frame in two dimensions, which replace `skin`, `measure` and `triangles`.
struct PlaneFrameResult {
    PlaneReport skin;
    CurveMeasure measure;
    std::size_t edges = 0;
};

/// What happened to one frame. Written beside its mesh as the manifest NAME.json. Lengths in world units.
struct FrameResult {
    int frame = 0;
    std::string input;
    std::string output;
    FrameStatus status = FrameStatus::ok;
    std::string error;                ///< why the frame failed
    bool input_missing = false;       ///< the frame was skipped because it has no input
    std::vector<std::string> preset;  ///< names of presets, as in the configuration
    double radius = 0;
    double spacing = 0;
    double frame_spacing = 0;  ///< the frame's own spacing; 0: not measured
    double skin_depth = 0;     ///< distance from the outermost particles to the surface; 0: surface of the balls
    PredicateKind predicates = PredicateKind::exact;
    SkinReport skin;
    MeshMeasure measure;
    std::optional<PlaneFrameResult> plane;
    std::uint64_t particles_read = 0;     ///< in the input, of which some may not be chosen
    std::uint64_t particles_dropped = 0;  ///< not finite, and left out
    std::vector<InputPart> input_parts;   ///< what the input contains
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::size_t spheres = 0;
    StageSeconds seconds;
    std::uint64_t peak_bytes = 0;  ///< the most memory the whole process has held so far
    std::vector<std::string> warnings;
    std::optional<Provenance> provenance;  ///< set if the frame was written

    std::size_t particles() const { return plane ? plane->skin.particles : skin.particles; }
};

/// The JSON of a frame, for its manifest and for --json. One line without a line break, as from all functions below.
std::string manifestJson(const FrameResult& result);

/// The JSON of a manifest on disk with another provenance.
std::string manifestWith(const Provenance& provenance, const std::filesystem::path& manifest);

/// Progress of a job.
struct JobProgress {
    std::size_t frames = 0, ended = 0, failed = 0;
    std::uint64_t particles = 0;         ///< of the frames that were written
    double seconds = 0;                  ///< since the start
    std::optional<double> seconds_left;  ///< estimated from the frames so far
};

std::string progressJson(const JobProgress& progress);

/// The JSON of a planned frame, for --dry-run.
std::string taskJson(const FrameTask& task);

/// Reads a manifest; nullopt if the file does not exist or is incomplete. Members that it lacks keep their defaults.
/// errors  not a regular file
std::optional<FrameResult> readManifest(const std::filesystem::path& file);

/// The JSON of `betamesh info`. frame: of the time sample that it is about, if the file has several; spacing: particle
/// spacing in world units.
std::string infoJson(const std::string& file, std::optional<int> frame, const FileInfo& info,
                     std::optional<double> spacing);

/// Whether the particles are inside a mesh. Lengths in world units.
struct ParticleCheck {
    std::string file;
    std::size_t particles = 0;
    std::size_t spheres = 0;  ///< beside the mesh, which may contain particles too
    double radius = 0;        ///< ball radius; 0: not given
    FaultCount outside;       ///< particles farther outside than the tolerance
    double farthest = 0;      ///< distance of the particle farthest outside
    std::size_t farthest_row = 0;
    Vec3 farthest_position{0, 0, 0};
};

/// The result of `betamesh check` for one file.
struct CheckReport {
    std::string file;
    std::optional<int> frame;  ///< of the time sample, if the file has several
    std::string error;         ///< why a file could not be read; then nothing else is set
    MeshCheck check;
    std::optional<CurveCheck> curves;  ///< replaces `check` if the file contains curves
    std::optional<ParticleCheck> particles;
    std::vector<std::string> faults;  ///< names; empty if there are none, or if a file could not be read
};

std::string checkJson(const CheckReport& report);

/// Distance between the surfaces at two moments. Lengths in world units.
struct CoherenceReport {
    std::string from, to;                     ///< mesh files, or times after a frame of a pipeline
    std::optional<int> from_frame, to_frame;  ///< of the time samples, if the files have several
    std::string error;                        ///< why a file could not be read; then nothing below is set
    SurfaceDistance distance;
    std::optional<ParticleMotion> particles;  ///< if it was measured
    std::vector<JumpSite> places;             ///< where the surface moved farther than the particles
    double radius = 0;                        ///< ball radius, known or estimated; set if there are places

    /// A displacement as a multiple of that of the fastest particle; nullopt if no particle moved.
    std::optional<double> ratio(double displacement) const {
        if (!particles || !(particles->max > 0)) return std::nullopt;
        return displacement / particles->max;
    }
    /// The expected displacement of the surface at a place: that of the fastest particle, or, if the topology changes
    /// there, the square root of that times the radius, because round surfaces that touch approach each other as the
    /// square root of time.
    double expectedAt(const JumpSite& place) const;
    /// The largest ratio of a jump to the expected displacement; infinite if the surface jumps but no particle moves.
    double largestExpectedRatio() const;
};

/// Infinite numbers become null.
std::string coherenceJson(const CoherenceReport& report);

/// Reads lines written by coherenceJson(); sets `from`, `to` and `distance.max` only.
/// errors  the file cannot be read or contains anything else
std::vector<CoherenceReport> readCoherence(const std::filesystem::path& file);

}  // namespace betamesh
