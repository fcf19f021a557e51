#include "skin/displacement_limits.h"

#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

constexpr int kBisections = 32;  // of a displacement, to find where two triangles meet

struct Displacement {
    DualVec3 from, to;
};

// The fraction of the displacements of six vertices up to which their triangles do not cross, with its rate of change.
// None if the triangles cross already without displacement, or do not cross with all of it.
template <typename DisplacementOf>
std::optional<Dual> crossingFreeFraction(const Triangle& s, const Triangle& t, const DisplacementOf& displacementOf,
                                         double radius) {
    const auto crossAt = [&](double fraction, double time) {
        const auto positionOf = [&](std::uint32_t v) {
            const Displacement& d = displacementOf(v);
            const DualVec3 at = d.from + (d.to - d.from) * fraction;
            return at.position + at.velocity * time;
        };
        return relationOf(s, t, positionOf) == TriangleRelation::crossing;
    };
    const auto lastFree = [&](double free, double crossing, double time) {
        for (int i = 0; i < kBisections; ++i) {
            const double middle = (free + crossing) / 2;
            (crossAt(middle, time) ? crossing : free) = middle;
        }
        return free;
    };
    if (crossAt(0, 0) || !crossAt(1, 0)) return std::nullopt;
    const double fraction = lastFree(0, 1, 0);
    double speed = 0, longest = 0;
    for (const Triangle& triangle : {s, t})
        for (const std::uint32_t v : triangle) {
            const Displacement& d = displacementOf(v);
            speed = std::max({speed, d.from.velocity.length(), d.to.velocity.length()});
            longest = std::max(longest, (d.to.position - d.from.position).length());
        }
    if (speed == 0) return fraction * kContactMargin;
    const double step = kContactTimeStep * radius / speed;
    const double low = fraction - kMaxContactChange, high = fraction + kMaxContactChange;
    if (crossAt(low, step) || !crossAt(high, step)) return fraction * kContactMargin;
    const double rate = (lastFree(low, high, step) - fraction) / step, largest = kMaxContactSpeed * speed / longest;
    return Dual(fraction, std::clamp(rate, -largest, largest)) * kContactMargin;
}

}  // namespace

DisplacementLimits::DisplacementLimits(const DualPoints& from, double radius, const BetaMesh& mesh)
    : from_(from), radius_(radius), mesh_(mesh), row_(from.size(), kInvalidIndex), fading_(from.size(), nullptr) {
    for (const auto& group : mesh.fading)
        for (const FadingVertex& fading : group) fading_[fading.vertex] = &fading;
}

bool DisplacementLimits::lower(VertexLimit& limit, Dual fraction) {
    if (!(fraction.value < limit.fraction.value)) return false;
    limit.fraction = fraction;
    return true;
}

// Calls visit(u) for a vertex and its supports.
template <typename Visit>
void DisplacementLimits::forSupports(std::uint32_t v, const Visit& visit) {
    visit(v);
    if (!fading_[v]) return;
    for (const std::uint32_t u : fading_[v]->support) visit(u);
}

DisplacementLimits::VertexLimit& DisplacementLimits::limitOf(std::uint32_t v) {
    if (row_[v] == kInvalidIndex) {
        row_[v] = static_cast<std::uint32_t>(limit_.size());
        limit_.push_back({v, false, from_[v], mesh_.vertex[v]});
    }
    return limit_[row_[v]];
}

void DisplacementLimits::requestBase(std::uint32_t v) {
    VertexLimit& limit = limitOf(v);
    if (limit.has_base) return;
    limit.has_base = true;
    without_base_.push_back(v);
}

// Merges the active triangles of each small cell into one element: there may be thousands where spheres meet.
void DisplacementLimits::gatherElements(const PatchTree& tree) {
    std::vector<Element> triangle;
    double largest = 0;                // absolute coordinate
    double least = radius_, most = 0;  // radii
    tree.forActiveTriangles([&](const Triangle& t) {
        DualVec3 middle, end;
        for (const std::uint32_t v : t) {
            least = std::min(least, radiusAt(v)), most = std::max(most, radiusAt(v));
            middle = middle + from_[v] * (1.0 / 3);
            end = end + limitOf(v).to * (1.0 / 3);
        }
        const std::vector<Vec3>& from = from_.position;
        const double area = betamesh::cross(from[t[1]] - from[t[0]], from[t[2]] - from[t[0]]).length();
        triangle.push_back({middle, end - middle, area});
        for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(middle.position[k]));
    });
    const double min_edge = largest * 0x1p-30;  // of cells, whose indices have 32 bits
    const CellGrid cells(triangle.size(), std::max(kDisplacementCell * least, min_edge),
                         [&](std::size_t i) { return triangle[i].middle.position; });
    element_.clear();
    for (std::uint32_t cell = 0; cell < cells.cells(); ++cell) {
        Element sum;
        for (const std::uint32_t row : cells.rowsOf(cell)) {
            const Element& part = triangle[row];
            sum.middle = sum.middle + part.middle * part.area;
            sum.displacement = sum.displacement + part.displacement * part.area;
            sum.area += part.area;
        }
        if (sum.area > 0) element_.push_back({sum.middle / sum.area, sum.displacement / sum.area, sum.area});
    }
    element_cells_.emplace(element_.size(), std::max(kMeanDisplacementKernel * most, min_edge),
                           [&](std::size_t i) { return element_[i].middle.position; });
}

void DisplacementLimits::setMeanDisplacements() {
    parallelFor(without_base_.size(), 64, [&](std::size_t i) {
        const double width = kMeanDisplacementKernel * radiusAt(without_base_[i]), inverse_square = 1 / (width * width);
        const DualVec3 at = from_[without_base_[i]];
        DualVec3 sum;
        Dual weight = 0;
        element_cells_->forRowsIn(at.position - Vec3(width), at.position + Vec3(width), [&](std::uint32_t row) {
            const DualVec3 offset = element_[row].middle - at;
            const Dual t = 1 - dot(offset, offset) * inverse_square;
            if (t.value <= 0) return;
            const Dual w = t * t * element_[row].area;
            sum = sum + element_[row].displacement * w;
            weight = weight + w;
        });
        if (weight.value > 0) limit_[row_[without_base_[i]]].base = at + sum / weight;
    });
    without_base_.clear();
}

std::vector<std::optional<Dual>> DisplacementLimits::crossingFreeFractions(
    const std::vector<TrianglePair>& pairs) const {
    std::vector<std::optional<Dual>> fractions(pairs.size());
    parallelFor(pairs.size(), 16, [&](std::size_t i) {
        std::array<Displacement, 6> displacements;
        std::array<Triangle, 2> corners;
        for (std::uint32_t k = 0; k < 6; ++k) {
            const std::uint32_t v = mesh_.triangles[pairs[i][k / 3]][k % 3];
            displacements[k] = {limit_[row_[v]].base, mesh_.vertex[v]};
            corners[k / 3][k % 3] = v;
        }
        fractions[i] = crossingFreeFraction(
            corners[0], corners[1],
            [&](std::uint32_t v) -> const Displacement& {
                std::size_t k = 0;
                while (corners[k / 3][k % 3] != v) ++k;
                return displacements[k];
            },
            radiusAt(corners[0][0]));
    });
    return fractions;
}

void DisplacementLimits::propagate(const PatchTree& tree) {
    for (bool more = true; more;) {
        more = false;
        tree.forActiveTriangles([&](const Triangle& t) {
            for (std::size_t m = 0; m < 3; ++m) {
                const std::uint32_t u = t[m], v = t[(m + 1) % 3];
                VertexLimit &at_u = limit_[row_[u]], &at_v = limit_[row_[v]];
                if (at_u.fraction.value >= 1 && at_v.fraction.value >= 1) continue;
                const Dual distance = length(from_[u] - from_[v]) / Dual((radiusAt(u) + radiusAt(v)) / 2);
                more |= lower(at_u, at_v.fraction + distance);
                more |= lower(at_v, at_u.fraction + distance);
            }
        });
    }
}

bool DisplacementLimits::reduce(const std::vector<TrianglePair>& pairs, bool all_the_way, const PatchTree& tree) {
    gatherElements(tree);
    for (const TrianglePair& pair : pairs)
        for (const std::uint32_t t : pair)
            for (const std::uint32_t v : mesh_.triangles[t]) forSupports(v, [&](std::uint32_t u) { requestBase(u); });
    setMeanDisplacements();

    const std::vector<std::optional<Dual>> fractions =
        all_the_way ? std::vector<std::optional<Dual>>(pairs.size()) : crossingFreeFractions(pairs);
    std::vector<Dual> before(limit_.size());
    for (std::size_t i = 0; i < limit_.size(); ++i) before[i] = limit_[i].fraction;
    bool any = false;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        for (const std::uint32_t t : pairs[i])
            for (const std::uint32_t v : mesh_.triangles[t])
                forSupports(v, [&](std::uint32_t u) {
                    VertexLimit& limit = limit_[row_[u]];
                    const bool is_base_initial = limit.base.position == from_.position[u];
                    if (fractions[i] || all_the_way || is_base_initial)
                        any |= lower(limit, fractions[i] ? before[row_[u]] * *fractions[i] : Dual(0));
                    if (fractions[i] || is_base_initial) return;
                    limit.base = from_[u];
                    any = true;
                });
    propagate(tree);
    for (VertexLimit& limit : limit_)
        if (limit.fraction.value < 1) requestBase(limit.vertex);
    setMeanDisplacements();
    return any;
}

DualVec3 DisplacementLimits::limitedPosition(std::uint32_t v) const {
    if (row_[v] == kInvalidIndex) return mesh_.vertex[v];
    const VertexLimit& limit = limit_[row_[v]];
    Dual fraction = limit.fraction;
    if (fading_[v]) {
        const FadingVertex& fading = *fading_[v];
        Dual of_supports = 0;
        for (std::size_t k = 0; k < 4; ++k)
            of_supports = of_supports + fractionOf(fading.support[k]) * fading.support_weight[k];
        fraction = fraction * fading.fade + of_supports * (1 - fading.fade);
    }
    if (fraction.value >= 1) return limit.to;
    const DualVec3 position = limit.base + (limit.to - limit.base) * fraction;
    return {roundedToFloats(position.position), position.velocity};
}

}  // namespace betamesh
