// How far a job is, in the words of whoever listens.

#pragma once

#include "batch/report.h"

#include <string>
#include <string_view>

namespace betamesh {

enum class ProgressKind {
    automatic,  ///< a bar when stderr is a terminal, otherwise lines
    bar,        ///< on stderr
    lines,      ///< a line a frame on stderr
    none,
    openjd,  ///< openjd_progress, openjd_status, openjd_fail
    tractor  ///< TR_PROGRESS
};

/// auto, bar, none, openjd, tractor; throws Error for another word.
ProgressKind progressKind(std::string_view word);

/// Told about every frame as it ends; one thread at a time.
class Progress {
public:
    /// stdout_is_taken: lines for farm engines go to stderr instead.
    Progress(ProgressKind kind, std::size_t frames, bool stdout_is_taken);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void frameEnded(const FrameReport& report);

    /// The job did not do all it was asked for.
    void jobFailed(const std::string& why);

private:
    ProgressKind kind_;
    std::size_t frames_;
    std::FILE* farm_;  ///< where farm engines read
    std::size_t ended_ = 0;
    std::size_t failed_ = 0;
};

}  // namespace betamesh
