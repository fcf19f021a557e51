#include "skin/long_waves.h"

#include "base/parallel.h"
#include "skin/constants.h"

namespace betamesh {

namespace {

// Σ k value and Σ k; each point has its own kernel.
struct ValueSums {
    ElementSamples samples;
    const Lanes (&matrix)[6];  // of the kernels
    OrientedPoints point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], g[6];
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(matrix, first, g);
        const Pack zero{};
        Pack sum[2] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t;
                setKernelRoot(g, p, f[kVariance], t);
                Pack c = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
                c = c > 0 ? c : zero;
                const Pack k = t * t * c * c * f[kElementArea];
                sum[0] += k * f[kElementValue];
                sum[1] += k;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Calls visit(row, mean) with the kernel mean of the elements' values over what faces the same way as each point.
template <typename Visit>
void forMeans(const PointGroups& points, const std::vector<Vec3>& point, const Normals& normal,
              const KernelShapes& kernels, const GroupedElements& elements, double unit, const Visit& visit) {
    forElements(points, point, elements, unit, kernels.reach, normal,
                [&](const PointGroup& group, ElementSamples near, const OrientedPoints& at) {
                    Lanes matrix[6], sums[2];
                    kernels.gather(group, matrix);
                    forLanes(ValueSums{near, matrix, at, sums});
                    for (std::size_t lane = 0; lane < group.size; ++lane)
                        visit(group.row[lane], sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0);
                });
}

// Share of what is lost that returns: less on edges, which fits round.
float returnedShare(float width) {
    return static_cast<float>(smoothStep((width - kFitBegins) / (kWavesFull - kFitBegins)).value);
}

}  // namespace

void returnLongWaves(DeformingMesh& surface, const Normals& normal, const std::vector<Vec3>& before,
                     const KernelShapes& kernels, double widest) {
    std::vector<float> lost(surface.size());
    parallelFor(lost.size(), 8192, [&](std::size_t v) {
        const Vec3 back = before[v] - surface.position()[v];
        lost[v] = static_cast<float>(dot(back, Vec3(normal[v])) / surface.spacing());
    });
    surface.constrainFading(lost);
    GroupedElements elements(surface, lost);
    const std::size_t n = elements.element.size();
    Normals facing(n);
    std::vector<float> missing(n), total(n), mean(n);
    for (std::size_t i = 0; i < n; ++i) {
        const SurfaceElement& element = elements.element[i];
        facing[i] = element.direction.normalized();
        missing[i] = total[i] = element.value;
    }
    const double unit = surface.spacing();
    const KernelShapes of_elements = kernelShapes(elements, unit, widest);
    for (int i = 1; i < kWaveReturns; ++i) {
        forMeans(elements.groups, elements.position, facing, of_elements, elements, unit,
                 [&](std::uint32_t e, float of_missing) { mean[e] = of_missing; });
        for (std::size_t e = 0; e < n; ++e) {
            missing[e] -= mean[e] * returnedShare(of_elements.width[e]);
            total[e] += missing[e];
            elements.element[e].value = missing[e];
        }
    }
    for (std::size_t e = 0; e < n; ++e) elements.element[e].value = total[e];
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    forMeans(
        surface.groups(), surface.position(), normal, kernels, elements, unit,
        [&](std::uint32_t v, float returned) { step[v] = normal[v] * (returned * returnedShare(kernels.width[v])); });
    surface.moveAveraged(step);
}

}  // namespace betamesh
