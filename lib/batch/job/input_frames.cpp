#include "batch/job/input_frames.h"

#include "batch/config/key_types.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/frame_number.h"
#include "io/particle_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <set>

namespace betamesh {

std::vector<int> numbersOf(const InputFrames& input) {
    std::vector<int> numbers;
    for (const auto& file : input.files) numbers.push_back(file.first);
    return numbers;
}

InputFrames inputFrames(const Config::Input& input, FileKind kind) {
    constexpr double kLargest = std::numeric_limits<int>::max();
    InputFrames frames{inputPattern(input.path), {}};
    frames.files = framesOnDisk(frames.pattern);
    if (frames.pattern.numbered || frames.files.empty()) return frames;
    const std::string& file = frames.pattern.text;
    std::map<int, std::string> whole;
    try {
        for (const double time : sampleTimes(file, input, kind))
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
    return numbersOf(input);
}

std::vector<std::string> leftOutOfFile(const InputFrames& input, const std::vector<int>& frames,
                                       std::string_view advice) {
    std::vector<std::string> warnings;
    if (!input.is_one_file) return warnings;
    const std::string name = "'" + input.pattern.text + "': ";
    if (frames.size() < input.files.size())
        warnings.push_back(name + "only frame " + std::to_string(frames.front()) + " of " +
                           printFrames(numbersOf(input)) + " is read. Choose others with --frames" +
                           std::string(advice));
    if (!input.between.empty())
        warnings.push_back(name + "the time samples between whole frames are left out, such as " +
                           shortNumber(input.between.front()));
    return warnings;
}

std::string noTimeSample(const std::string& file, int frame) {
    return file + ": has no time sample at frame " + std::to_string(frame);
}

std::string FileFrame::text() const {
    return file + (is_one_of_several ? ", frame " + std::to_string(frame) : std::string());
}

FileFrame fileFrame(const InputFrames& input, int frame) {
    if (input.is_one_file && !input.isThere(frame))
        throw Error(noTimeSample(input.pattern.text, frame) + ". There are " + printFrames(numbersOf(input)));
    return {fileOfFrame(input.pattern, input.files, frame), frame, input.is_one_file};
}

std::vector<FileFrame> framesIn(const std::vector<std::string>& files, const std::string& frames, FileKind kind,
                                bool one_of_each) {
    const std::vector<int> wanted = frames == "all" ? std::vector<int>{} : parseFrames(frames);
    std::vector<FileFrame> found;
    std::set<int> there;
    for (const std::string& file : files) {
        Config::Input named;
        named.path = file;
        const InputFrames input = inputFrames(named, kind);
        std::vector<int> of_file = chosenFrames("all", input, one_of_each && wanted.empty());
        if (!wanted.empty() && input.is_one_file) of_file = numbersOf(input);
        there.insert(of_file.begin(), of_file.end());
        if (wanted.empty())
            for (const std::string& warning : leftOutOfFile(input, one_of_each ? numbersOf(input) : of_file, ""))
                logWarning(warning);
        else
            std::erase_if(of_file, [&](int frame) { return !std::ranges::binary_search(wanted, frame); });
        for (const int frame : of_file) found.push_back(fileFrame(input, frame));
    }
    std::vector<int> missing;
    std::ranges::set_difference(wanted, there, std::back_inserter(missing));
    if (!missing.empty())
        throw Error("there is no frame " + printFrames(missing) + " (--frames): the files have " +
                    printFrames({there.begin(), there.end()}));
    return found;
}

}  // namespace betamesh
