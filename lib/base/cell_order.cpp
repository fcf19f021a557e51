
#include "base/cell_order.h"

namespace betamesh {

// Sorts the cells of all parts and turns each part's counts into the positions at which it writes its rows.
void CellOrder::listCells(std::vector<Part>& parts) {
    struct CellOfPart {
        CellPlace cell;
        std::uint32_t part, number;  // number: of the cell within the part
        auto operator<=>(const CellOfPart&) const = default;
    };
    std::vector<CellOfPart> cells;
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        parts[p].next.resize(parts[p].count.size());
        for (std::uint32_t number = 0; number < parts[p].count.size(); ++number)
            cells.push_back({parts[p].numbers.places()[number], p, number});
    }
    parallelSort(cells, std::less<>());

    std::uint32_t rows = 0;
    for (const auto& [cell, p, number] : cells) {
        if (cell_.empty() || cell != cell_.back()) {
            if (lines_.add({cell.z, cell.y, 0}) == line_begin_.size())
                line_begin_.push_back(static_cast<std::uint32_t>(cell_.size()));
            cell_.push_back(cell);
            begin_.push_back(rows);
        }
        parts[p].next[number] = rows;
        rows += parts[p].count[number];
    }
    line_begin_.push_back(static_cast<std::uint32_t>(cell_.size()));
    begin_.push_back(rows);
}

}  // namespace betamesh
