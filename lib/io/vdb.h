// OpenVDB points (.vdb).
//
// Read: point positions and numeric attributes of all grids of type PointDataGrid, with any codec. Skipped: strings,
// groups, matrices, quaternions and grids of other types. Written: one PointDataGrid. Format: see vdb_file.cpp.

#pragma once

#include "betamesh/particles.h"
#include "io/file_contents.h"

#include <filesystem>

namespace betamesh {

/// Loads OpenVDB, which is otherwise loaded when it is first needed.
///
/// errors  OpenVDB cannot be found
void loadVdb();

/// Reads the points of all point grids, in world units, leaf by leaf.
///
/// errors  a file without point grids, a truncated file, whatever else OpenVDB reports. OpenVDB does not check the
/// contents
///         of grids: damaged bytes there can terminate the process, unless another process reads the file
///         (io/vdb_process.h).
FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options = {});

/// Encodes one grid `points` with the attributes P and v (float, not quantised), id (int64) and the other attributes.
/// The voxel size is a power of two and offsets within voxels are floats, so that positions are preserved exactly.
///
/// same    bytes for the same particles
std::string encodeVdb(const Particles& particles, const std::string& file);

}  // namespace betamesh
