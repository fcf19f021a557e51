// How far a job is, in the words of whoever listens.

#pragma once

#include "batch/report/report.h"

#include <chrono>
#include <string>
#include <string_view>

namespace betamesh {

enum class ProgressKind {
    automatic,  ///< a bar when stderr is a terminal, otherwise lines
    bar,        ///< on stderr
    lines,      ///< a line a frame on stderr
    none,
    openjd,   ///< openjd_progress, openjd_status, openjd_fail
    tractor,  ///< TR_PROGRESS
    json      ///< an object a frame, see progressJson()
};

/// auto, bar, none, openjd, tractor, json; throws Error for another word.
ProgressKind progressKind(std::string_view word);

/// Told about every frame as it ends; one thread at a time.
class Progress {
public:
    /// so_far: frames, and those of them that ended before. stdout_is_taken: lines for machines go to stderr instead.
    Progress(ProgressKind kind, const JobProgress& so_far, bool stdout_is_taken);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void frameEnded(const FrameReport& report);

    /// The job did not do all it was asked for.
    void jobFailed(const std::string& why);

private:
    ProgressKind kind_;
    JobProgress job_;
    std::size_t worked_ = 0;  ///< frames that took time
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::FILE* farm_;  ///< where machines read
};

}  // namespace betamesh
