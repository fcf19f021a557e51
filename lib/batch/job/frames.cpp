
#include "batch/job/frames.h"

#include "betamesh/error.h"
#include "io/extension.h"
#include "io/frame_number.h"
#include "io/usd_clips.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxFrames = 10'000'000;
constexpr int kMaxWidth = 20;  // digits; no frame number needs as many

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// The frame number if the text is nothing else: no plus sign, no spaces.
std::optional<int> parseNumber(std::string_view text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::string zeroFilled(int number, int width) {
    std::string digits = std::to_string(number);
    const std::size_t sign = number < 0 ? 1 : 0;
    if (digits.size() < static_cast<std::size_t>(width)) {
        digits.insert(sign, static_cast<std::size_t>(width) - digits.size(), '0');
    }
    return digits;
}

struct Placeholder {
    std::size_t begin = 0;
    std::size_t length = 0;
    int width = 1;
};

/// The placeholder that begins at this character, if there is one.
std::optional<Placeholder> placeholderAt(std::string_view text, std::size_t begin) {
    const char first = text[begin];
    if (first == '#' || first == '@') {
        const std::size_t end = std::min(text.find_first_not_of(first, begin), text.size());
        return Placeholder{begin, end - begin, static_cast<int>(end - begin)};
    }
    const bool printf_style = first == '%';
    const bool houdini_style = first == '$' && text.substr(begin + 1, 1) == "F";
    if (!printf_style && !houdini_style) return std::nullopt;
    const std::size_t digits_begin = begin + (printf_style ? 1 : 2);
    std::size_t end = digits_begin;
    while (end < text.size() && isDigit(text[end]) && end < digits_begin + 3) ++end;
    const std::string_view digits = text.substr(digits_begin, end - digits_begin);
    if (printf_style) {
        const bool zero_filled = digits.empty() || digits.front() == '0';
        if (!zero_filled || text.substr(end, 1) != "d") return std::nullopt;
        ++end;
    }
    const int width = digits.empty() ? 1 : std::max(1, parseNumber(digits).value_or(1));
    return Placeholder{begin, end - begin, width};
}

std::vector<Placeholder> placeholdersIn(std::string_view text) {
    std::vector<Placeholder> placeholders;
    for (std::size_t i = 0; i < text.size();) {
        if (const auto placeholder = placeholderAt(text, i)) {
            placeholders.push_back(*placeholder);
            i += placeholder->length;
        } else {
            ++i;
        }
    }
    return placeholders;
}

std::string quoted(std::string_view text) { return std::string("'").append(text).append("'"); }

[[noreturn]] void failFrames(std::string_view text, const std::string& why) {
    throw Error("frames '" + std::string(text) + "': " + why +
                ". Use a form such as 12, 1-100, 1-100x2, -5--1 or 1-10,15,20-30");
}

/// Parses a frame number at the start of the rest and removes it there.
int takeNumber(std::string_view text, std::string_view& rest) {
    int value = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error == std::errc::result_out_of_range) failFrames(text, "a number is too large");
    if (error != std::errc{}) failFrames(text, "expected a frame number at " + quoted(rest));
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return value;
}

bool isNameCharacter(char c) { return isDigit(c) || std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }

/// The placeholders of a path. A single # or @ counts only in the file name, and only if there is no longer
/// placeholder.
std::vector<Placeholder> placeholdersInPath(std::string_view path) {
    std::vector<Placeholder> placeholders = placeholdersIn(path);
    const std::size_t name_begin = path.rfind('/') + 1;  // 0 if there is no folder
    const auto isLong = [](const Placeholder& placeholder) { return placeholder.length > 1; };
    const bool any_long = std::any_of(placeholders.begin(), placeholders.end(), isLong);
    std::erase_if(placeholders, [&](const Placeholder& placeholder) {
        return !isLong(placeholder) && (any_long || placeholder.begin < name_begin);
    });
    return placeholders;
}

/// Calls visit(name) for the files in a folder, in any order; not at all if there is no such folder.
template <typename Visit>
void forFilesIn(const std::string& folder, const Visit& visit) {
    std::error_code error;
    fs::directory_iterator entries(folder, error);
    if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory) return;
    if (error) throw Error("'" + folder + "': the folder cannot be read: " + error.message());
    for (const fs::directory_entry& entry : entries) visit(entry.path().filename().string());
}

/// The first folder or file name of a pattern that has placeholders.
struct NumberedName {
    std::string folder;              ///< that contains it
    std::vector<std::string> parts;  ///< as FramePattern::parts
    bool is_file;                    ///< false: of a folder
};

NumberedName numberedName(const FramePattern& pattern) {
    const std::size_t begin = pattern.parts[0].rfind('/') + 1;
    NumberedName name{folderOf(pattern.parts[0] + '0'), {pattern.parts[0].substr(begin)}, true};
    for (std::size_t i = 1; i < pattern.parts.size() && name.is_file; ++i) {
        const std::size_t end = pattern.parts[i].find('/');
        name.parts.push_back(pattern.parts[i].substr(0, end));
        name.is_file = end == std::string::npos;
    }
    return name;
}

std::string joined(const std::vector<std::string>& parts, std::string_view number) {
    std::string text = parts[0];
    for (std::size_t i = 1; i < parts.size(); ++i) text.append(number).append(parts[i]);
    return text;
}

/// The text at the placeholders of a name on disk; nullopt if it has another form.
std::optional<std::string> numberIn(const NumberedName& pattern, const std::string& name) {
    const std::size_t count = pattern.parts.size() - 1, fixed = joined(pattern.parts, "").size();
    if (name.size() <= fixed || (name.size() - fixed) % count != 0) return std::nullopt;
    std::string number = name.substr(pattern.parts[0].size(), (name.size() - fixed) / count);
    if (joined(pattern.parts, number) != name) return std::nullopt;
    return number;
}

/// Calls visit(number, file) for the files on disk of a pattern, with the text of the number in their names.
template <typename Visit>
void forNumbersOnDisk(const FramePattern& pattern, const Visit& visit) {
    const NumberedName numbered = numberedName(pattern);
    forFilesIn(numbered.folder, [&](const std::string& name) {
        const auto number = numberIn(numbered, name);
        if (!number) return;
        const std::string file = joined(pattern.parts, *number);
        std::error_code ignored;
        if (numbered.is_file || fs::exists(file, ignored)) visit(*number, file);
    });
}

/// Whether a negative number is padded without its sign: -0012 for ####, where printf writes -012.
bool isWideNegative(const FramePattern& pattern, std::string_view number) {
    return number.starts_with('-') && zeroFilled(parseNumber(number).value_or(0), pattern.width + 1) == number;
}

/// The sequences of particles or meshes in a folder, as patterns with folders; single files without numbers, too,
/// except layers that play a sequence.
std::vector<std::string> sequencesIn(const std::string& folder) {
    std::map<std::pair<std::string, std::string>, std::size_t> width;  // of head and tail: least number of characters
    forFilesIn(folder, [&](const std::string& name) {
        if (name.starts_with('.') ||
            !(canHold(name, FileKind::particles, Access::read) || canHold(name, FileKind::mesh, Access::read)))
            return;
        const std::string_view number = frameNumberIn(name);
        if (number.empty() && isUsdClipsLayer(fs::path(folder) / name)) return;
        const auto begin = static_cast<std::size_t>(number.data() - name.data());
        std::pair key{name.substr(0, begin), name.substr(begin + number.size())};
        const auto [known, is_new] = width.try_emplace(std::move(key), number.size());
        known->second = std::min(known->second, number.size());
    });
    std::vector<std::string> sequences;
    for (const auto& [ends, characters] : width)
        sequences.push_back((fs::path(folder) / (ends.first + std::string(characters, '#') + ends.second)).string());
    return sequences;
}

}  // namespace

std::string withVariables(std::string_view path) {
    std::string text;
    const std::size_t slash = path.starts_with('~') ? path.find('/') : std::string_view::npos;
    if (path == "~" || slash == 1) {
        const char* home = std::getenv("HOME");
        if (home == nullptr) throw Error(quoted(path) + ": the environment variable HOME is not set");
        text = home;
        path.remove_prefix(1);
    } else if (slash != std::string_view::npos) {
        throw Error(quoted(path) + ": only ~/, the home folder, is understood. Write the whole path, or ./" +
                    std::string(path) + " for a folder of this name");
    }
    for (std::size_t i = 0; i < path.size();) {
        const bool braces = path.substr(i, 2) == "${";
        std::size_t end = i + (braces ? 2 : 1);
        const std::size_t begin = end;
        while (path[i] == '$' && end < path.size() && isNameCharacter(path[end])) ++end;
        const std::string name(path.substr(begin, end - begin));
        const bool is_frame = !braces && name.starts_with('F') && std::all_of(name.begin() + 1, name.end(), isDigit);
        if (path[i] != '$' || name.empty() || is_frame || (braces && path.substr(end, 1) != "}")) {
            text += path[i++];
            continue;
        }
        const char* value = std::getenv(name.c_str());
        if (value == nullptr)
            throw Error("'" + std::string(path) + "': the environment variable " + name + " is not set");
        text += value;
        i = end + (braces ? 1 : 0);
    }
    return text;
}

FramePattern framePattern(std::string_view path) {
    FramePattern pattern;
    pattern.text = withVariables(path);
    const std::string_view text = pattern.text;
    std::size_t begin = 0;
    std::string_view spelling;
    for (const Placeholder& placeholder : placeholdersInPath(text)) {
        const std::string_view here = text.substr(placeholder.begin, placeholder.length);
        if (pattern.numbered && here != spelling)
            throw Error("'" + pattern.text + "': " + quoted(spelling) + " and " + quoted(here) +
                        " both stand for the frame number. Write them alike, or use one, as in name.####.vdb");
        if (placeholder.width > kMaxWidth)
            throw Error("'" + pattern.text + "': " + std::to_string(placeholder.width) +
                        " digits for the frame number. Use at most " + std::to_string(kMaxWidth));
        spelling = here;
        pattern.parts.emplace_back(text.substr(begin, placeholder.begin - begin));
        pattern.width = placeholder.width;
        pattern.numbered = true;
        begin = placeholder.begin + placeholder.length;
    }
    pattern.parts.emplace_back(text.substr(begin));
    return pattern;
}

FramePattern inputPattern(std::string_view path) {
    std::error_code ignored;
    const auto singleFile = [](const std::string& file) {
        FramePattern pattern;
        pattern.text = file;
        pattern.parts = {file};
        return pattern;
    };
    const bool is_in_home = path == "~" || path.starts_with("~/");
    if (!is_in_home && fs::is_regular_file(path, ignored)) return singleFile(std::string(path));
    const std::string folder = withVariables(path);
    if (!fs::is_directory(folder, ignored)) return framePattern(path);
    const std::vector<std::string> sequences = sequencesIn(folder);
    if (sequences.empty()) throw Error("'" + folder + "': the folder contains no file of particles or meshes");
    if (sequences.size() > 1)
        throw Error("'" + folder + "': the folder contains " + std::to_string(sequences.size()) +
                    " sequences. Choose one: " + firstNames(sequences));
    return fs::is_regular_file(sequences.front(), ignored) ? singleFile(sequences.front())
                                                           : framePattern(sequences.front());
}

std::string frameName(const FramePattern& pattern, int frame) {
    return joined(pattern.parts, zeroFilled(frame, pattern.width));
}

Error noFileOnDisk(const FramePattern& pattern) {
    return Error("'" + pattern.text + "': no such file on disk. Expected names such as " + frameName(pattern, 1));
}

bool isFrameOf(const FramePattern& pattern, const std::string& path) {
    const auto canonical = [](const std::string& file) {
        std::error_code ignored;
        return fs::weakly_canonical(fs::absolute(folderOf(file)), ignored) / fs::path(file).filename();
    };
    const fs::path wanted = canonical(path);
    const std::string text = wanted.string();
    if (!pattern.numbered) return wanted == canonical(pattern.text);
    for (std::size_t begin = 0; begin < text.size(); ++begin) {
        if (!isDigit(text[begin]) || (begin > 0 && isDigit(text[begin - 1]))) continue;
        const std::size_t end = std::min(text.find_first_not_of("0123456789", begin), text.size());
        const bool negative = begin > 0 && text[begin - 1] == '-';
        for (std::size_t first = begin - (negative ? 1 : 0); first <= begin; ++first) {
            const auto frame = parseNumber(text.substr(first, end - first));
            if (frame && canonical(frameName(pattern, *frame)) == wanted) return true;
        }
    }
    return false;
}

int frameInName(std::string_view file) {
    const std::string name = fs::path(file).filename().string();
    return parseNumber(frameNumberIn(name)).value_or(0);
}

std::string nameForFrameOf(const FramePattern& pattern, std::string_view other) {
    return pattern.numbered ? frameName(pattern, frameInName(other)) : pattern.text;
}

void requirePlaceholder(std::size_t frames, const FramePattern& pattern) {
    if (frames <= 1 || pattern.numbered) return;
    throw Error("'" + pattern.text + "' is one file for " + std::to_string(frames) +
                " frames. Add a placeholder for the frame number to its name, such as ####");
}

std::string folderOf(const std::string& file) {
    const fs::path folder = fs::path(file).parent_path();
    return folder.empty() ? "." : folder.string();
}

std::map<int, std::string> framesOnDisk(const FramePattern& pattern) {
    std::map<int, std::string> files, wide;
    std::error_code ignored;
    if (!pattern.numbered) {
        if (fs::exists(pattern.text, ignored)) files[frameInName(pattern.text)] = pattern.text;
        return files;
    }
    forNumbersOnDisk(pattern, [&](const std::string& number, const std::string& file) {
        const auto frame = parseNumber(number);
        // Of f.1.vdb and f.0001.vdb only one fits the padding of the pattern.
        if (frame && zeroFilled(*frame, pattern.width) == number) files[*frame] = file;
        if (frame && isWideNegative(pattern, number)) wide[*frame] = file;
    });
    files.merge(wide);
    return files;
}

std::string fileOfFrame(const FramePattern& pattern, const std::map<int, std::string>& on_disk, int frame) {
    const auto file = on_disk.find(frame);
    return file != on_disk.end() ? file->second : frameName(pattern, frame);
}

OtherNumbers otherNumbersOnDisk(const FramePattern& pattern) {
    OtherNumbers others;
    if (!pattern.numbered) return others;
    const auto on_disk = framesOnDisk(pattern);
    forNumbersOnDisk(pattern, [&](const std::string& text, const std::string& file) {
        const std::size_t point = text.find('.');
        const auto whole = parseNumber(std::string_view(text).substr(0, point));
        if (!whole) return;
        if (point == std::string::npos) {
            const auto known = on_disk.find(*whole);
            if (known == on_disk.end() || known->second != file) others.padded.push_back(file);
        } else if (std::all_of(text.begin() + static_cast<std::ptrdiff_t>(point) + 1, text.end(), isDigit)) {
            others.subframes.push_back(file);
        }
    });
    std::sort(others.padded.begin(), others.padded.end());
    std::sort(others.subframes.begin(), others.subframes.end());
    return others;
}

std::string firstNames(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 5;
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i)
        text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

std::string adviceOnStars(const std::string& file) {
    std::error_code ignored;
    if (file.find_first_of("*?<>{}[]%") == std::string::npos || fs::exists(file, ignored)) return "";
    return " The frame numbers of a sequence are written with #, as in name.####.ply";
}

std::vector<std::string> filesNamed(const std::vector<std::string>& names) {
    std::vector<std::string> files;
    for (const std::string& name : names) {
        const FramePattern pattern = inputPattern(name);
        if (!pattern.numbered) {
            files.push_back(pattern.text);
            continue;
        }
        const auto on_disk = framesOnDisk(pattern);
        if (on_disk.empty()) throw noFileOnDisk(pattern);
        for (const auto& file : on_disk) files.push_back(file.second);
    }
    return files;
}

std::vector<int> parseFrames(std::string_view text) {
    if (text.find(':') != std::string_view::npos) {
        failFrames(text,
                   "':' is ambiguous: OpenJD reads it as a step (1-10:2 is 1,3,5,7,9), OpenCue as another order of all "
                   "frames. Write a step with x, as in 1-10x2");
    }
    std::vector<int> frames;
    std::string_view rest = text;
    while (true) {
        const std::int64_t first = takeNumber(text, rest);
        std::int64_t last = first;
        std::int64_t step = 1;
        if (rest.starts_with('-')) {
            rest.remove_prefix(1);
            last = takeNumber(text, rest);
            if (last < first)
                failFrames(text, "the range " + std::to_string(first) + "-" + std::to_string(last) + " runs backwards");
            if (rest.starts_with('x')) {
                rest.remove_prefix(1);
                step = takeNumber(text, rest);
                if (step < 1) failFrames(text, "the step is " + std::to_string(step) + " but must be at least 1");
            }
        }
        if ((last - first) / step + 1 + static_cast<std::int64_t>(frames.size()) > kMaxFrames) {
            failFrames(text, "more than " + std::to_string(kMaxFrames) + " frames");
        }
        for (std::int64_t frame = first; frame <= last; frame += step) frames.push_back(static_cast<int>(frame));
        if (rest.empty()) break;
        if (!rest.starts_with(',')) failFrames(text, quoted(rest) + " is not understood");
        rest.remove_prefix(1);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return frames;
}

std::vector<int> chosenFrames(const std::string& frames, const FramePattern& input,
                              const std::map<int, std::string>& on_disk) {
    if (frames != "all") {
        std::vector<int> chosen = parseFrames(frames);
        requirePlaceholder(chosen.size(), input);
        return chosen;
    }
    if (!input.numbered) return {frameInName(input.text)};
    std::vector<int> chosen;
    for (const auto& file : on_disk) chosen.push_back(file.first);
    if (chosen.empty()) throw noFileOnDisk(input);
    return chosen;
}

std::string printFrames(const std::vector<int>& frames) {
    std::string text;
    for (std::size_t begin = 0; begin < frames.size();) {
        // The longest run with a constant step. Two frames form a run only if they are neighbours.
        std::size_t end = begin + 1;
        std::int64_t step = 1;
        if (end < frames.size()) {
            step = std::int64_t{frames[end]} - frames[begin];
            while (end < frames.size() && std::int64_t{frames[end]} - frames[end - 1] == step) ++end;
            if (step != 1 && end - begin < 3) end = begin + 1;
        }
        if (!text.empty()) text += ',';
        text += std::to_string(frames[begin]);
        if (end - begin > 1) {
            text.append("-").append(std::to_string(frames[end - 1]));
            if (step > 1) text.append("x").append(std::to_string(step));
        }
        begin = end;
    }
    return text;
}

Chunk parseChunk(std::string_view text) {
    const std::size_t slash = text.find('/');
    if (slash != std::string_view::npos) {
        const auto index = parseNumber(text.substr(0, slash));
        const auto count = parseNumber(text.substr(slash + 1));
        if (index && count && 1 <= *index && *index <= *count) return {*index, *count};
    }
    throw Error("chunk '" + std::string(text) + "' is invalid. Use i/N with 1 <= i <= N, as in 3/8");
}

std::vector<int> chunkOf(const std::vector<int>& frames, const Chunk& chunk) {
    const std::size_t count = static_cast<std::size_t>(chunk.count);
    const std::size_t index = static_cast<std::size_t>(chunk.index);
    const auto end = [&](std::size_t chunks) { return static_cast<std::ptrdiff_t>(frames.size() * chunks / count); };
    return {frames.begin() + end(index - 1), frames.begin() + end(index)};
}

}  // namespace betamesh
