#include "skin/kernel_shapes.h"

#include "base/dual.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

// Sums of w = A u / (d² + variance)², fading out at the end of the reach, u from 0 to 1 where an element faces
// sideways, neither the same way as the point nor the opposite way. A wall across the surface at distance D gives π / 2
// D². kOpposite is the same for elements that face the opposite way. The others are sums over the directions n of
// sideways elements: Σ w |n|² in the tangent plane, and Σ w nnᵀ of those that face away from the point.
enum SidewaysSum { kSideways, kOpposite, kAllDirections, kConvex, kSidewaysSums = kConvex + 6 };
struct SidewaysSums {
    ElementSamples samples;
    const Lanes &inverse_square_reach, &scale;
    OrientedPoints point;
    Lanes (&sums)[kSidewaysSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse, unit;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_reach, first, inverse);
        getLanes<kWidth>(scale, first, unit);
        const Pack zero{}, one = zero + 1.0F, soft = unit * unit * kSidewaysSoftening,
                           inverse_fade = one / (unit * kConvexFade);
        Pack sum[kSidewaysSums] = {};
        const auto clamp = [&](Pack & share) __attribute__((always_inline)) {
            share = share < one ? share : one;
            share = share > 0 ? share : zero;
        };
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                const Pack square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kVariance] + soft;
                const Pack t = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
                Pack u = (kSidewaysMax + kSidewaysFade - t) / kSidewaysFade,
                     v = (t - kSidewaysMin + kSidewaysFade) / kSidewaysFade,
                     opposite = (kSidewaysMin - t) / kSidewaysFade;
                u = u < v ? u : v;
                clamp(u);
                clamp(opposite);
                Pack within = one - square * inverse;
                within = within > 0 ? within : zero;
                const Pack w = f[kElementArea] * within * within / (square * square), sideways = w * u;
                sum[kSideways] += sideways;
                sum[kOpposite] += w * opposite;
                sum[kAllDirections] += sideways * (f[kDx] * f[kDx] + f[kDy] * f[kDy] + f[kDz] * f[kDz] - t * t);
                Pack convex = (p[0] * f[kDx] + p[1] * f[kDy] + p[2] * f[kDz]) * inverse_fade + 0.5F;
                clamp(convex);
                convex *= sideways;
                const Pack wx = convex * f[kDx], wy = convex * f[kDy];
                sum[kConvex] += wx * f[kDx];
                sum[kConvex + 1] += wy * f[kDy];
                sum[kConvex + 2] += convex * f[kDz] * f[kDz];
                sum[kConvex + 3] += wy * f[kDz];
                sum[kConvex + 4] += wx * f[kDz];
                sum[kConvex + 5] += wx * f[kDy];
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

using SymmetricMatrix = std::array<double, 6>;  // xx yy zz yz zx xy
constexpr std::array<std::array<int, 2>, 6> kAxes{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};

// Which share of what faces sideways turns away from the point, and in which directions of the tangent plane: a matrix
// with a trace of at most 1.
SymmetricMatrix convexShare(const Lanes (&sums)[kSidewaysSums], std::size_t lane, const Vec3& normal) {
    const auto at = [&](int sum) { return static_cast<double>(sums[sum][lane]); };
    if (!(at(kAllDirections) > 0)) return {};
    const Vec3 across(dot(Vec3(at(kConvex), at(kConvex + 5), at(kConvex + 4)), normal),
                      dot(Vec3(at(kConvex + 5), at(kConvex + 1), at(kConvex + 3)), normal),
                      dot(Vec3(at(kConvex + 4), at(kConvex + 3), at(kConvex + 2)), normal));
    SymmetricMatrix share;
    for (std::size_t k = 0; k < share.size(); ++k) {
        const auto [i, j] = kAxes[k];
        share[k] = at(kConvex + static_cast<int>(k)) - normal[i] * across[j] - normal[j] * across[i] +
                   dot(across, normal) * normal[i] * normal[j];
    }
    const double trace = std::max(at(kAllDirections), share[0] + share[1] + share[2]);
    for (double& element : share) element /= trace;
    return share;
}

void setShape(const Lanes (&sums)[kSidewaysSums], std::size_t lane, const Vec3& normal, double widest, double scale,
              std::uint32_t point, KernelShapes& shapes) {
    const double factor = kWallFactor * scale * scale, flat = 1 / (widest * widest);
    const double sideways = factor * static_cast<double>(sums[kSideways][lane]);
    const double limit = 1 / (kEdgeFit * kEdgeFit) + kThinFactor * factor * static_cast<double>(sums[kOpposite][lane]);
    const double narrow = std::clamp(sideways * limit / (sideways + limit), 0.0,
                                     std::max(0.0, 1 / (kNarrowestFit * kNarrowestFit) - flat));
    const SymmetricMatrix convex = convexShare(sums, lane, normal);
    const double trace = convex[0] + convex[1] + convex[2];
    // G in square spacings at the point: along the normal, and where the surface turns towards the point, it is the
    // same in all directions.
    double squares = 0;
    for (std::size_t k = 0; k < kAxes.size(); ++k) {
        const auto [i, j] = kAxes[k];
        const double identity = i == j ? 1 : 0;
        const double g =
            flat * identity + narrow * (convex[k] + trace * normal[i] * normal[j] + (1 - trace) * identity);
        (k < 3 ? shapes.diagonal : shapes.mixed)[point][static_cast<int>(k) % 3] =
            static_cast<float>(g / (scale * scale));
        squares += convex[k] * convex[k] * (i == j ? 1 : 2);
    }
    const double difference = std::sqrt(std::max(0.0, squares / 2 - trace * trace / 4));  // of eigenvalues, halved
    const double across = std::sqrt(flat + narrow * (1 - trace / 2 + difference)),        // inverse widths
        along = std::sqrt(flat + narrow * (1 - trace / 2 - difference));
    shapes.reach[point] = static_cast<float>(scale / along);
    shapes.width[point] = static_cast<float>(1 / (across * (1 - kLengthwiseShare) + along * kLengthwiseShare));
}

// Σ w value and Σ w over elements that face the same way: w = area · (1 - d²/width²)²₊ · (direction · own normal)₊.
constexpr std::size_t kShapeValues = 8;  // G, and the inverse squares of reach and width
constexpr std::size_t kShape = kElementArea + 1, kShapeFields = kShape + kShapeValues;  // fields of an element
struct ShapeSums {
    SampleRuns<kShapeFields> samples;
    const Lanes& inverse_square_width;
    OrientedPoints point;
    Lanes (&sums)[kShapeValues + 1];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        Pack sum[kShapeValues + 1] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t, c;
                setFacing(p, n, &f[kDx], inverse, t, c);
                const Pack w = t * t * c * f[kElementArea];
                for (std::size_t k = 0; k < kShapeValues; ++k) sum[k] += w * f[kShape + k];
                sum[kShapeValues] += w;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

}  // namespace

void KernelShapes::gather(const PointGroup& group, Lanes (&matrix)[6]) const {
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        for (int k = 0; k < 3; ++k) {
            matrix[k][lane] = diagonal[group.row[lane]][k];
            matrix[k + 3][lane] = mixed[group.row[lane]][k];
        }
}

KernelShapes kernelShapes(const GroupedElements& elements, double unit, double widest) {
    const std::size_t n = elements.element.size();
    KernelShapes shapes(n);
    Normals normal(n);
    std::vector<float> reach(n);
    parallelFor(n, 8192, [&](std::size_t i) {
        normal[i] = elements.element[i].direction.normalized();
        reach[i] = static_cast<float>(widest) * elements.element[i].scale;
    });
    forElements(elements.groups, elements.position, elements, unit, reach, normal,
                [&](const PointGroup& group, ElementSamples near, const OrientedPoints& point) {
                    Lanes inverse, scale, sums[kSidewaysSums];
                    for (std::size_t lane = 0; lane < kLanes; ++lane) {
                        const std::uint32_t row = group.row[lane];
                        inverse[lane] = 1 / (reach[row] * reach[row]);
                        scale[lane] = elements.element[row].scale;
                    }
                    forLanes(SidewaysSums{near, inverse, scale, point, sums});
                    for (std::size_t lane = 0; lane < group.size; ++lane) {
                        const std::uint32_t row = group.row[lane];
                        setShape(sums, lane, Vec3(normal[row]), widest, static_cast<double>(scale[lane]), row, shapes);
                    }
                });
    return shapes;
}

KernelShapes kernelShapes(const DeformingMesh& surface, const Normals& normal, const GroupedElements& elements,
                          const KernelShapes& of_elements) {
    const SampleTable<kShapeFields> table(
        elements.groups, elements.position, surface.spacing(), [&](std::uint32_t i, SampleFields<kShapeFields>& f) {
            const SurfaceElement& e = elements.element[i];
            f[kDx] = e.direction.x, f[kDy] = e.direction.y, f[kDz] = e.direction.z, f[kElementArea] = e.area;
            for (std::size_t k = 0; k < 3; ++k) {
                f[kShape + k] = of_elements.diagonal[i][static_cast<int>(k)];
                f[kShape + 3 + k] = of_elements.mixed[i][static_cast<int>(k)];
            }
            f[kShape + 6] = 1 / (of_elements.reach[i] * of_elements.reach[i]);
            f[kShape + 7] = 1 / (of_elements.width[i] * of_elements.width[i]);
        });
    KernelShapes shapes(surface.size());
    forGroups(
        surface.groups(), surface.position(), table, kMaxElements,
        [&](std::size_t group) { return surface.reach(kShapeKernel, group); },
        [&](const PointGroup& group, SampleRuns<kShapeFields> samples) {
            const PointGroup::Vectors n = group.gather(normal);
            Lanes inverse, sums[kShapeValues + 1];
            surface.setInverseSquares(group, kShapeKernel, inverse);
            forLanes(ShapeSums{samples, inverse, {group.position, n.lanes}, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const std::uint32_t v = group.row[lane];
                const float weight = sums[kShapeValues][lane];
                if (!(weight > 0)) continue;
                for (int k = 0; k < 3; ++k) {
                    shapes.diagonal[v][k] = sums[k][lane] / weight;
                    shapes.mixed[v][k] = sums[3 + k][lane] / weight;
                }
                shapes.reach[v] = std::sqrt(weight / sums[6][lane]);
                shapes.width[v] = std::sqrt(weight / sums[7][lane]);
            }
        });
    return shapes;
}

}  // namespace betamesh
