// VTK's files: legacy .vtk in, XML .vtu and .vtp in, XML .vtp out.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/file_contents.h"

namespace betamesh {

/// Legacy files of versions 1 to 5, ascii or binary: the points of POLYDATA and UNSTRUCTURED_GRID with the arrays of
/// their POINT_DATA (SCALARS, VECTORS, NORMALS, TENSORS, TEXTURE_COORDINATES, COLOR_SCALARS, GLOBAL_IDS, FIELD), and
/// polygons. An array `Normals` becomes the attribute `N`. Cells without an area, cell data, lookup tables and metadata
/// are passed over.
///
/// errors  another kind of data set; damaged sections, by byte
/// source  "VTK File Formats" in the documentation of VTK
FileContents parseVtk(Cursor in, const ReadOptions& options = {});

/// XML files (.vtu, .vtp): all pieces; arrays as ascii, base64 or appended data, raw or base64, plain or compressed by
/// zlib; header_type UInt32 or UInt64; both byte orders. Otherwise as parseVtk.
///
/// errors  other kinds of data set and other compressors, by name; XML that cannot be read; damaged arrays
FileContents parseVtkXml(Cursor in, const ReadOptions& options = {});

/// A .vtp: appended raw data, little-endian, not compressed. Velocity becomes the array `velocity`, an attribute `N` of
/// three floats the active normals `Normals` (a mesh without them gets vertexNormals()), ids the array `id`, components
/// the cell array `component`.
void encodeVtp(ByteWriter& out, const Particles& particles, const std::string& file);
void encodeVtp(ByteWriter& out, const Mesh& mesh, const std::string& file);
void encodeVtp(ByteWriter& out, const Curves& curves, const std::string& file);

}  // namespace betamesh
