// Frame numbers: their place in file names, frame ranges, and chunks of frames for farms.

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A path with a placeholder for the frame number: `####` or `@@@@` (one character per digit), `%04d`, `$F4`, `$F`.
/// A path without placeholder is a single file; its frame is the number before the extension (splash.0012.vdb: 12), or
/// 0 if there is none.
struct FramePattern {
    std::string text;       ///< the whole pattern, for messages
    std::string head;       ///< before the placeholder, with folders
    std::string tail;       ///< after the placeholder
    int width = 0;          ///< least number of characters, with the minus sign; padded with zeros
    bool numbered = false;  ///< has a placeholder
};

/// errors  two placeholders; a placeholder in the name of a folder
FramePattern framePattern(std::string_view path);

/// The path of a frame. Negative numbers as in printf: frame -12 in `####` is `-012`.
std::string frameName(const FramePattern& pattern, int frame);

/// The frame number in a file name without folders that has the form of the pattern; nullopt if it has another form.
std::optional<int> frameOfName(const FramePattern& pattern, std::string_view name);

/// The frame of a pattern without placeholder.
int singleFrame(const FramePattern& pattern);

/// The path for the frame number found in another file name. A pattern without placeholder is returned unchanged.
std::string nameForFrameOf(const FramePattern& pattern, std::string_view other);

/// errors  several frames but no placeholder
void requirePlaceholder(std::size_t frames, const FramePattern& pattern);

/// The folder of a file; "." for a name without folders.
std::string folderOf(const std::string& file);

/// All files on disk whose name frameName() can produce, by frame. None if the folder does not exist.
std::map<int, std::string> framesOnDisk(const FramePattern& pattern);

/// The files that names stand for, in their order: a name with a placeholder for every frame on disk, unless there is a
/// file of this very name.
///
/// errors  a placeholder for which there is no file
std::vector<std::string> filesNamed(const std::vector<std::string>& names);

/// The frames in a text such as `1-100`, `1-100x2`, `1-10,15,20-30`, `-5--1`: ascending, each once.
///
/// errors  any other syntax; `:`, whose meaning differs between OpenJD and OpenCue; more than ten million frames
std::vector<int> parseFrames(std::string_view text);

/// The frames of the key `frames`: a text for parseFrames(), or `all` for every frame on disk.
///
/// in      on_disk: framesOnDisk(input)
/// errors  those of parseFrames(); several frames but no placeholder; `all` without any frame on disk
std::vector<int> chosenFrames(const std::string& frames, const FramePattern& input,
                              const std::map<int, std::string>& on_disk);

/// A short text that parseFrames() reads back.
///
/// in      frames ascending, each once
std::string printFrames(const std::vector<int>& frames);

/// One of `count` contiguous chunks of frames, whose sizes differ by at most one. 1 <= index <= count.
struct Chunk {
    int index = 1;
    int count = 1;
};

/// Parses `i/N`.
Chunk parseChunk(std::string_view text);

std::vector<int> chunkOf(const std::vector<int>& frames, const Chunk& chunk);

}  // namespace betamesh
