// Alembic (.abc) in the Ogawa container.
//
// Read: one object PolyMesh or Points, static transforms above it applied; of its attributes those with a row of
// numbers per vertex. Widths, which are diameters, become the radius `pscale`. Of several time samples the one
// at ReadOptions::frame is read, or the latest before it; without that the first. Archives in HDF5, which Alembic wrote
// until 2013, are errors. Written: one frame, as an object `mesh` or `points`. Layout: alembic_layout.h, ogawa.h.

#pragma once

#include "betamesh/io.h"
#include "io/file_contents.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

/// An object of type PolyMesh: P, .faceIndices and .faceCounts (clockwise from outside, as Alembic's readers expect),
/// .velocities per second, N (normalsOf()), attributes and components (of faces) as geometry parameters of their types.
///
/// The time of the sample is options.frame (none: 0) over options.frames_per_second.
///
/// same    bytes for the same input
/// errors  a name of an attribute that the format cannot store; more than 2^31 - 1 vertices
void encodeAbc(ByteWriter& out, const Mesh& mesh, const std::string& file, const WriteOptions& options = {});

/// An object of type Points: P, .pointIds, .velocities, attributes, and .widths: twice the attribute `radius` or
/// `pscale`, if there is one.
void encodeAbc(ByteWriter& out, const Particles& particles, const std::string& file, const WriteOptions& options = {});

/// Reads the mesh, or the points, whichever options.faces asks for; if there is none, the other. Its objects count as
/// grids of FileContents, named by their paths: options.grids chooses one of several.
///
/// errors  several objects without a choice; no mesh and no points; a transform that moves
FileContents readAbc(const std::filesystem::path& path, const ReadOptions& options);

/// The times, in frames, of the samples of the geometry that readAbc() reads, ascending, each once. Empty if nothing
/// changes, or if the archive has no frame rate.
std::vector<double> abcSampleTimes(const std::filesystem::path& path, const ReadOptions& options);
FileContents parseAbc(std::span<const std::byte> bytes, const std::string& file, const ReadOptions& options);

}  // namespace betamesh
