// The table of configuration keys, one function per section. To add a key, add a member to Config and a row to one of
// these functions; YAML, --set, options, `config print`, the man page and completions follow from that row.

#pragma once

#include "batch/config/config.h"

#include <vector>

namespace betamesh {

/// Each function appends the keys of its section; addInputKeys() also appends `frames`.
/// addOutputKeys() includes addSurfaceOutputKeys(), those of what is measured on the surface.
void addPresetKey(std::vector<ConfigKey>& keys);
void addInputKeys(std::vector<ConfigKey>& keys);
void addParticleKeys(std::vector<ConfigKey>& keys);
void addSurfaceKeys(std::vector<ConfigKey>& keys);
void addPerturbationKeys(std::vector<ConfigKey>& keys);
void addSmoothingKeys(std::vector<ConfigKey>& keys);
void addFeaturesKeys(std::vector<ConfigKey>& keys);
void addSurfaceOutputKeys(std::vector<ConfigKey>& keys);
void addOutputKeys(std::vector<ConfigKey>& keys);
void addPictureKeys(std::vector<ConfigKey>& keys);
void addPreviewKeys(std::vector<ConfigKey>& keys);
void addRunKeys(std::vector<ConfigKey>& keys);

}  // namespace betamesh
