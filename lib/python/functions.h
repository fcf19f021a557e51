// The functions of the module, by topic.

#pragma once

#include "python/binding.h"

namespace betamesh {

/// skin(), skin_plane(), spacing() and the table of settings.
void addSurfaceFunctions(nb::module_& module);
/// check(), measure() and coherence().
void addMeasureFunctions(nb::module_& module);
/// Functions that read and write files.
void addFileFunctions(nb::module_& module);

}  // namespace betamesh
