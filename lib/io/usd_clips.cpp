#include "io/usd_clips.h"

#include "io/digest.h"
#include "io/usd.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

namespace betamesh {

namespace {

constexpr std::string_view kMarker = "string betamesh = \"plays a sequence\"";
constexpr std::string_view kDigest = "        string betamesh_digest = \"";
constexpr std::size_t kBeginning = std::size_t{1} << 16;  // bytes of a file in which declarations have to end

std::string beginningOf(const std::filesystem::path& path, std::size_t bytes) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return {};
    std::ifstream in(path, std::ios::binary);
    std::string text(bytes, '\0');
    in.read(text.data(), static_cast<std::streamsize>(bytes));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

/// What a file of encodeUsda() declares.
struct Declarations {
    std::string prim;                     ///< `    def Mesh "mesh"`
    std::vector<std::string> attributes;  ///< each with its metadata and the line break
};

/// nullopt: another file, or one without time samples.
std::optional<Declarations> declarationsIn(const std::string& text) {
    constexpr std::string_view kDef = "\n    def ", kOpen = "\n    {\n", kIndent = "        ";
    const std::size_t def = text.find(kDef);
    if (!text.starts_with("#usda 1.0\n") || def == std::string::npos) return std::nullopt;
    const std::size_t open = text.find(kOpen, def + 1), end = text.find(".timeSamples = {", def);
    if (open == std::string::npos || end == std::string::npos || end < open) return std::nullopt;
    Declarations found{text.substr(def + 1, open - def - 1), {}};
    for (std::size_t at = open + kOpen.size(); at < end;) {
        std::size_t next = text.find('\n', at);
        if (next == std::string::npos || next > end) break;
        if (text[next - 1] == '(') next = text.find("\n        )\n", at) + std::string_view("\n        )").size();
        if (next >= end || text.compare(at, kIndent.size(), kIndent) != 0) return std::nullopt;
        found.attributes.push_back(text.substr(at, next + 1 - at));
        at = next + 1;
    }
    return found;
}

/// Adds the declaration of an attribute, unless there is one of that name: USD cannot open a layer with both. Frames
/// whose numbers are whole may have integers where others have floats; then that with floats is kept.
void addDeclaration(const std::string& attribute, std::vector<std::string>& attributes) {
    const auto typeAndName = [](const std::string& declaration) {
        std::istringstream words(declaration);
        std::pair<std::string, std::string> found;
        words >> found.first >> found.second;
        if (found.first == "uniform") words >> found.second;
        return found;
    };
    const auto own = typeAndName(attribute);
    const auto known = std::ranges::find_if(
        attributes, [&](const std::string& other) { return typeAndName(other).second == own.second; });
    if (known == attributes.end())
        attributes.push_back(attribute);
    else if (typeAndName(*known).first.starts_with("int") && own.first.starts_with("float"))
        *known = attribute;
}

/// A path between the signs that mark it in USD.
std::string assetText(const std::string& path) {
    const std::string mark = path.find('@') == std::string::npos ? "@" : "@@@";
    return mark + path + mark;
}

/// The line with the digest of the rest of a layer.
std::string digestLine(const std::string& rest) {
    const Digest digest = digestOf(std::as_bytes(std::span(rest)));
    std::ostringstream line;
    line << kDigest << std::hex << std::setfill('0');
    for (const std::uint64_t half : digest) line << std::setw(16) << half;
    line << "\"\n";
    return line.str();
}

/// The value behind `    key = ` in the header of a layer; empty: none.
std::string headerValue(const std::string& text, const std::string& key) {
    const std::string before = "\n    " + key + " = ";
    const std::size_t at = text.find(before), end = text.find("\n)\n");
    if (at == std::string::npos || end == std::string::npos || at > end) return {};
    const std::size_t begin = at + before.size();
    return text.substr(begin, text.find('\n', begin) - begin);
}

std::string pair(std::string first, const std::string& second) { return "(" + std::move(first) + ", " + second + ")"; }

}  // namespace

std::string usdClipsLayer(const std::vector<ClipFile>& files, const std::string& asset, const WriteOptions& options) {
    std::string prim, active, paths, times;
    std::vector<std::string> attributes;
    std::optional<int> first, last;
    std::size_t clip = 0;
    for (const ClipFile& file : files) {
        const auto declared = declarationsIn(beginningOf(file.path, kBeginning));
        if (!declared || (!prim.empty() && declared->prim != prim)) continue;
        prim = declared->prim;
        for (const std::string& attribute : declared->attributes) addDeclaration(attribute, attributes);
        const std::string comma = last ? ", " : "", frame = std::to_string(file.frame);
        active += comma + pair(frame, std::to_string(clip++));
        paths += comma + assetText(file.asset);
        // Two times at the start of a frame are a jump: until there the clip before shows its own frame.
        if (last) times += comma + pair(frame, std::to_string(*last));
        times += comma + pair(frame, frame);
        if (!first) first = file.frame;
        last = file.frame;
    }
    if (!last) return {};
    std::string text = usdaHeader(
        options, first, last,
        "    customLayerData = {\n        " + std::string(kMarker) + "\n    }\n    defaultPrim = \"geometry\"\n");
    text +=
        "\ndef Xform \"geometry\" (\n    clips = {\n        dictionary default = {\n            double2[] active = [" +
        active + "]\n            asset[] assetPaths = [" + paths +
        "]\n            asset manifestAssetPath = " + assetText(asset) +
        "\n            string primPath = \"/geometry\"\n            double2[] times = [" + times +
        "]\n        }\n    }\n    kind = \"component\"\n)\n{\n" + prim + "\n    {\n";
    for (const std::string& attribute : attributes) text += attribute;
    text += "    }\n}\n";
    return text.insert(text.find('\n', text.find(kMarker)) + 1, digestLine(text));
}

bool isUsdClipsLayer(const std::filesystem::path& path) {
    return beginningOf(path, kMarker.size() + 256).find(kMarker) != std::string::npos;
}

bool isEditedUsdClipsLayer(const std::filesystem::path& path) {
    if (!isUsdClipsLayer(path)) return false;
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error) return false;
    std::string text = beginningOf(path, static_cast<std::size_t>(size));
    const std::size_t begin = text.find(kDigest);
    if (begin == std::string::npos) return true;
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::string line = text.substr(begin, end - begin);
    return digestLine(text.erase(begin, end - begin)) != line;
}

void copyUsdUnits(const std::filesystem::path& path, WriteOptions& options) {
    const std::string text = beginningOf(path, kBeginning);
    const std::string up = headerValue(text, "upAxis");
    if (up.empty()) return;
    const auto copy = [&](const char* key, double& number) {
        const std::string value = headerValue(text, key);
        std::from_chars(value.data(), value.data() + value.size(), number);
    };
    copy("timeCodesPerSecond", options.frames_per_second);
    copy("metersPerUnit", options.meters_per_unit);
    options.up_axis = up == "\"Z\"" ? UpAxis::z : UpAxis::y;
}

}  // namespace betamesh
