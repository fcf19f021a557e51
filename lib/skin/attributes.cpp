
#include "skin/attributes.h"

#include "base/attribute_names.h"
#include "base/cell_grid.h"
#include "base/chosen_rows.h"
#include "base/nearest_word.h"
#include "base/octaves.h"
#include "betamesh/error.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace betamesh {

namespace {

/// Why particles have no attribute of this name.
std::string reasonAgainst(const std::string& name) {
    const auto isOneOf = [&](std::initializer_list<std::string_view> names) {
        return std::ranges::find(names, name) != names.end();
    };
    if (isOneOf({"P", "position", "x", "y", "z"})) return "'" + name + "' is the position, which is written anyway";
    if (isOneOf({"v", "velocity", "vel"})) return "'" + name + "' is the velocity, which is written anyway";
    if (name == "id") return "'id' is the id of particles, which vertices do not have";
    return "the particles have no attribute '" + name + "'";
}

}  // namespace

const Attribute* attributeOf(const Particles& particles, const std::string& name) {
    std::string list;
    std::vector<std::string> known;
    for (const Attribute& a : particles.attributes) {
        if (a.name == name) return &a;
        list += (list.empty() ? "" : ", ") + a.name;
        known.push_back(a.name);
    }
    if (particles.size() == 0) return nullptr;
    throw Error(reasonAgainst(name) + ". Besides position, velocity and id the particles have " +
                (list.empty() ? "no attributes" : list) + '.' + didYouMean(name, known));
}

void requireAttributesNamed(const Particles& particles, const std::vector<std::string>& names) {
    for (const std::string& name : names) attributeOf(particles, name);
}

namespace {

std::vector<std::string> withAccelerations(std::vector<std::string> names, const Particles& particles) {
    for (const Attribute& a : particles.attributes)
        if (isAccelerationName(a.name) && a.components == 3 && !a.real.empty() &&
            std::find(names.begin(), names.end(), a.name) == names.end())
            names.push_back(a.name);
    return names;
}

double scaleAt(const std::vector<float>& scale, std::size_t row) {
    return scale.empty() ? 1 : static_cast<double>(scale[row]);
}

// Points with radii that differ by less than a factor of two, in cells of their own.
struct Octave {
    double largest;                  // radius that these may have
    std::vector<std::uint32_t> row;  // of the points, ascending
    CellGrid cells;                  // of these, as indices of `row`
};

// The octaves of points with radii, those with the largest first. edge: of cells, in the largest radii of their octave.
template <typename PositionOf>
std::vector<Octave> octavesOf(std::size_t points, double radius, const std::vector<float>& scale, double edge,
                              const PositionOf& positionOf) {
    double least_edge = 0;  // no cell has an index beyond 2^30
    for (std::size_t row = 0; !scale.empty() && row < points; ++row) {
        const Vec3 p = positionOf(row);
        for (int k = 0; k < 3; ++k) least_edge = std::max(least_edge, std::abs(p[k]) * 0x1p-30);
    }
    std::vector<std::vector<std::uint32_t>> rows = byOctave(allRows(points), scale);
    std::vector<Octave> octaves;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (rows[k].empty()) continue;
        const double largest = radius * largestOfOctave(k);
        CellGrid cells(rows[k].size(), std::max(edge * largest, least_edge),
                       [&](std::size_t i) { return positionOf(rows[k][i]); });
        octaves.push_back({largest, std::move(rows[k]), std::move(cells)});
    }
    return octaves;
}

// Appends the balls of an octave that may reach the points in a cell of another octave.
template <typename RadiusOf>
void appendNear(const Octave& points, std::uint32_t cell, const Octave& octave, const std::vector<DualVec3>& balls,
                const RadiusOf& radiusOf, std::vector<std::uint32_t>& near) {
    const Vec3 low = points.cells.lowestCorner(cell), high = low + Vec3(points.cells.edge());
    const Vec3 farthest(points.largest + octave.largest);
    octave.cells.forRowsIn(low - farthest, high + farthest, [&](std::uint32_t i) {
        const std::uint32_t ball = octave.row[i];
        const Vec3& p = balls[ball].position;
        double squared = 0;
        for (int k = 0; k < 3; ++k) {
            const double outside = std::max({0.0, low[k] - p[k], p[k] - high[k]});
            squared += outside * outside;
        }
        const double reach = points.largest + radiusOf(ball);
        if (squared < reach * reach) near.push_back(ball);
    });
}

struct WeightedRow {
    std::uint32_t row;
    double weight;
};

// Sets the values of a vertex to weighted means of those of particles; integers to those of the largest weight.
void setMeans(const std::vector<WeightedRow>& weighted, std::size_t vertex, const std::vector<const Attribute*>& from,
              std::vector<Attribute>& carried) {
    double sum = 0;
    for (const WeightedRow& w : weighted) sum += w.weight;
    const auto nearest =
        std::max_element(weighted.begin(), weighted.end(),
                         [](const WeightedRow& a, const WeightedRow& b) { return a.weight < b.weight; });
    for (std::size_t a = 0; a < carried.size(); ++a) {
        const std::size_t components = carried[a].components, first = vertex * components;
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

}  // namespace

std::vector<Attribute> carriedAttributes(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                         const std::vector<DualVec3>& balls, const LocalRadii& radii,
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

    const std::vector<Octave> around =
        octavesOf(balls.size(), radii.largest, radii.ball_scale, 2, [&](std::size_t b) { return balls[b].position; });
    const auto ballRadius = [&](std::uint32_t ball) { return radii.largest * scaleAt(radii.ball_scale, ball); };
    for (const Octave& octave :
         octavesOf(position.size(), radii.largest, radii.vertex_scale, 1, [&](std::size_t v) { return position[v]; }))
        parallelRanges(octave.cells.cells(), 16, [&](std::size_t first, std::size_t last) {
            std::vector<std::uint32_t> near;
            std::vector<WeightedRow> weighted;
            for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
                near.clear();
                for (const Octave& other : around) appendNear(octave, cell, other, balls, ballRadius, near);
                for (const std::uint32_t i : octave.cells.rowsOf(cell)) {
                    const std::uint32_t vertex = octave.row[i];
                    const double radius = radii.largest * scaleAt(radii.vertex_scale, vertex);
                    weighted.clear();
                    for (const std::uint32_t b : near) {
                        const double reach = radius + ballRadius(b);
                        const double t = 1 - (position[vertex] - balls[b].position).length2() / (reach * reach);
                        if (t > 0) weighted.push_back({rows[b], t * t});
                    }
                    if (!weighted.empty()) setMeans(weighted, vertex, from, carried);
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
        if (attribute != nullptr) some.push_back(chosenRows(*attribute, rows));
    }
    return some;
}

}  // namespace betamesh
