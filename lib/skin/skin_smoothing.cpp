#include "skin/skin_smoothing.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/long_waves.h"
#include "skin/skin_fit.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kValue, kFields };
using Samples = SampleRuns<kFields>;

// Σ w A v and Σ w A over what faces the same way; v is the height over the tangent plane (kHeight) or the sample's
// value.
template <bool kHeight>
struct FacingSums {
    Samples samples;
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
        Pack sum[2] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t, c;
                setFacing(p, n, &f[kNx], inverse, t, c);
                const Pack w = t * t * c * f[kArea];
                sum[1] += w;
                if constexpr (kHeight)
                    sum[0] += w * (p[0] * n[0] + p[1] * n[1] + p[2] * n[2]);
                else
                    sum[0] += w * f[kValue];
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// At each vertex the kernel mean, over what faces the same way, of heights over its tangent plane or of values.
template <bool kHeight>
std::vector<float> facingMeans(DeformingMesh& surface, const std::vector<Vec3f>& normal,
                               const std::vector<float>& value) {
    std::vector<float> mean(surface.size());
    surface.forNeighbourhoods<kFields>(
        kBiLaplacianKernel,
        [&](std::uint32_t v, SampleFields<kFields>& f) {
            const Vec3f& n = normal[v];
            f[kArea] = surface.area(v), f[kNx] = n.x, f[kNy] = n.y, f[kNz] = n.z;
            f[kValue] = kHeight ? 0 : value[v];
        },
        [&](const PointGroup& group, Samples samples) {
            const PointGroup::Vectors n = group.gather(normal);
            Lanes inverse, sums[2];
            surface.setInverseSquares(group, kBiLaplacianKernel, inverse);
            forLanes(FacingSums<kHeight>{samples, inverse, {group.position, n.lanes}, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                mean[group.row[lane]] = sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0;
        });
    return mean;
}

// One step along the normals by the height over the tangent plane minus the mean of heights near: a bi-Laplacian.
void smoothByBiLaplacian(DeformingMesh& surface, const std::vector<Vec3f>& normal, bool is_last) {
    std::vector<float> height = facingMeans<true>(surface, normal, {});
    const std::vector<float> mean = facingMeans<false>(surface, normal, height);
    parallelFor(height.size(), 8192, [&](std::size_t v) {
        const float longest = static_cast<float>(kMaxBiLaplacianStep) * surface.scale(v);
        height[v] = std::clamp(kBiLaplacianGain * (height[v] - mean[v]), -longest, longest);
    });
    std::vector<Vec3f> step(height.size());
    parallelFor(step.size(), 8192, [&](std::size_t v) { step[v] = normal[v] * height[v]; });
    if (is_last)
        surface.moveAveraged(step);
    else
        surface.move(step);
}

// By how much displacements exceed a limit in particle spacings, as logarithms; negligible up to two thirds of it.
std::vector<float> excesses(const DeformingMesh& surface, const std::vector<Vec3>& from, double limit) {
    std::vector<float> excess(surface.size());
    parallelFor(excess.size(), 8192, [&](std::size_t v) {
        const double there = limit * surface.scale(v) * surface.spacing();
        const double s2 = (surface.position()[v] - from[v]).length2() / (there * there), s4 = s2 * s2, s8 = s4 * s4;
        excess[v] = static_cast<float>(std::log1p(s8 * s8) / 16);
    });
    return excess;
}

void shorten(DeformingMesh& surface, const std::vector<Vec3>& from, const std::vector<float>& excess) {
    std::vector<Vec3f> back(surface.size(), Vec3f(0));
    parallelFor(back.size(), 8192, [&](std::size_t v) {
        const Vec3 displacement = (surface.position()[v] - from[v]) / surface.spacing();
        if (excess[v] > 0) back[v] = Vec3f(displacement * std::expm1(-static_cast<double>(excess[v])));
    });
    surface.move(back);
}

// Shortens displacements that exceed a limit, and those of what is near alike, by a smooth maximum of the excesses: a
// vertex that stayed behind alone would be a spike.
void shortenAlike(DeformingMesh& surface, const std::vector<Vec3>& from, double limit) {
    std::vector<float> excess = excesses(surface, from, limit);
    std::vector<Vec3f> power(excess.size(), Vec3f(0));
    parallelFor(excess.size(), 8192, [&](std::size_t v) {
        const float square = (excess[v] - kLeastExcess) * (excess[v] - kLeastExcess);
        if (excess[v] > kLeastExcess) power[v].x = square * square;
    });
    power = surface.kernelMeansOfFew(kExcessKernel, power);
    parallelFor(excess.size(), 8192,
                [&](std::size_t v) { excess[v] = std::sqrt(std::sqrt(kExcessGain * power[v].x)); });
    shorten(surface, from, excess);
}

}  // namespace

void smoothSkin(DeformingMesh& surface, double widest, double farthest, int passes, bool is_coarse) {
    const std::vector<Vec3> retracted = surface.position();
    widest = std::max(widest, kNarrowestFit);
    for (int pass = 0; pass < passes; ++pass) {
        surface.relaxFolds();
        const std::vector<Vec3> before = surface.position();
        const KernelShapes kernels = fitSpheres(surface, widest);
        const std::vector<Vec3f> normal = surface.smoothNormals();
        for (int i = 1; i <= kBiLaplacianSteps; ++i) smoothByBiLaplacian(surface, normal, i == kBiLaplacianSteps);
        if (!is_coarse) returnLongWaves(surface, normal, before, kernels, widest);
        if (passes > 1) shortenAlike(surface, retracted, kGentleLimit * farthest);
        surface.measure();
        for (int i = 0; i < (is_coarse ? kCoarseFoldRelaxations : kFoldRelaxations); ++i) surface.relaxFolds();
    }
}

void limitDisplacements(DeformingMesh& surface, const std::vector<Vec3>& from, double farthest) {
    shorten(surface, from, excesses(surface, from, farthest));
    surface.measure();
}

}  // namespace betamesh
