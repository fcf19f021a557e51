// OpenVDB points (.vdb): PointDataGrid in and out.

#pragma once

#include "betamesh/particles.h"
#include "io/file_contents.h"

#include <filesystem>

namespace betamesh {

/// The points of all point grids of a file, whatever their codecs, in world units; leaf after leaf. Attributes
/// of strings, groups, matrices and quaternions are passed over.
///
/// errors  a file without a point grid, one that is cut short, whatever else OpenVDB finds wrong. OpenVDB trusts the
///         sizes inside grids: a damaged file can make it write out of bounds, which may end the process. Programs
///         that read files of unknown origin should do so in a process of their own.
FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options = {});

/// One grid `points`: P, v (both float, not quantised), id (int64), attributes. The voxel size is a power of
/// two and offsets in a voxel are kept as float, so every position comes back bit for bit.
///
/// same    bytes for the same particles
std::string encodeVdb(const Particles& particles, const std::string& file);

}  // namespace betamesh
