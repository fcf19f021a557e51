// Mesh files that are encoded, but not committed yet, and what formats can hold.

#pragma once

#include "betamesh/io.h"
#include "io/output_file.h"

#include <filesystem>
#include <optional>

namespace betamesh {

/// Like readMesh(), for those who judge the mesh: positions and velocities may be not finite.
Mesh readUncheckedMesh(const std::filesystem::path& path, std::optional<double> frame = {});

/// Like writeMesh(), but leaves commit() to the caller. commit() waits for the disk and hardly needs the processor.
OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options = {});

/// Whether the format of this extension can hold spheres.
bool canHoldSpheres(const std::filesystem::path& path);

/// Throws Error unless meshes can be written in the format of this extension. Does not access the disk.
void requireMeshExtension(const std::filesystem::path& path);

}  // namespace betamesh
