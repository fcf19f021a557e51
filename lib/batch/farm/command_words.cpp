#include "batch/farm/command_words.h"

#include "batch/job/frames.h"
#include "betamesh/error.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace betamesh {
namespace {

std::string shellWord(const std::string& word) {
    const auto plain = [](unsigned char c) {
        return std::isalnum(c) != 0 ||
               std::string_view("_-./=:,+@%").find(static_cast<char>(c)) != std::string_view::npos;
    };
    if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
    std::string in_quotes = "'";
    for (const char c : word) in_quotes += c == '\'' ? "'\\''" : std::string(1, c);
    return in_quotes + "'";
}

bool isControl(char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string shellWords(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + shellWord(word);
    return text;
}

std::vector<std::string> inFolder(const FarmJob& job, const std::vector<std::string>& words,
                                  const std::vector<std::string>& more_words) {
    std::vector<std::string> all{"env", "-C", job.folder};
    // env would take a program whose path contains = for a variable.
    if (words.front().find('=') != std::string::npos) all = {"sh", "-c", R"(cd "$0" && exec "$@")", job.folder};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), more_words.begin(), more_words.end());
    return all;
}

std::vector<int> allFrames(const FarmJob& job) {
    std::vector<int> frames;
    for (const auto& chunk : job.chunks) frames.insert(frames.end(), chunk.begin(), chunk.end());
    return frames;
}

std::vector<std::string> reportWords(const FarmJob& job) {
    std::vector<std::string> words = job.report;
    words.insert(words.end(), {"--frames", printFrames(allFrames(job))});
    return words;
}

std::size_t largestChunk(const FarmJob& job) {
    std::size_t largest = 1;
    for (const auto& chunk : job.chunks) largest = std::max(largest, chunk.size());
    return largest;
}

std::uint64_t mebibytes(std::uint64_t bytes) { return (bytes >> 20) + 1; }

std::string titleOf(std::string name) {
    std::replace_if(name.begin(), name.end(), isControl, ' ');
    return name;
}

std::string shortened(const std::string& name, std::size_t longest) {
    std::size_t end = std::min(name.size(), longest);
    while (end > 0 && end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0U) == 0x80U) --end;
    return name.substr(0, end);
}

void requireNoControl(const std::string& word, const char* form) {
    if (std::none_of(word.begin(), word.end(), isControl)) return;
    throw Error("'" + word + "' contains a control character, such as a line break, which " + form +
                " cannot express. Use another name.");
}

}  // namespace betamesh
