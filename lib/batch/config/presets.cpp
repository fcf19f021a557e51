
#include "batch/config/presets.h"

#include "base/edit_distance.h"
#include "betamesh/error.h"

#include <algorithm>

namespace betamesh {

std::string_view descriptionOf(const Preset& preset) {
    const std::string_view line = preset.text.substr(0, preset.text.find('\n'));
    return line.substr(std::min(line.find_first_not_of("# "), line.size()));
}

std::string presetNames(std::string_view separator) {
    std::string names;
    for (const Preset& preset : presets()) {
        if (!names.empty()) names += separator;
        names += preset.name;
    }
    return names;
}

const Preset& presetNamed(std::string_view name) {
    const auto all = presets();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Preset& preset) { return preset.name == name; });
    if (found != all.end()) return *found;
    const auto nearest = std::min_element(all.begin(), all.end(), [&](const Preset& a, const Preset& b) {
        return editDistance(a.name, name) < editDistance(b.name, name);
    });
    throw Error("unknown preset '" + std::string(name) + "'. Did you mean '" + std::string(nearest->name) +
                "'? Presets: " + presetNames(", ") + '.');
}

}  // namespace betamesh
