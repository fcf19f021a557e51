// Wrapper of OpenVDB: what the reader (vdb_reader.cpp) and the writers (vdb_writer.cpp, level_set.cpp) of .vdb share.

#pragma once

#include <openvdb/Grid.h>

#include <string>

namespace betamesh {

/// Initialises OpenVDB once; may be called from any thread.
void initializeVdb();

/// The bytes of a file of these grids.
///
/// same    bytes for the same grids
std::string archiveOf(const openvdb::GridCPtrVec& grids);

}  // namespace betamesh
