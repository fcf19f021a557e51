// Wrapper of OpenVDB: what the reader (vdb_file.cpp) and the writer (vdb_writer.cpp) of .vdb share.

#pragma once

#include "betamesh/particles.h"

#include <string>

namespace betamesh {

/// Initialises OpenVDB once; may be called from any thread.
void initializeVdb();

/// As encodeVdb().
std::string encodeVdbPoints(const Particles& particles, const std::string& file);

}  // namespace betamesh
