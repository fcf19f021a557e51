#include "io/vtk_cells.h"

#include "betamesh/error.h"

#include <algorithm>
#include <array>

namespace betamesh {

namespace {

// VTK's numbers of cell types.
enum CellType : std::int64_t { line = 3, poly_line = 4, triangle = 5, triangle_strip = 6, polygon = 7, quad = 9 };

CellKind kindOf(const std::vector<std::int64_t>& types, std::size_t cell) {
    switch (cell < types.size() ? types[cell] : 0) {
        case line:
        case poly_line:
            return CellKind::lines;
        case triangle:
        case polygon:
        case quad:
            return CellKind::polygons;
        case triangle_strip:
            return CellKind::strips;
        default:
            return CellKind::vertices;
    }
}

bool hasArea(CellKind kind) { return kind == CellKind::polygons || kind == CellKind::strips; }

}  // namespace

std::uint64_t polygonsAmong(const std::vector<std::int64_t>& types) {
    std::uint64_t polygons = 0;
    for (std::size_t cell = 0; cell < types.size(); ++cell) polygons += hasArea(kindOf(types, cell));
    return polygons;
}

void addCells(const std::vector<CellList>& lists, const std::vector<std::int64_t>& types, const ReadOptions& options,
              const std::string& file, FileContents& contents) {
    if (!options.faces) {
        contents.unread_polygons += polygonsAmong(types);
        for (const CellList& list : lists)
            if (hasArea(list.kind) && !list.offset.empty()) contents.unread_polygons += list.offset.size() - 1;
        return;
    }
    const auto n = static_cast<std::int64_t>(contents.position.size());
    std::size_t typed = 0;
    std::vector<std::uint32_t> corners;
    for (const CellList& list : lists) {
        const auto size = static_cast<std::int64_t>(list.corner.size());
        for (std::size_t c = 0; c + 1 < list.offset.size(); ++c) {
            const std::int64_t begin = list.offset[c], end = list.offset[c + 1];
            if (begin < 0 || begin > end || end > size)
                throw Error(file + ": cell " + std::to_string(c) + " has corners " + std::to_string(begin) + " to " +
                            std::to_string(end) + ", expected ascending offsets up to " + std::to_string(size));
            const CellKind kind = list.kind == CellKind::typed ? kindOf(types, typed++) : list.kind;
            if (kind == CellKind::vertices) continue;
            corners.clear();
            for (std::int64_t i = begin; i < end; ++i) {
                const std::int64_t corner = list.corner[static_cast<std::size_t>(i)];
                if (corner < 0 || corner >= n)
                    throw Error(file + ": cell " + std::to_string(c) + " has corner " + std::to_string(corner) +
                                ", expected 0 to " + std::to_string(n - 1));
                corners.push_back(static_cast<std::uint32_t>(corner));
            }
            if (kind == CellKind::lines) {
                contents.declares_edges = true;
                for (std::size_t i = 1; i < corners.size(); ++i) contents.edges.push_back({corners[i - 1], corners[i]});
                continue;
            }
            contents.declares_faces = true;
            if (kind == CellKind::polygons) {
                appendFan(corners, contents.triangles);
                continue;
            }
            for (std::size_t i = 2; i < corners.size(); ++i)
                contents.triangles.push_back(i % 2 == 0 ? Triangle{corners[i - 2], corners[i - 1], corners[i]}
                                                        : Triangle{corners[i - 1], corners[i - 2], corners[i]});
        }
    }
}

std::string attributeName(std::string name) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ') c = '_';
    if (name.empty()) name = "unnamed";
    if (name == kVtkNormals) return "N";
    return name == "P" ? "P_" : name;
}

}  // namespace betamesh
