
#include "batch/job/frames.h"

#include "betamesh/error.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>

namespace betamesh {
namespace {

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

/// The number before the extension: "splash.0012.vdb" -> 12, "drop_-003.ply" -> -3, "drop.ply" -> 0.
int numberInName(std::string_view name) {
    const std::size_t dot = name.find('.', name.find_last_of("0123456789") + 1);
    std::string_view stem = name.substr(0, dot);
    std::size_t begin = stem.size();
    while (begin > 0 && isDigit(stem[begin - 1])) --begin;
    if (begin == stem.size()) return 0;
    const bool negative = begin > 1 && stem[begin - 1] == '-' && (stem[begin - 2] == '.' || stem[begin - 2] == '_');
    return parseNumber(stem.substr(negative ? begin - 1 : begin)).value_or(0);
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

}  // namespace

FramePattern framePattern(std::string_view path) {
    FramePattern pattern;
    pattern.text = path;
    const std::size_t slash = path.rfind('/');
    const std::size_t name_begin = slash == std::string_view::npos ? 0 : slash + 1;
    const auto placeholders = placeholdersIn(path.substr(name_begin));
    if (placeholders.size() > 1) {
        throw Error("'" + pattern.text + "': " + std::to_string(placeholders.size()) +
                    " placeholders for the frame number. Use one, as in name.####.vdb");
    }
    if (placeholders.empty()) {
        // A folder may be called C#, but #### in a folder name is taken for a mistake.
        for (const Placeholder& placeholder : placeholdersIn(path.substr(0, name_begin))) {
            if (placeholder.length > 1) {
                throw Error("'" + pattern.text +
                            "': the placeholder for the frame number is in the name of a folder. Put it into the "
                            "file name, as in folder/name.####.vdb");
            }
        }
        pattern.head = path;
        return pattern;
    }
    const Placeholder& placeholder = placeholders.front();
    if (placeholder.width > kMaxWidth) {
        throw Error("'" + pattern.text + "': " + std::to_string(placeholder.width) +
                    " digits for the frame number. Use at most " + std::to_string(kMaxWidth));
    }
    pattern.head = path.substr(0, name_begin + placeholder.begin);
    pattern.tail = path.substr(name_begin + placeholder.begin + placeholder.length);
    pattern.width = placeholder.width;
    pattern.numbered = true;
    return pattern;
}

std::string frameName(const FramePattern& pattern, int frame) {
    if (!pattern.numbered) return pattern.head;
    return pattern.head + zeroFilled(frame, pattern.width) + pattern.tail;
}

std::optional<int> frameOfName(const FramePattern& pattern, std::string_view name) {
    const std::string head = std::filesystem::path(pattern.head).filename().string();
    if (name.size() <= head.size() + pattern.tail.size() || !name.starts_with(head) || !name.ends_with(pattern.tail))
        return std::nullopt;
    const auto frame = parseNumber(name.substr(head.size(), name.size() - head.size() - pattern.tail.size()));
    // Of f.1.vdb and f.0001.vdb only one fits the padding of the pattern.
    if (!frame || std::filesystem::path(frameName(pattern, *frame)).filename().string() != name) return std::nullopt;
    return frame;
}

int singleFrame(const FramePattern& pattern) {
    return numberInName(std::filesystem::path(pattern.head).filename().string());
}

std::string nameForFrameOf(const FramePattern& pattern, std::string_view other) {
    return pattern.numbered ? frameName(pattern, singleFrame(framePattern(other))) : pattern.text;
}

void requirePlaceholder(std::size_t frames, const FramePattern& pattern) {
    if (frames <= 1 || pattern.numbered) return;
    throw Error("'" + pattern.text + "' is one file for " + std::to_string(frames) +
                " frames. Add a placeholder for the frame number to its name, such as ####");
}

std::string folderOf(const std::string& file) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    return folder.empty() ? "." : folder.string();
}

std::map<int, std::string> framesOnDisk(const FramePattern& pattern) {
    namespace fs = std::filesystem;
    std::map<int, std::string> files;
    const fs::path head(pattern.head);
    std::error_code error;
    if (!pattern.numbered) {
        if (fs::exists(head, error)) files[singleFrame(pattern)] = pattern.head;
        return files;
    }
    const std::string folder = folderOf(pattern.head);
    fs::directory_iterator entries(folder, error);
    if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory) return files;
    if (error) throw Error("'" + folder + "': the folder cannot be read: " + error.message());
    for (const fs::directory_entry& entry : entries) {
        const std::string name = entry.path().filename().string();
        if (const auto frame = frameOfName(pattern, name)) files[*frame] = frameName(pattern, *frame);
    }
    return files;
}

std::vector<std::string> filesNamed(const std::vector<std::string>& names) {
    std::vector<std::string> files;
    for (const std::string& name : names) {
        const FramePattern pattern = framePattern(name);
        std::error_code ignored;
        if (!pattern.numbered || std::filesystem::exists(name, ignored)) {
            files.push_back(name);
            continue;
        }
        const auto on_disk = framesOnDisk(pattern);
        if (on_disk.empty())
            throw Error("'" + name + "': no such file on disk. Expected names such as " + frameName(pattern, 1));
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
    if (!input.numbered) return {singleFrame(input)};
    std::vector<int> chosen;
    for (const auto& file : on_disk) chosen.push_back(file.first);
    if (chosen.empty())
        throw Error("'" + input.text + "': no such file on disk. Expected names such as " + frameName(input, 1));
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
