#include "io/usd_clips.h"

#include "io/usd.h"

#include <algorithm>
#include <fstream>
#include <optional>

namespace betamesh {

namespace {

constexpr std::string_view kMarker = "string betamesh = \"plays a sequence\"";
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

/// A path between the signs that mark it in USD.
std::string assetText(const std::string& path) {
    const std::string mark = path.find('@') == std::string::npos ? "@" : "@@@";
    return mark + path + mark;
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
        for (const std::string& attribute : declared->attributes)
            if (std::find(attributes.begin(), attributes.end(), attribute) == attributes.end())
                attributes.push_back(attribute);
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
    return text + "    }\n}\n";
}

bool isUsdClipsLayer(const std::filesystem::path& path) {
    return beginningOf(path, kMarker.size() + 256).find(kMarker) != std::string::npos;
}

}  // namespace betamesh
