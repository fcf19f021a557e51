// Reads and writes meshes and spheres; the extension selects the format.

#pragma once

#include "betamesh/mesh.h"
#include "io/output_file.h"

#include <filesystem>

namespace betamesh {

/// Reads a file in the format of its extension; fileFormats() lists them. Polygons with more than three corners are
/// split into fans of triangles.
///
/// errors  an unknown extension (the message lists the known ones); a file that is missing, damaged or contains no
///         mesh. Messages begin with the file's name
Mesh readMesh(const std::filesystem::path& path);

/// Writes the format of the extension. The file appears under its name only when it is complete. Positions are rounded
/// to float. Velocity is always written (zeros if the mesh has none), so that all frames of a sequence have the same
/// attributes; lossesOf() tells which formats have no place for it. Components become a face property in .ply, a
/// primitive attribute in .bgeo, cell data in .vtp, an object `component_N` each in .obj. A .vtp or .obj has vertex
/// normals: the attribute `N` of three floats, or vertexNormals() if there is none.
void writeMesh(const std::filesystem::path& path, const Mesh& mesh);
/// Like writeMesh(), but leaves commit() to the caller. commit() waits for the disk and hardly needs the processor.
OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh);

/// Writes points with a radius (`pscale` in formats of Houdini, `radius` in others), velocity and id.
///
/// errors  a format for which canHoldSpheres() is false
void writeSpheres(const std::filesystem::path& path, const Spheres& spheres);
bool canHoldSpheres(const std::filesystem::path& path);

/// Throws Error unless meshes can be written in the format of this extension. Does not access the disk.
void requireMeshExtension(const std::filesystem::path& path);

}  // namespace betamesh
