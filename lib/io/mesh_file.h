// Reads and writes meshes and spheres; the extension selects the format.

#pragma once

#include "betamesh/mesh.h"
#include "io/output_file.h"

#include <filesystem>

namespace betamesh {

/// Reads .ply, .bgeo (classic) and .obj. Polygons with more than three corners are split into fans of triangles.
///
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         mesh. Messages begin with the file's name
Mesh readMesh(const std::filesystem::path& path);

/// Writes .ply, .bgeo, .bgeo.gz or .obj. The file appears under its name only when it is complete.
/// Positions are rounded to float. Velocity is always written (zeros if the mesh has none), so that all frames of a
/// sequence have the same attributes. Components become a face property in .ply and a primitive attribute in .bgeo. An
/// .obj contains positions and faces only; each component becomes an object `component_N`.
void writeMesh(const std::filesystem::path& path, const Mesh& mesh);
/// Like writeMesh(), but leaves commit() to the caller. commit() waits for the disk and hardly needs the processor.
OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh);

/// Writes points with a radius, velocity and id: .ply (property `radius`) or .bgeo, .bgeo.gz (attribute `pscale`).
///
/// errors  .obj, which cannot store a radius
void writeSpheres(const std::filesystem::path& path, const Spheres& spheres);

/// Throws Error unless meshes can be written in the format of this extension. Does not access the disk.
void requireMeshExtension(const std::filesystem::path& path);

}  // namespace betamesh
