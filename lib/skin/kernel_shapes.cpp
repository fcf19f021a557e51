#include "skin/kernel_shapes.h"

#include "base/dual.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

namespace {

float scaleAt(const std::vector<float>& scale, std::size_t point) { return scale.empty() ? 1 : scale[point]; }

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
    shapes.longest[point] = static_cast<float>(1 / along);
    shapes.width[point] = static_cast<float>(1 / (across * (1 - kLengthwiseShare) + along * kLengthwiseShare));
}

}  // namespace

void KernelShapes::gather(const PointGroup& group, Lanes (&matrix)[6]) const {
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        for (int k = 0; k < 3; ++k) {
            matrix[k][lane] = diagonal[group.row[lane]][k];
            matrix[k + 3][lane] = mixed[group.row[lane]][k];
        }
}

std::vector<float> KernelShapes::reach(const std::vector<float>& scale) const {
    std::vector<float> reach = longest;
    for (std::size_t i = 0; i < scale.size(); ++i) reach[i] *= scale[i];
    return reach;
}

KernelShapes kernelShapes(const PointGroups& points, const std::vector<Vec3>& position, const Normals& normal,
                          const std::vector<float>& scale, const GroupedElements& elements, double unit,
                          double widest) {
    KernelShapes shapes(position.size());
    std::vector<float> reach(position.size());
    parallelFor(reach.size(), 8192, [&](std::size_t i) { reach[i] = static_cast<float>(widest) * scaleAt(scale, i); });
    forElements(points, position, elements, unit, reach, normal,
                [&](const PointGroup& group, ElementSamples near, const OrientedPoints& point) {
                    Lanes inverse, scales, sums[kSidewaysSums];
                    for (std::size_t lane = 0; lane < kLanes; ++lane) {
                        const std::uint32_t row = group.row[lane];
                        inverse[lane] = 1 / (reach[row] * reach[row]);
                        scales[lane] = scaleAt(scale, row);
                    }
                    forLanes(SidewaysSums{near, inverse, scales, point, sums});
                    for (std::size_t lane = 0; lane < group.size; ++lane) {
                        const std::uint32_t row = group.row[lane];
                        setShape(sums, lane, Vec3(normal[row]), widest, scaleAt(scale, row), row, shapes);
                    }
                });
    return shapes;
}

}  // namespace betamesh
