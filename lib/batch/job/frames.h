// Frame numbers: where they stand in file names, which of them are meant, which piece of them is ours.

#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A file name with a place for the frame number: `####` and `@@@@` (one digit each), `%04d`, `$F4`, `$F`.
/// A name without a place is one file; its frame is the number before the extension (splash.0012.vdb: 12),
/// or 0 if there is none.
struct FramePattern {
    std::string text;  ///< as it was written, for messages
    std::string head;  ///< up to the place, folders included
    std::string tail;  ///< after it
    int width = 0;     ///< characters to fill with zeros, a minus sign included; longer numbers are written in full
    bool numbered = false;
};

/// errors  two places; a place in a folder's name
FramePattern framePattern(std::string_view path);

/// The file of one frame: `-12` in `####` is `-012`, as printf writes it.
std::string frameName(const FramePattern& pattern, int frame);

/// The frame that a name without a place stands for.
int singleFrame(const FramePattern& pattern);

/// The file of the frame that another file's name tells; a name without a place stays as it is.
std::string nameForFrameOf(const FramePattern& pattern, std::string_view other);

/// errors  several frames for a name without a place
void requirePlaceFor(std::size_t frames, const FramePattern& pattern);

/// Where a file is: "." for a name without folders.
std::string folderOf(const std::string& file);

/// Every file on disk that frameName() could have named, by frame. A folder that does not exist has none.
std::map<int, std::string> framesOnDisk(const FramePattern& pattern);

/// Frame numbers of `1-100`, `1-100x2`, `1-10,15,20-30`, `-5--1`: ascending, each once.
///
/// errors  anything else, with what was expected; `:`, which OpenJD and OpenCue read differently; more than
///         ten million frames
std::vector<int> parseFrames(std::string_view text);

/// Those of a `frames` setting; `all`: every one on disk.
///
/// in      what framesOnDisk(input) found
/// errors  those of parseFrames; several frames for a name without a place; `all` of none
std::vector<int> chosenFrames(const std::string& frames, const FramePattern& input,
                              const std::map<int, std::string>& on_disk);

/// The shortest simple text that parseFrames() reads back.
///
/// in      ascending, each once
std::string printFrames(const std::vector<int>& frames);

/// The index-th of count contiguous pieces whose sizes differ by at most one; 1 <= index <= count.
struct Chunk {
    int index = 1;
    int count = 1;
};

/// Reads `i/N`.
Chunk parseChunk(std::string_view text);

std::vector<int> chunkOf(const std::vector<int>& frames, const Chunk& chunk);

}  // namespace betamesh
