// Frame numbers: their place in file names, frame ranges, and chunks of frames for farms.

#pragma once

#include "betamesh/error.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A path with a placeholder for the frame number: `####` or `@@@@` (one character per digit), `%04d`, `$F4`, `$F`.
/// Folders may have placeholders, too; all stand for the same number and have to be written alike. A single # or @ is
/// part of the name in folders, and in a file name with a longer placeholder. A path without placeholder is a single
/// file; its frame is the number before the extension (splash.0012.vdb: 12), or 0 if there is none. The number of a
/// version (splash_v002.vdb) is no frame.
struct FramePattern {
    std::string text;                ///< the whole path, for messages
    std::vector<std::string> parts;  ///< the text before, between and after placeholders
    int width = 0;                   ///< least number of characters, with the minus sign; padded with zeros
    bool numbered = false;           ///< has a placeholder
};

/// Replaces $NAME and ${NAME} by the environment variable NAME, except for $F and $F4, which are placeholders. As in
/// shells, ~/ at the beginning becomes $HOME/.
///
/// errors  a variable that is not set; the home folder of another user, ~name/
std::string withVariables(std::string_view path);

/// The pattern of a path withVariables().
///
/// errors  placeholders that are written differently; a variable that is not set
FramePattern framePattern(std::string_view path);

/// The pattern of an input: the file of this very name if there is one, whatever placeholders it seems to have; the
/// sequence in a folder; else framePattern().
///
/// errors  a folder without particles or meshes, or with several sequences of them, which the message lists; those of
///         framePattern()
FramePattern inputPattern(std::string_view path);

/// The path of a frame. Negative numbers as in printf: frame -12 in `####` is `-012`.
std::string frameName(const FramePattern& pattern, int frame);

/// Whether a path, in whatever way it is written, is that of a frame.
bool isFrameOf(const FramePattern& pattern, const std::string& path);

/// The number before the extension of a file name, with or without folders; 0 if there is none, or only a version.
int frameInName(std::string_view file);

/// The path for the frame number found in another file name. A pattern without placeholder is returned unchanged.
std::string nameForFrameOf(const FramePattern& pattern, std::string_view other);

/// errors  several frames but no placeholder
void requirePlaceholder(std::size_t frames, const FramePattern& pattern);

/// The folder of a file; "." for a name without folders.
std::string folderOf(const std::string& file);

/// All files on disk whose name frameName() can produce, by frame; of negative frames also those that are padded
/// without the minus sign (-0012 for ####). None if the folder does not exist.
std::map<int, std::string> framesOnDisk(const FramePattern& pattern);

/// The error that no file of a pattern is there.
Error noFileOnDisk(const FramePattern& pattern);

/// The file of a frame among framesOnDisk(); frameName() if it is not there.
std::string fileOfFrame(const FramePattern& pattern, const std::map<int, std::string>& on_disk, int frame);

/// Files on disk that have a number where the pattern has its placeholder, but are not among framesOnDisk().
struct OtherNumbers {
    std::vector<std::string> subframes;  ///< splash.0001.25.vdb
    std::vector<std::string> padded;     ///< padded otherwise: splash.1.vdb beside splash.####.vdb
};
OtherNumbers otherNumbersOnDisk(const FramePattern& pattern);

/// The first names of a list for a message: "a, b and 7 more".
std::string firstNames(const std::vector<std::string>& names);

/// " The frame numbers of a sequence are written with #, …" if there is no such file and its name has a * or ?, or
/// looks like a frame number of another program (<F4>, {frame}, %4d, [1-9]), else empty.
std::string adviceOnStars(const std::string& file);

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
