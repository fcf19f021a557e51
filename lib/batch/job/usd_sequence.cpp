#include "batch/job/usd_sequence.h"

#include "base/lower_case.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "io/usd_clips.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

bool isUsda(const std::string& path) { return lowerCase(fs::path(path).extension().string()) == ".usda"; }

std::string contentsOf(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string assetOf(const std::string& path, const fs::path& folder) {
    return "./" + fs::path(path).lexically_proximate(folder).generic_string();
}

/// Whether a layer plays files that are on disk and are not of this sequence.
bool playsOthers(const std::string& layer, const FramePattern& files) {
    const fs::path folder = folderOf(layer);
    std::set<std::string> own;
    for (const auto& [frame, path] : framesOnDisk(files)) own.insert(assetOf(path, folder));
    const std::string text = contentsOf(layer);
    const std::size_t list = text.find("assetPaths = [");
    if (list == std::string::npos) return false;
    std::istringstream assets(text.substr(list, text.find("]\n", list) - list));
    std::string asset;
    for (std::getline(assets, asset, '@'); std::getline(assets, asset, '@');) {
        std::error_code ignored;
        if (!own.contains(asset) && asset.starts_with("./") && fs::exists(folder / asset, ignored)) return true;
        std::getline(assets, asset, '@');  // what separates it from the next
    }
    return false;
}

std::string layerText(const FramePattern& files, const std::string& layer, const WriteOptions& options) {
    const fs::path folder = folderOf(layer);
    std::vector<ClipFile> clips;
    for (const auto& [frame, path] : framesOnDisk(files)) clips.push_back({frame, assetOf(path, folder), path});
    return usdClipsLayer(clips, "./" + fs::path(layer).filename().string(), options);
}

}  // namespace

std::string sequenceLayer(const FramePattern& files) {
    if (!files.numbered || !isUsda(files.text)) return {};
    // The folder is the one before the first placeholder; the name that of the file without placeholders.
    const std::string& before = files.parts.front();
    const std::string folder = before.substr(0, before.rfind('/') + 1);
    std::string name;
    for (std::size_t i = 0; i < files.parts.size(); ++i) {
        if (i > 0) name.erase(name.find_last_not_of("._-") + 1);
        const std::string& part = files.parts[i];
        if (const std::size_t slash = part.rfind('/'); slash != std::string::npos)
            name = part.substr(slash + 1);
        else
            name += part;
    }
    return folder + (name.starts_with('.') ? "sequence" : "") + name;
}

void requireOwnSequenceLayer(const FramePattern& files) {
    const std::string layer = sequenceLayer(files);
    std::error_code ignored;
    if (layer.empty() || !fs::exists(fs::symlink_status(layer, ignored))) return;
    if (isEditedUsdClipsLayer(layer) || (isUsdClipsLayer(layer) && !playsOthers(layer, files))) return;
    throw Error(layer + " already exists, and is not a layer that this program wrote to play the sequence '" +
                files.text + "'. Move it away, or choose another name for the output.");
}

void writeSequenceLayer(const FramePattern& files, const WriteOptions& options) {
    const std::string layer = sequenceLayer(files);
    if (layer.empty()) return;
    requireOwnSequenceLayer(files);
    if (isEditedUsdClipsLayer(layer)) {
        logWarning(layer +
                   ": was edited after this program wrote it, and stays as it is. Delete it, and run the "
                   "command again, to get a layer that plays the frames on disk");
        return;
    }
    // Another task may have finished files since they were listed, so they are listed again after writing.
    std::string written;
    for (std::string text = layerText(files, layer, options); text != written;
         text = layerText(files, layer, options)) {
        if (text.empty()) return;
        if (text != contentsOf(layer)) writeFile(layer, text);
        written = std::move(text);
    }
}

std::vector<std::string> withoutSequenceLayers(std::vector<std::string> files) {
    if (files.size() < 2) return files;
    std::erase_if(files, [](const std::string& file) {
        const bool is_layer = isUsda(file) && isUsdClipsLayer(file);
        if (is_layer) logInfo(file + ": left out. It is the layer that plays a sequence, and has no mesh of its own");
        return is_layer;
    });
    return files;
}

}  // namespace betamesh
