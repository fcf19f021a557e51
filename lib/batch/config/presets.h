// Presets: the settings in configs/NAME.yaml, which are compiled into the program.

#pragma once

#include <span>
#include <string>
#include <string_view>

namespace betamesh {

struct Preset {
    std::string_view name;
    std::string_view text;  ///< a pipeline file; its first line is a comment that describes the preset
};

/// All presets in alphabetical order.
std::span<const Preset> presets();

/// The first line of the preset, without the comment sign.
std::string_view descriptionOf(const Preset& preset);

/// The names of all presets with a separator between them.
std::string presetNames(std::string_view separator);

/// errors  an unknown name, with the most similar name and a list of all names
const Preset& presetNamed(std::string_view name);

}  // namespace betamesh
