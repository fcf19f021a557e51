// The frames of an input: a sequence of files, or the time samples in one file.

#pragma once

#include "batch/config/config.h"
#include "batch/job/frames.h"
#include "io/file_contents.h"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

struct InputFrames {
    FramePattern pattern;
    std::map<int, std::string> files;  ///< on disk, by frame; of a file with several frames the same for each of them
    bool is_one_file = false;          ///< the only file holds several frames
    std::vector<double> between{};     ///< times in it that are no whole frames

    bool isThere(int frame) const { return pattern.numbered || is_one_file ? files.contains(frame) : !files.empty(); }
};

/// The frames that are there.
std::vector<int> numbersOf(const InputFrames& input);

/// The frames of config.input on disk. A file whose frames cannot be told counts as one.
///
/// in      kind: what is read, as of sampleTimes()
/// errors  those of inputPattern()
InputFrames inputFrames(const Config::Input& input, FileKind kind = FileKind::particles);

/// The frames of the key `frames`. `all` stands for every frame of the input. Of a file with several frames it stands
/// for the one in its name, if it has one, and for the first one if the outputs have no place for more.
///
/// in      one_output: the outputs are one file each
/// errors  those of parseFrames(); several frames of a single file; `all` without any frame on disk
std::vector<int> chosenFrames(const std::string& frames, const InputFrames& input, bool one_output);

/// Warnings of the frames of a single file that are left out, where `all` stands for the given ones. advice: how to
/// choose others, after --frames.
std::vector<std::string> leftOutOfFile(const InputFrames& input, const std::vector<int>& frames,
                                       std::string_view advice = ", for an output whose name has ####");

/// The message that a file with several frames lacks one, without a full stop.
std::string noTimeSample(const std::string& file, int frame);

/// One frame: a file, or a time sample in one.
struct FileFrame {
    std::string file;
    int frame = 0;                   ///< in the name of the file, or of the time sample
    bool is_one_of_several = false;  ///< in the file

    /// The frame, if the file does not tell it.
    std::optional<int> number() const { return is_one_of_several ? std::optional(frame) : std::nullopt; }
    /// What readers take as `frame`.
    std::optional<double> sample() const { return number(); }
    /// For messages: "shot.abc, frame 12".
    std::string text() const;
};

/// A frame of an input. A file of a sequence may not be there.
///
/// errors  no time sample at this frame
FileFrame fileFrame(const InputFrames& input, int frame);

/// The frames in files, in their order. Logs leftOutOfFile().
///
/// in      files: without placeholders, as of filesNamed()
///         frames: as the key `frames`; those that are chosen
///         one_of_each: `all` stands for one frame of each file, as where outputs have no place for more
/// errors  those of parseFrames(); a frame that is in none of the files
std::vector<FileFrame> framesIn(const std::vector<std::string>& files, const std::string& frames, FileKind kind,
                                bool one_of_each);

}  // namespace betamesh
