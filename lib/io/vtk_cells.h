// Cells of VTK files, legacy or XML, as triangles and edges.

#pragma once

#include "io/file_contents.h"

#include <cstdint>
#include <string>
#include <vector>

namespace betamesh {

enum class CellKind { vertices, lines, polygons, strips, typed };

/// Cell c has the corners offset[c] … offset[c + 1] - 1.
struct CellList {
    CellKind kind;
    std::vector<std::int64_t> offset;
    std::vector<std::int64_t> corner;
};

/// How many cells of these types, in VTK's numbers, have an area.
std::uint64_t polygonsAmong(const std::vector<std::int64_t>& types);

/// Adds what has an area as triangles and what is a line as edges; counts the former if options ask for points alone.
/// types: of all cells of kind `typed`, in VTK's numbers.
///
/// errors  offsets that do not ascend or leave the corners, corners that are no points
void addCells(const std::vector<CellList>& lists, const std::vector<std::int64_t>& types, const ReadOptions& options,
              const std::string& file, FileContents& contents);

/// A damaged file may give any number of components to an array.
inline constexpr std::uint64_t kMostComponents = 1000;

/// The name that VTK's own filters give to normals; here they are the attribute `N`.
inline constexpr const char* kVtkNormals = "Normals";

/// The name of an attribute for that of an array: white space becomes an underscore, kVtkNormals `N`; "P" and empty
/// names get another one.
std::string attributeName(std::string name);

}  // namespace betamesh
