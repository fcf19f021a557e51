// Presets: the settings in configs/NAME.yaml, which are part of the program.

#pragma once

#include "batch/config/config.h"

#include <span>
#include <string>
#include <string_view>

namespace betamesh {

struct Preset {
    std::string_view name;
    std::string_view text;  ///< a pipeline file; its first line is a comment that describes the preset
};

/// All of them, in alphabetical order.
std::span<const Preset> presets();

/// One line, without the sign of a comment.
std::string_view descriptionOf(const Preset& preset);

/// The names with something between them.
std::string presetNames(std::string_view between);

/// errors  an unknown name, with the nearest one and all others
const Preset& presetNamed(std::string_view name);

/// Sets the keys of a preset; the others stay as they are.
void applyPreset(Config& config, std::string_view name);

}  // namespace betamesh
