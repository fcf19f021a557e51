// The table of keys, a function for each section. A new key is a member of Config and a row in one of them; everything
// else follows.

#pragma once

#include "batch/config/config.h"

#include <vector>

namespace betamesh {

/// Each appends the keys of its section; addInputKeys also `frames`.
void addPresetKey(std::vector<ConfigKey>& keys);
void addInputKeys(std::vector<ConfigKey>& keys);
void addSurfaceKeys(std::vector<ConfigKey>& keys);
void addPerturbationKeys(std::vector<ConfigKey>& keys);
void addSmoothingKeys(std::vector<ConfigKey>& keys);
void addFeaturesKeys(std::vector<ConfigKey>& keys);
void addOutputKeys(std::vector<ConfigKey>& keys);
void addPictureKeys(std::vector<ConfigKey>& keys);
void addPreviewKeys(std::vector<ConfigKey>& keys);
void addRunKeys(std::vector<ConfigKey>& keys);

}  // namespace betamesh
