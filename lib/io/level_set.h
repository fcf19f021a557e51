// Meshes as level sets of OpenVDB.

#pragma once

#include "betamesh/io.h"

#include <string>

namespace betamesh {

/// Encodes a .vdb file with the grid `surface` of class level set: signed distances to the mesh, negative inside, in a
/// narrow band of voxels. Cavities are outside, as are voids of closed meshes in general. If asked for, the grid `v`
/// has the velocity of the nearest point of the mesh in the same voxels.
///
/// in      closed mesh; components of negative volume bound cavities, unless the whole mesh has a negative volume.
///         Parts that cross or overlap are joined
/// same    bytes for the same mesh and any thread count
/// cost    O(area / voxel²) time and memory, for an extent of any size
/// errors  voxels so small that they cannot be numbered, or that would need more memory than the limit
/// source  OpenVDB, tools/MeshToVolume.h
std::string encodeLevelSet(const Mesh& mesh, const std::string& file, const LevelSetOptions& options);

}  // namespace betamesh
