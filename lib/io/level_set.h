// Meshes as level sets of OpenVDB.

#pragma once

#include "betamesh/io.h"

#include <string>
#include <string_view>

namespace betamesh {

/// The beginning of the warning of an open mesh whose level set is empty.
inline constexpr std::string_view kNoInside = "the mesh has no inside";

/// Encodes a .vdb file with the grid `surface` of class level set: signed distances to the mesh, negative inside, in a
/// narrow band of voxels; exact within a voxel of the surface, at most a third of a voxel too large in the rest of the
/// band. Cavities are outside. If asked for, the grid `v` has the velocity of the nearest point of the mesh in the same
/// voxels.
///
/// in      closed mesh; components of negative volume bound cavities, unless the whole mesh has a negative volume.
///         Parts that cross or overlap are joined
/// same    bytes for the same mesh and any thread count
/// cost    O(area / voxel²) time and memory, for an extent of any size
/// errors  voxels so small that they cannot be numbered; MemoryError if the voxels would need more memory than the
/// limit.
///         warn, which may be null, gets a sentence on parts that are missing
/// source  OpenVDB, tools/MeshToVolume.h
std::string encodeLevelSet(const Mesh& mesh, const std::string& file, const LevelSetOptions& options,
                           const WarningHandler& warn = {});

/// Estimated peak memory of encodeLevelSet() for a mesh of this area (world units squared), without that of the mesh;
/// bytes. Measured on a splash: 0.8 of this.
double levelSetMemory(double area, const LevelSetOptions& options);

}  // namespace betamesh
