#include "skin/surface_elements.h"

#include "base/chosen_rows.h"
#include "base/parallel.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>

namespace betamesh {

namespace {

constexpr double kGroupCell = 4;     // edge of the cells in which elements are grouped, particle spacings
constexpr std::size_t kCorners = 4;  // of a tetrahedron: the directions by which elements are divided

// Integrals over triangles, relative to an origin.
struct Moments {
    double area = 0, square = 0, along = 0, value = 0;
    Vec3 first{0}, direction{0};

    Moments() = default;
    // value_sum: of the corners
    Moments(const Vec3& a, const Vec3& b, const Vec3& c, double value_sum) : direction(cross(b - a, c - a) / 2) {
        area = direction.length();
        const Vec3 sum = a + b + c;
        first = sum * (area / 3);
        square = area / 12 * (dot(a, a) + dot(b, b) + dot(c, c) + dot(sum, sum));
        along = dot(a, direction);
        value = value_sum / 3 * area;
    }

    void add(const Moments& m, double share) {
        area += m.area * share;
        first += m.first * share;
        direction += m.direction * share;
        square += m.square * share;
        along += m.along * share;
        value += m.value * share;
    }
    SurfaceElement element(const Vec3& origin, double unit) const {
        const Vec3 middle = first / area;
        const Vec3 mean = direction / area;
        return {origin + middle * unit,
                Vec3f(mean),
                static_cast<float>(area),
                static_cast<float>(std::max(0.0, square / area - dot(middle, middle))),
                static_cast<float>(along / area - dot(middle, mean)),
                static_cast<float>(value / area),
                1};
    }
};

std::vector<SurfaceElement> elementsOf(const DeformingMesh& surface, const std::vector<float>& value) {
    const BetaMesh& mesh = surface.mesh();
    const double unit = surface.spacing(), scale = 1 / unit;
    const std::array<Vec3, kCorners> corner{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
    const std::size_t balls = mesh.ball_begin.empty() ? 0 : mesh.ball_begin.size() - 1;
    using Elements = std::vector<SurfaceElement>;
    return concatenate(
        parallelParts<Elements>(balls, kBallsPerTask, [&](std::size_t from, std::size_t to, Elements& elements) {
            std::vector<Moments> triangles;  // of one ball
            for (std::size_t b = from; b < to; ++b) {
                const std::uint32_t begin = mesh.ball_begin[b], end = mesh.ball_begin[b + 1];
                if (begin == end) continue;
                const Vec3 origin = surface.position()[mesh.triangles[begin][0]];
                const auto localOf = [&](std::uint32_t v) { return (surface.position()[v] - origin) * scale; };
                triangles.clear();
                Moments whole;
                for (std::uint32_t t = begin; t < end; ++t) {
                    const auto& [i, j, k] = mesh.triangles[t];
                    const double sum = value.empty() ? 0 : static_cast<double>(value[i]) + value[j] + value[k];
                    whole.add(triangles.emplace_back(localOf(i), localOf(j), localOf(k), sum), 1);
                }
                if (!(whole.area > 0)) continue;
                const double flatness = whole.direction.length() / whole.area;
                const double divided = 1 - smoothStep((flatness - kUndividedFlatness) / kDivisionFade).value;
                const auto add = [&](const Moments& m, double share) {
                    if (!(m.area * share > 1e-9)) return;
                    elements.push_back(m.element(origin, unit));
                    elements.back().area *= static_cast<float>(share);
                    elements.back().scale = surface.scale(mesh.triangles[begin][0]);
                };
                add(whole, 1 - divided);
                if (!(divided > 0)) continue;
                std::array<Moments, kCorners> part;
                for (const Moments& triangle : triangles) {
                    if (!(triangle.area > 0)) continue;
                    std::array<double, kCorners> share;
                    double all = 0;
                    for (std::size_t m = 0; m < kCorners; ++m) {
                        const double s = 1 + dot(triangle.direction, corner[m]) / triangle.area * 0.577;
                        const double s2 = s * s, s4 = s2 * s2;
                        all += share[m] = s4 * s4;
                    }
                    for (std::size_t m = 0; m < kCorners; ++m) part[m].add(triangle, share[m] / all);
                }
                for (const Moments& m : part) add(m, divided);
            }
        }));
}

}  // namespace

GroupedElements::GroupedElements(const DeformingMesh& surface, const std::vector<float>& value)
    : element(elementsOf(surface, value)), position(element.size()) {
    const auto setPositions = [&] {
        parallelFor(position.size(), 8192, [&](std::size_t i) { position[i] = element[i].position; });
    };
    setPositions();
    std::vector<std::uint32_t> order;
    std::vector<float> scale(surface.mesh().scale.empty() ? 0 : element.size());
    for (std::size_t i = 0; i < scale.size(); ++i) scale[i] = element[i].scale;
    groups = PointGroups(position, kGroupCell * surface.spacing(), scale, order);
    element = chosenRows(element, order);
    setPositions();
    groups.fitBoxes(position);
}

}  // namespace betamesh
