// Keys by their names.

#include "batch/config/edit_distance.h"
#include "batch/config/tables.h"
#include "betamesh/error.h"

#include <algorithm>

namespace betamesh {
namespace {

std::string_view lastWord(std::string_view path) { return path.substr(path.rfind('.') + 1); }

/// Empty at the top level.
std::string_view sectionOf(std::string_view path) { return path.substr(0, path.size() - lastWord(path).size()); }

}  // namespace

const std::vector<ConfigKey>& configKeys() {
    static const std::vector<ConfigKey> keys = [] {
        std::vector<ConfigKey> all;
        for (const auto& add : {addPresetKey, addInputKeys, addSurfaceKeys, addPerturbationKeys, addSmoothingKeys,
                                addFeaturesKeys, addOutputKeys, addPictureKeys, addPreviewKeys, addRunKeys})
            add(all);
        return all;
    }();
    return keys;
}

std::string nearestConfigKey(std::string_view unknown) {
    std::vector<std::string> names{"version", "include"};
    for (const ConfigKey& key : configKeys()) {
        names.push_back(key.path);
        const std::string section = key.path.substr(0, key.path.find('.'));
        if (section != key.path && section != names[names.size() - 2]) names.push_back(section);
    }
    // A right word in a wrong section is nearer than a wrong word in the right one; between equals the whole path
    // decides.
    constexpr std::size_t kWrongSection = 2;
    const auto distance = [&](const std::string& name) {
        const std::size_t words = editDistance(lastWord(unknown), lastWord(name));
        const std::size_t whole = editDistance(unknown, name);
        return std::pair(words + (sectionOf(unknown) == sectionOf(name) ? 0 : kWrongSection), whole);
    };
    return *std::min_element(names.begin(), names.end(),
                             [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
}

void setConfigKey(Config& config, const std::string& path, const std::string& value, const std::string& where) {
    const auto& keys = configKeys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.path == path; });
    if (key == keys.end()) {
        throw Error(where + ": unknown key '" + path + "'; the nearest known key is '" + nearestConfigKey(path) + "'");
    }
    try {
        key->set(config, value);
    } catch (const Error& error) {
        throw Error(where + ": " + path + ": " + error.what());
    }
}

KeyValue keyValueOf(const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw Error("--set " + assignment + ": expected key=value, such as surface.radius=1.5dx");
    }
    return {assignment.substr(0, equals), assignment.substr(equals + 1), "--set " + assignment};
}

void setConfigKey(Config& config, const std::string& assignment) {
    const auto [path, value, where] = keyValueOf(assignment);
    setConfigKey(config, path, value, where);
}

}  // namespace betamesh
