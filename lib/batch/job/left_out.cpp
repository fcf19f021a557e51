#include "batch/job/left_out.h"

#include "batch/report/log.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace betamesh {

std::vector<std::string> leftOutOnDisk(const FramePattern& pattern, const std::vector<int>& frames,
                                       std::string_view advice) {
    std::vector<std::string> warnings;
    const auto stepTo = [&](std::size_t i) { return std::int64_t{frames[i]} - frames[i - 1]; };
    std::int64_t least = std::numeric_limits<std::int64_t>::max(), most = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
        least = std::min(least, stepTo(i));
        most = std::max(most, stepTo(i));
    }
    if (least < most)
        warnings.push_back("'" + pattern.text + "': the frames on disk have gaps (" + printFrames(frames) +
                           "), which are left out" + std::string(advice));
    const OtherNumbers others = otherNumbersOnDisk(pattern);
    if (!others.subframes.empty())
        warnings.push_back("'" + pattern.text +
                           "': left out because they are sub-frames: " + firstNames(others.subframes));
    if (!others.padded.empty())
        warnings.push_back("'" + pattern.text +
                           "': left out because their numbers are padded otherwise: " + firstNames(others.padded));
    return warnings;
}

void warnOfLeftOut(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        const FramePattern pattern = inputPattern(name);
        if (!pattern.numbered) continue;
        std::vector<int> frames;
        for (const auto& file : framesOnDisk(pattern)) frames.push_back(file.first);
        for (const std::string& warning : leftOutOnDisk(pattern, frames, "")) logWarning(warning);
    }
}

}  // namespace betamesh
