// OpenVDB points (.vdb).
//
// Read: point positions, numeric attributes and requested groups of the chosen grids of type PointDataGrid, with any
// codec. Strings, matrices, quaternions and grids of other types are skipped.
// Written: one PointDataGrid.
// Format: see vdb_file.cpp.

#pragma once

#include "betamesh/particles.h"
#include "io/file_contents.h"

#include <filesystem>

namespace betamesh {

/// Reads the points of the chosen point grids, in world units, leaf by leaf.
///
/// errors  a file without point grids; a grid or group that is asked for and not there; a truncated file, whatever else
/// OpenVDB reports. OpenVDB does not check the
///         contents of grids: damaged bytes there can terminate the process.
///         Programs that read files from unknown sources should do so in a process of their own.
FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options = {});

/// Encodes one grid `points` with the attributes P and v (float, not quantised), id (int64) and the other attributes;
/// those of which isPointGroup() is true as point groups.
/// The voxel size is a power of two and offsets within voxels are floats, so that positions are preserved exactly.
///
/// same    bytes for the same particles
std::string encodeVdb(const Particles& particles, const std::string& file);

}  // namespace betamesh
