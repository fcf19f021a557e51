// The frames of an input: a sequence of files, or the time samples in one file.

#pragma once

#include "batch/config/config.h"
#include "batch/job/frames.h"

#include <map>
#include <string>
#include <vector>

namespace betamesh {

struct InputFrames {
    FramePattern pattern;
    std::map<int, std::string> files;  ///< on disk, by frame; of a file with several frames the same for each of them
    bool is_one_file = false;          ///< the only file holds several frames
    std::vector<double> between{};     ///< times in it that are no whole frames

    bool isThere(int frame) const { return pattern.numbered || is_one_file ? files.contains(frame) : !files.empty(); }
};

/// The frames of config.input on disk. A file whose frames cannot be told counts as one.
///
/// errors  those of inputPattern()
InputFrames inputFrames(const Config::Input& input);

/// The frames of the key `frames`. `all` stands for every frame of the input. Of a file with several frames it stands
/// for the one in its name, if it has one, and for the first one if the outputs have no place for more.
///
/// in      one_output: the outputs are one file each
/// errors  those of parseFrames(); several frames of a single file; `all` without any frame on disk
std::vector<int> chosenFrames(const std::string& frames, const InputFrames& input, bool one_output);

/// Warnings of the frames of a single file that are left out, where `all` stands for the given ones.
std::vector<std::string> leftOutOfFile(const InputFrames& input, const std::vector<int>& frames);

}  // namespace betamesh
