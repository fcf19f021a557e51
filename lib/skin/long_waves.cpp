#include "skin/long_waves.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/skin_fit.h"

#include <algorithm>
#include <cstring>

namespace betamesh {

namespace {

// Σ k value and Σ k; each point has its own kernel width.
struct ValueSums {
    ElementSamples samples;
    const Lanes& inverse_square_width;
    OrientedPoints point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[2] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kVariance]) * inverse;
                Pack c = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
                t = t > 0 ? t : zero;
                c = c > 0 ? c : zero;
                const Pack k = t * t * c * c * f[kElementArea];
                sum[0] += k * f[kElementValue];
                sum[1] += k;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Calls visit(row, mean) with the kernel mean of the elements' values over what faces the same way as each point, which
// has its own kernel width.
template <typename Visit>
void forMeans(const PointGroups& points, const std::vector<Vec3>& point, const GroupedElements& elements, double unit,
              const Normals& normal, const std::vector<float>& width, const Visit& visit) {
    const std::vector<float> inverse_square = inverseSquares(width);
    forElements(points, point, elements, unit, width, normal,
                [&](const PointGroup& group, ElementSamples near, const OrientedPoints& at) {
                    Lanes inverse, sums[2];
                    for (std::size_t lane = 0; lane < kLanes; ++lane) inverse[lane] = inverse_square[group.row[lane]];
                    forLanes(ValueSums{near, inverse, at, sums});
                    for (std::size_t lane = 0; lane < group.size; ++lane)
                        visit(group.row[lane], sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0);
                });
}

}  // namespace

void returnLongWaves(DeformingMesh& surface, const Normals& normal, const std::vector<Vec3>& before,
                     const std::vector<float>& width) {
    std::vector<float> lost(surface.size()), kernel(surface.size());
    parallelFor(kernel.size(), 8192, [&](std::size_t v) {
        const Vec3 back = before[v] - surface.position()[v];
        lost[v] = static_cast<float>(dot(back, Vec3(normal[v])) / surface.spacing());
        kernel[v] = std::min(width[v], static_cast<float>(kWaveKernel)) * surface.scale(v);
    });
    surface.constrainFading(lost);
    std::vector<std::array<float, 3>> value(surface.size());
    parallelFor(value.size(), 8192, [&](std::size_t v) { value[v] = {lost[v], width[v], surface.scale(v)}; });
    GroupedElements elements(surface, value);
    const std::size_t n = elements.element.size();
    Normals facing(n);
    std::vector<float> missing(n), total(n), element_kernel(n), mean(n);
    for (std::size_t i = 0; i < n; ++i) {
        const SurfaceElement& element = elements.element[i];
        facing[i] = element.direction.normalized();
        missing[i] = total[i] = element.value[0];
        element_kernel[i] = std::min(element.value[1], static_cast<float>(kWaveKernel));
        if (!surface.mesh().scale.empty()) element_kernel[i] *= element.value[2];
    }
    for (int i = 1; i < kWaveReturns; ++i) {
        forMeans(elements.groups, elements.position, elements, surface.spacing(), facing, element_kernel,
                 [&](std::uint32_t e, float of_missing) { mean[e] = of_missing; });
        for (std::size_t e = 0; e < n; ++e) {
            missing[e] -= mean[e] * static_cast<float>(fitShare(elements.element[e].value[1]));
            total[e] += missing[e];
            elements.element[e].value[0] = missing[e];
        }
    }
    for (std::size_t e = 0; e < n; ++e) elements.element[e].value[0] = total[e];
    std::vector<float> height(surface.size());
    forMeans(surface.groups(), surface.position(), elements, surface.spacing(), normal, kernel,
             [&](std::uint32_t v, float returned) { height[v] = returned * static_cast<float>(fitShare(width[v])); });
    std::vector<Vec3f> step(height.size());
    parallelFor(step.size(), 8192, [&](std::size_t v) { step[v] = normal[v] * height[v]; });
    surface.moveAveraged(step);
}

}  // namespace betamesh
