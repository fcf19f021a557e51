// Meshes and spheres on disk, in whichever format the extension says.

#pragma once

#include "betamesh/mesh.h"
#include "io/output_file.h"

#include <filesystem>

namespace betamesh {

/// Reads .ply, .bgeo (any of Houdini's formats) and .obj. Polygons with more than three corners become
/// fans of triangles.
///
/// errors  an unknown extension (lists the known ones); a file that is missing, damaged or of another
///         kind: the text begins with the file's name
Mesh readMesh(const std::filesystem::path& path);

/// Writes .ply, .bgeo, .bgeo.gz, .bgeo.sc, .bhclassic or .obj; nothing stands under that name before it is complete.
/// Positions are rounded to float. Velocity is always declared (zeros where the mesh has none), so that
/// all frames of a sequence declare the same attributes. Components are a property of faces, in .bgeo an attribute of
/// primitives; .obj holds positions and faces only, and each component as an object `component_N`.
void writeMesh(const std::filesystem::path& path, const Mesh& mesh);
/// The same but for commit(), which waits for the disk and needs no processor.
OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh);

/// Writes points with a radius: .ply (property `radius`) or .bgeo, .bgeo.gz, .bgeo.sc, .bhclassic (`pscale`), velocity
/// and id beside it. An .obj cannot hold a radius: Error.
void writeSpheres(const std::filesystem::path& path, const Spheres& spheres);

/// Throws the Error for an unknown extension without touching the disk.
void requireMeshExtension(const std::filesystem::path& path);

}  // namespace betamesh
