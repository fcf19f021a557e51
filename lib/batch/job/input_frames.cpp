#include "batch/job/input_frames.h"

#include "batch/config/key_types.h"
#include "betamesh/error.h"
#include "io/frame_number.h"
#include "io/particle_file.h"

#include <cmath>
#include <filesystem>
#include <limits>

namespace betamesh {

InputFrames inputFrames(const Config::Input& input) {
    constexpr double kLargest = std::numeric_limits<int>::max();
    InputFrames frames{inputPattern(input.path), {}};
    frames.files = framesOnDisk(frames.pattern);
    if (frames.pattern.numbered || frames.files.empty()) return frames;
    const std::string& file = frames.pattern.text;
    std::map<int, std::string> whole;
    try {
        for (const double time : sampleTimes(file, input))
            if (time == std::trunc(time) && std::abs(time) <= kLargest)
                whole[static_cast<int>(time)] = file;
            else
                frames.between.push_back(time);
    } catch (const Error&) {  // reported when the file is meshed
    }
    frames.is_one_file = whole.size() > 1 || (whole.size() == 1 && !frames.between.empty());
    if (frames.is_one_file)
        frames.files = std::move(whole);
    else
        frames.between.clear();
    return frames;
}

std::vector<int> chosenFrames(const std::string& frames, const InputFrames& input, bool one_output) {
    if (!input.is_one_file) return chosenFrames(frames, input.pattern, input.files);
    if (frames != "all") return parseFrames(frames);
    const std::string name = std::filesystem::path(input.pattern.text).filename().string();
    const int named = frameInName(name);
    if (!frameNumberIn(name).empty() && input.files.contains(named)) return {named};
    if (one_output) return {input.files.begin()->first};
    std::vector<int> all;
    for (const auto& file : input.files) all.push_back(file.first);
    return all;
}

std::vector<std::string> leftOutOfFile(const InputFrames& input, const std::vector<int>& frames) {
    std::vector<std::string> warnings;
    if (!input.is_one_file) return warnings;
    const std::string name = "'" + input.pattern.text + "': ";
    if (frames.size() < input.files.size()) {
        std::vector<int> all;
        for (const auto& file : input.files) all.push_back(file.first);
        warnings.push_back(name + "only frame " + std::to_string(frames.front()) + " of " + printFrames(all) +
                           " is read. Choose others with --frames, for an output whose name has ####");
    }
    if (!input.between.empty())
        warnings.push_back(name + "the time samples between whole frames are left out, such as " +
                           shortNumber(input.between.front()));
    return warnings;
}

}  // namespace betamesh
