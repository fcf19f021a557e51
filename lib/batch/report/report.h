// What became of a frame, for people and for machines.

#pragma once

#include "batch/job/plan.h"
#include "batch/job/provenance.h"
#include "io/file_info.h"
#include "mesh/coherence.h"
#include "mesh/curve_check.h"
#include "mesh/jump_sites.h"
#include "mesh/mesh_check.h"
#include "mesh/mesh_measure.h"
#include "planar/skin_plane.h"
#include "skin/pipeline.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

enum class FrameStatus {
    ok,
    empty,    ///< a mesh without triangles was written because there were no particles
    skipped,  ///< nothing was written, as asked
    failed    ///< nothing was written, see error
};

/// Seconds of wall clock.
struct StageSeconds {
    double read = 0;
    double structure = 0;
    double tessellate = 0;
    double smooth = 0;
    double velocity = 0;
    double picture = 0;
    double write = 0;
    double total = 0;
};

/// Of a frame in two dimensions, instead of `skin`, `measure` and `triangles`.
struct PlaneFrameReport {
    PlaneReport skin;
    CurveMeasure measure;
    std::size_t edges = 0;
};

/// Lengths in world units.
struct FrameReport {
    int frame = 0;
    std::string input;
    std::string output;
    FrameStatus status = FrameStatus::ok;
    std::string error;  ///< of a failed frame
    double radius = 0;
    double spacing = 0;
    double skin_depth = 0;  ///< how far the surface lies from the outermost particles; 0: on the balls
    PredicateKind predicates = PredicateKind::exact;
    SkinReport skin;
    MeshMeasure measure;
    std::optional<PlaneFrameReport> plane;
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::size_t spheres = 0;
    StageSeconds seconds;
    std::uint64_t peak_bytes = 0;     ///< the most memory the whole process has held so far
    std::vector<std::string> warnings;
    std::optional<Provenance> origin;  ///< of a frame that was written
};

/// One line without a line break.
std::string reportJson(const FrameReport& report);

/// How far a job is.
struct JobProgress {
    std::size_t frames = 0, ended = 0, failed = 0;
    std::uint64_t particles = 0;         ///< of frames that were written
    double seconds = 0;                  ///< since it began
    std::optional<double> seconds_left;  ///< guessed from the frames so far
};

/// One line without a line break.
std::string progressJson(const JobProgress& progress);

/// A line of --dry-run. One line without a line break.
std::string taskJson(const FrameTask& task);

/// A report on disk; nothing where there is none or it is cut. What it does not tell is as in an empty one.
std::optional<FrameReport> readReport(const std::filesystem::path& file);

/// One line without a line break. spacing: of particles, world units.
std::string infoJson(const std::string& file, const FileInfo& info, std::optional<double> spacing);

/// Where the particles of a mesh are. Lengths in world units.
struct ParticleCheck {
    std::string file;
    std::size_t particles = 0;
    std::size_t spheres = 0;  ///< beside the mesh, read with it
    double radius = 0;        ///< of the balls; 0: not given
    Found outside;            ///< farther than the tolerance
    double farthest = 0;      ///< distance of the farthest outside
    std::size_t farthest_row = 0;
    Vec3 farthest_position{0, 0, 0};
};

/// What was found in one mesh file.
struct CheckReport {
    std::string file;
    std::string error;  ///< of a mesh or particles that could not be read; then nothing else is filled in
    MeshCheck check;
    std::optional<CurveCheck> curves;  ///< of a file that holds curves, instead of `check`
    std::optional<ParticleCheck> particles;
    std::vector<std::string> faults;  ///< names; none where the mesh is good, or could not be read
};

/// One line without a line break.
std::string checkJson(const CheckReport& report);

/// How far the surface moved between two moments.
struct CoherenceReport {
    std::string from, to;                     ///< mesh files; or seconds after a frame of a pipeline
    std::string error;                        ///< of a file that could not be read; then nothing below is filled in
    SurfaceDistance distance;                 ///< world units
    std::optional<ParticleMotion> particles;  ///< if asked for
    std::vector<Place> places;                ///< where the surface went farther than particles, as asked for
    double radius = 0;                        ///< of the balls, world units, known or guessed; where there are places

    /// A way of the surface in those of the fastest particle, if that moved at all.
    std::optional<double> ratio(double way) const {
        if (!particles || !(particles->max > 0)) return std::nullopt;
        return way / particles->max;
    }
    /// How far the surface goes at a place, world units: as far as the fastest particle, or, where something meets,
    /// parts, opens or closes, the root of that times the radius, for round things that are a little apart approach in
    /// the root of time.
    double expectedAt(const Place& place) const;
    /// The jumps of places in what is expected of them, the largest; infinite where something jumps and nothing moves.
    double largestOfExpected() const;
};

/// One line without a line break. What is infinite becomes null.
std::string coherenceJson(const CoherenceReport& report);

/// Lines that coherenceJson() wrote: from, to, and of the distance its largest.
/// errors  a file that cannot be read or holds something else
std::vector<CoherenceReport> readCoherence(const std::filesystem::path& file);

}  // namespace betamesh
