// Wrapper of OpenVDB: what the reader (vdb_file.cpp) and the writer (vdb_writer.cpp) of .vdb share.

#pragma once

namespace betamesh {

/// Initialises OpenVDB once; may be called from any thread.
void initializeVdb();

}  // namespace betamesh
