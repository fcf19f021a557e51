
#include "skin/attributes.h"

#include "base/attribute_names.h"
#include "base/cell_grid.h"
#include "betamesh/error.h"

#include <algorithm>

namespace betamesh {

const Attribute* attributeOf(const Particles& particles, const std::string& name) {
    std::string known;
    for (const Attribute& a : particles.attributes) {
        if (a.name == name) return &a;
        known += (known.empty() ? "" : ", ") + a.name;
    }
    if (particles.size() == 0) return nullptr;
    throw Error("the particles have no attribute '" + name +
                "'. Available attributes: " + (known.empty() ? "none" : known));
}

namespace {

std::vector<std::string> withAccelerations(std::vector<std::string> names, const Particles& particles) {
    for (const Attribute& a : particles.attributes)
        if (isAccelerationName(a.name) && a.components == 3 && !a.real.empty() &&
            std::find(names.begin(), names.end(), a.name) == names.end())
            names.push_back(a.name);
    return names;
}

}  // namespace

std::vector<Attribute> carriedAttributes(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                         const std::vector<DualVec3>& balls, double radius,
                                         const std::vector<std::string>& names, const std::vector<Vec3>& position) {
    std::vector<const Attribute*> from;
    std::vector<Attribute> carried;
    for (const std::string& name : withAccelerations(names, particles)) {
        const Attribute* attribute = attributeOf(particles, name);
        if (attribute == nullptr) continue;
        from.push_back(attribute);
        const std::size_t numbers = position.size() * from.back()->components;
        carried.push_back(
            {name, from.back()->components, {}, {}, from.back()->integer_type, from.back()->hasIntegers()});
        if (from.back()->integer.empty())
            carried.back().real.assign(numbers, 0);
        else
            carried.back().integer.assign(numbers, 0);
    }
    if (carried.empty() || position.empty()) return carried;

    const double reach = 2 * radius;
    const CellGrid far(balls.size(), reach, [&](std::size_t b) { return balls[b].position; });
    const CellGrid near(position.size(), reach / 2, [&](std::size_t v) { return position[v]; });
    forCellsAndNeighbours(
        reach, near, far, [&](std::uint32_t b) { return balls[b].position; },
        [&](std::uint32_t cell, std::span<const std::uint32_t> around) {
            struct WeightedRow {
                std::uint32_t row;
                double weight;
            };
            std::vector<WeightedRow> weighted;
            for (const std::uint32_t row : near.rowsOf(cell)) {
                weighted.clear();
                double sum = 0;
                for (const std::uint32_t b : around) {
                    const double t = 1 - (position[row] - balls[b].position).length2() / (reach * reach);
                    if (!(t > 0)) continue;
                    weighted.push_back({rows[b], t * t});
                    sum += t * t;
                }
                if (weighted.empty()) continue;
                const auto nearest =
                    std::max_element(weighted.begin(), weighted.end(),
                                     [](const WeightedRow& a, const WeightedRow& b) { return a.weight < b.weight; });
                for (std::size_t a = 0; a < carried.size(); ++a) {
                    const std::size_t components = carried[a].components, first = row * components;
                    for (std::size_t c = 0; c < components; ++c) {
                        if (!from[a]->integer.empty()) {
                            carried[a].integer[first + c] = from[a]->integer[nearest->row * components + c];
                            continue;
                        }
                        double mean = 0;
                        for (const WeightedRow& w : weighted)
                            mean += w.weight / sum * static_cast<double>(from[a]->real[w.row * components + c]);
                        carried[a].real[first + c] = static_cast<float>(mean);
                    }
                }
            }
        });
    return carried;
}

std::vector<Attribute> attributesOf(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                    const std::vector<std::string>& names) {
    std::vector<Attribute> some;
    for (const std::string& name : withAccelerations(names, particles)) {
        const Attribute* attribute = attributeOf(particles, name);
        if (attribute == nullptr) continue;
        const std::size_t components = attribute->components;
        Attribute& own = some.emplace_back(Attribute{name, attribute->components, {}, {}, attribute->integer_type});
        for (const std::size_t row : rows)
            for (std::size_t i = row * components; i < (row + 1) * components; ++i) {
                if (!attribute->real.empty()) own.real.push_back(attribute->real[i]);
                if (!attribute->integer.empty()) own.integer.push_back(attribute->integer[i]);
            }
    }
    return some;
}

}  // namespace betamesh
