// OpenVDB trusts what stands inside a grid: altered bytes there make it end its process, write where it should not, or
// take all memory. So a job has another process read its .vdb files, each file a new one.

#pragma once

#include "io/file_contents.h"

#include <filesystem>

namespace betamesh {

/// From here on readVdb() goes by readVdbApart() and loadVdb() by loadVdbApart(). To be called once, before the process
/// has a second thread; what it starts ends with this process.
///
/// errors  where the system grants no process
void startVdbProcess();
bool hasVdbProcess();

/// As readVdb(). A file that ends the process which reads it, or takes more memory or time there than honest ones of
/// its size do, is an Error. From any thread.
///
/// cost    a fork, and a copy of the points through a pipe
FileContents readVdbApart(const std::filesystem::path& path, const ReadOptions& options);

/// Makes the first file no slower than others. Returns at once.
void loadVdbApart();

}  // namespace betamesh
