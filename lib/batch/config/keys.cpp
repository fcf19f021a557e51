// The table of keys, and finding and setting keys by name.

#include "base/edit_distance.h"
#include "batch/config/key_tables.h"
#include "betamesh/error.h"

#include <algorithm>

namespace betamesh {
namespace {

/// "radius" of "surface.radius".
std::string_view lastWord(std::string_view path) { return path.substr(path.rfind('.') + 1); }

/// "surface." of "surface.radius"; empty for a key at the top level.
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
    std::vector<std::string> names{"version", "include", "outputs"};
    for (const ConfigKey& key : configKeys()) {
        names.push_back(key.path);
        const std::string section = key.path.substr(0, key.path.find('.'));
        if (section != key.path && section != names[names.size() - 2]) names.push_back(section);
    }
    // The last word counts most, so that a correct key in the wrong section is found; the whole path breaks ties.
    constexpr std::size_t kWrongSectionCost = 2;
    const auto distance = [&](const std::string& name) {
        const std::size_t last_word = editDistance(lastWord(unknown), lastWord(name));
        const std::size_t whole = editDistance(unknown, name);
        return std::pair(last_word + (sectionOf(unknown) == sectionOf(name) ? 0 : kWrongSectionCost), whole);
    };
    return *std::min_element(names.begin(), names.end(),
                             [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
}

void setConfigKey(Config& config, const std::string& path, const std::string& value, const std::string& where) {
    const auto& keys = configKeys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.path == path; });
    if (key == keys.end() && (path == "version" || path == "include" || path == "outputs"))
        throw Error(where + ": '" + path + "' can only be set at the top level of a pipeline file");
    if (key == keys.end()) {
        throw Error(where + ": unknown key '" + path + "'. Did you mean '" + nearestConfigKey(path) + "'?");
    }
    try {
        key->set(config, value);
    } catch (const Error& error) {
        const bool is_option = where.starts_with('-') && !where.starts_with("--set ");
        const bool repeats = where == "--" + path;
        throw Error(where + (repeats ? "" : is_option ? " (" + path + ')' : ": " + path) + ": " + error.what());
    }
}

KeyValue keyValueOf(const std::string& assignment, const std::string& option) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw Error(option + ' ' + assignment + " is not a setting. Use KEY=VALUE, as in surface.radius=1.5dx.");
    }
    return {assignment.substr(0, equals), assignment.substr(equals + 1), option + ' ' + assignment};
}

void setConfigKey(Config& config, const std::string& assignment) {
    const auto [path, value, where] = keyValueOf(assignment);
    setConfigKey(config, path, value, where);
}

}  // namespace betamesh
