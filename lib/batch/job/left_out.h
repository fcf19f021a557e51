// What is left out where a pattern stands for all frames on disk.

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

}  // namespace betamesh
