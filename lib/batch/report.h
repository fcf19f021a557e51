// What became of a frame, for people and for machines.

#pragma once

#include "io/file_info.h"
#include "skin/skin_frame.h"

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
    double write = 0;
    double total = 0;
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
    PredicateKind predicates = PredicateKind::exact;
    SkinReport skin;
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::size_t spheres = 0;
    StageSeconds seconds;
    std::uint64_t peak_bytes = 0;  ///< the most memory the whole process has held so far
    std::vector<std::string> warnings;
};

/// One line without a line break.
std::string reportJson(const FrameReport& report);

/// A line of --dry-run. One line without a line break.
std::string taskJson(int frame, const std::string& input, const std::string& output, const std::string& action);

/// Whether a report on disk says that its frame was written to the end: the report is the last file written.
bool isFinished(const std::filesystem::path& report_file);

/// One line without a line break. spacing: of particles, world units.
std::string infoJson(const std::string& file, const FileInfo& info, std::optional<double> spacing);

}  // namespace betamesh
