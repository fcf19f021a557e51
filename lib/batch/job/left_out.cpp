#include "batch/job/left_out.h"

#include "batch/job/frame_task.h"
#include "batch/report/log.h"
#include "batch/report/report.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <set>
#include <system_error>

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

std::vector<std::string> withoutManifests(const std::vector<std::string>& files) {
    std::set<std::string> manifests;
    for (const std::string& file : files) manifests.insert(manifestPath(file));
    const auto isManifest = [&](const std::string& file) {
        std::error_code ignored;
        return manifests.contains(file) && std::filesystem::is_regular_file(file, ignored) && readManifest(file);
    };
    std::vector<std::string> others, left_out;
    for (const std::string& file : files) (isManifest(file) ? left_out : others).push_back(file);
    if (!left_out.empty()) logInfo("left out because they are manifests: " + firstNames(left_out));
    return others;
}

}  // namespace betamesh
