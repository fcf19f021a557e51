// Keys by their names.

#include "batch/config_tables.h"
#include "core/error.h"

#include <algorithm>

namespace betamesh {
namespace {

/// Levenshtein's distance: single characters inserted, removed or replaced.
std::size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

std::string_view lastWord(std::string_view path) { return path.substr(path.rfind('.') + 1); }

/// Empty at the top level.
std::string_view sectionOf(std::string_view path) { return path.substr(0, path.size() - lastWord(path).size()); }

}  // namespace

const std::vector<ConfigKey>& configKeys() {
    static const std::vector<ConfigKey> keys = [] {
        std::vector<ConfigKey> all;
        for (const auto& add : {addInputKeys, addSurfaceKeys, addPerturbationKeys, addSmoothingKeys, addFeaturesKeys,
                                addOutputKeys, addPictureKeys, addPreviewKeys, addRunKeys})
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

void setConfigKey(Config& config, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw Error("--set " + assignment + ": expected key=value, such as surface.radius=1.5dx");
    }
    setConfigKey(config, assignment.substr(0, equals), assignment.substr(equals + 1), "--set " + assignment);
}

}  // namespace betamesh
