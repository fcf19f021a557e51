
#include "base/cell_order.h"

namespace betamesh {

void CellOrder::listCells(std::vector<Part>& parts) {
    struct Share {  // of a part in a cell
        CellPlace place;
        std::uint32_t part, number;
        auto operator<=>(const Share&) const = default;
    };
    std::vector<Share> shares;
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        parts[p].next.resize(parts[p].count.size());
        for (std::uint32_t number = 0; number < parts[p].count.size(); ++number)
            shares.push_back({parts[p].numbers.places()[number], p, number});
    }
    parallelSort(shares, std::less<>());

    std::uint32_t rows = 0;
    for (const auto& [place, p, number] : shares) {
        if (cell_.empty() || place != cell_.back()) {
            if (lines_.add({place.z, place.y, 0}) == line_begin_.size())
                line_begin_.push_back(static_cast<std::uint32_t>(cell_.size()));
            cell_.push_back(place);
            begin_.push_back(rows);
        }
        parts[p].next[number] = rows;
        rows += parts[p].count[number];
    }
    line_begin_.push_back(static_cast<std::uint32_t>(cell_.size()));
    begin_.push_back(rows);
}

}  // namespace betamesh
