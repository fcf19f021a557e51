// Reports the progress of a job to people and to farm engines.

#pragma once

#include "batch/report/report.h"

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

enum class ProgressKind {
    automatic,  ///< a bar when stderr is a terminal, otherwise lines
    bar,        ///< on stderr
    lines,      ///< one line per frame on stderr
    none,
    openjd,   ///< openjd_progress, openjd_status, openjd_fail
    tractor,  ///< TR_PROGRESS
    json      ///< one object per frame, see progressJson()
};

/// The kind of a name: auto, bar, none, openjd, tractor or json.
/// errors  any other name
ProgressKind progressNamed(std::string_view name);

/// The names that progressNamed() knows with a separator between them.
std::string progressNames(std::string_view separator);

/// Prints the progress of a job as its frames end. Not for several threads at once.
class Progress {
public:
    /// in      so_far: the frames of the job, some of which may have ended before
    ///         stdout_is_taken: print lines for farm engines on stderr instead
    Progress(ProgressKind kind, const JobProgress& so_far, bool stdout_is_taken);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// outputs: the results of all outputs of one frame.
    void frameEnded(const std::vector<FrameResult>& outputs);

    /// Reports that the job did not finish all its frames.
    void jobFailed(const std::string& reason);

private:
    ProgressKind kind_;
    JobProgress job_;
    std::size_t processed_ = 0;  ///< frames that were not skipped
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::FILE* farm_stream_;  ///< where farm engines read
};

}  // namespace betamesh
