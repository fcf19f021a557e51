#include "skin/skin_fit.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/surface_elements.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace betamesh {

namespace {

// Σ A u / (d² + variance)², fading out at the end of the reach, u from 0 to 1 where an element faces sideways, neither
// the same way as the vertex nor the opposite way. A wall across the surface at distance D gives π / 2 D². The second
// sum is the same for elements that face the opposite way.
struct SidewaysSums {
    ElementSamples samples;
    const Lanes &inverse_square_reach, &softening;
    OrientedPoints point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse, soft;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_reach, first, inverse);
        getLanes<kWidth>(softening, first, soft);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[2] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                const Pack square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kVariance] + soft;
                const Pack t = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
                Pack u = (kSidewaysMax + kSidewaysFade - t) / kSidewaysFade,
                     v = (t - kSidewaysMin + kSidewaysFade) / kSidewaysFade;
                u = u < v ? u : v;
                u = u < one ? u : one;
                u = u > 0 ? u : zero;
                Pack within = one - square * inverse;
                within = within > 0 ? within : zero;
                Pack opposite = (kSidewaysMin - t) / kSidewaysFade;
                opposite = opposite < one ? opposite : one;
                opposite = opposite > 0 ? opposite : zero;
                const Pack w = f[kElementArea] * within * within / (square * square);
                sum[0] += w * u;
                sum[1] += w * opposite;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Σk, Σk y, Σk d, Σk y·d, Σk |y|² of a sphere fit; each vertex has its own kernel width.
struct FitSums {
    ElementSamples samples;
    const Lanes& inverse_square_width;
    OrientedPoints point;
    Lanes (&sums)[9];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[9] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                const Pack square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kVariance];
                Pack t = one - square * inverse;
                Pack c = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
                t = t > 0 ? t : zero;
                c = c > 0 ? c : zero;
                const Pack k = t * t * c * c * f[kElementArea];
                sum[0] += k;
                sum[1] += k * p[0];
                sum[2] += k * p[1];
                sum[3] += k * p[2];
                sum[4] += k * f[kDx];
                sum[5] += k * f[kDy];
                sum[6] += k * f[kDz];
                sum[7] += k * (p[0] * f[kDx] + p[1] * f[kDy] + p[2] * f[kDz] + f[kConvexity]);
                sum[8] += k * square;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// The step from a point onto the sphere fitted to the sums. scale: particle spacing there, in spacings of the frame.
Vec3 stepOntoSphere(const Lanes (&sums)[9], std::size_t lane, double scale) {
    const double weight = sums[0][lane];
    if (!(weight > 0)) return Vec3(0);
    const Vec3 a = Vec3(sums[1][lane], sums[2][lane], sums[3][lane]) / weight,
               b = Vec3(sums[4][lane], sums[5][lane], sums[6][lane]) / weight;
    const double c = sums[7][lane] / weight, e = sums[8][lane] / weight;
    const double quadratic = (c - dot(a, b)) / (2 * (e - dot(a, a) + kSkinFitVariance * (scale * scale)));
    const Vec3 linear = b - a * (2 * quadratic);
    const double constant = -(dot(linear, a) + quadratic * e), slope = dot(linear, linear);
    if (!(slope > 1e-9)) return Vec3(0);
    const double root = std::sqrt(std::max(0.0, slope * slope - 4 * quadratic * constant * slope));
    return linear * (-2 * constant / (slope + root));
}

// The kernel width at each vertex, in particle spacings there: limited by where the surface turns sideways, less so
// where the liquid is thick.
std::vector<float> kernelWidths(DeformingMesh& surface, const GroupedElements& elements, const Normals& wide,
                                double widest) {
    std::vector<float> width(surface.size());
    const auto visit = [&](const PointGroup& group, ElementSamples near, const OrientedPoints& point) {
        Lanes inverse, softening, sums[2];
        surface.setInverseSquares(group, widest, inverse);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const float scale = surface.scale(group.row[lane]);
            softening[lane] = kSidewaysSoftening * (scale * scale);
        }
        forLanes(SidewaysSums{near, inverse, softening, point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const double scale = surface.scale(group.row[lane]), factor = kWallFactor * (scale * scale);
            const double sideways = factor * static_cast<double>(sums[0][lane]);
            const double limit = 1 / (kEdgeFit * kEdgeFit) + kThinFactor * factor * static_cast<double>(sums[1][lane]);
            const double inverse_square = 1 / (widest * widest) + sideways * limit / (sideways + limit);
            width[group.row[lane]] = static_cast<float>(std::max(kNarrowestFit, 1 / std::sqrt(inverse_square)));
        }
    };
    std::vector<float> reach(surface.size());
    parallelFor(reach.size(), 8192, [&](std::size_t v) { reach[v] = static_cast<float>(widest) * surface.scale(v); });
    forElements(surface.groups(), surface.position(), elements, surface.spacing(), reach, wide, visit);
    surface.constrainFading(width);
    return width;
}

}  // namespace

double fitShare(float width) { return smoothStep((width - kFitBegins) / (kFitFull - kFitBegins)).value; }

std::vector<float> fitSpheres(DeformingMesh& surface, double widest) {
    const Normals normal = surface.smoothNormals();
    const Normals wide = surface.kernelNormals(kSidewaysKernel, normal).normal;
    const GroupedElements elements(surface);
    std::vector<float> width = kernelWidths(surface, elements, wide, widest);
    std::vector<float> absolute(width.size());
    parallelFor(width.size(), 8192, [&](std::size_t v) { absolute[v] = width[v] * surface.scale(v); });
    const std::vector<float> inverse_square = inverseSquares(absolute);
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    const auto visit = [&](const PointGroup& group, ElementSamples near, const OrientedPoints& point) {
        Lanes inverse, sums[9];
        for (std::size_t lane = 0; lane < kLanes; ++lane) inverse[lane] = inverse_square[group.row[lane]];
        forLanes(FitSums{near, inverse, point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const std::uint32_t v = group.row[lane];
            const double scale = surface.scale(v), longest = kMaxFitStep * scale;
            Vec3 onto = stepOntoSphere(sums, lane, scale) * fitShare(width[v]);
            if (const double length = onto.length(); length > longest) onto *= longest / length;
            step[v] = Vec3f(onto);
        }
    };
    forElements(surface.groups(), surface.position(), elements, surface.spacing(), absolute, normal, visit);
    std::vector<float> own(width.size());
    parallelFor(own.size(), 8192, [&](std::size_t v) {
        own[v] = static_cast<float>(smoothStep((width[v] - kOwnStepBegins) / (kOwnStepFull - kOwnStepBegins)).value);
    });
    surface.moveAveraged(step, own);
    surface.measure();
    return width;
}

}  // namespace betamesh
