// What is left out where a pattern of this program or of the shell stands for all frames on disk.

#pragma once

#include "batch/job/frames.h"

#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// Warnings of what is left out where a pattern stands for all frames on disk: sub-frames, numbers that are padded
/// otherwise, and gaps, which may come from a simulation that failed, unless the step is constant.
///
/// in      frames: those of framesOnDisk()
///         advice: the end of the sentence about gaps
std::vector<std::string> leftOutOnDisk(const FramePattern& pattern, const std::vector<int>& frames,
                                       std::string_view advice);

/// Logs leftOutOnDisk() for the patterns among the names that filesNamed() reads.
void warnOfLeftOut(const std::vector<std::string>& names);

/// The files without the manifests of others among them, which the log names: a shell gives both for mesh/*.0024.*. A
/// manifest whose output is not among the files stays.
std::vector<std::string> withoutManifests(const std::vector<std::string>& files);

}  // namespace betamesh
