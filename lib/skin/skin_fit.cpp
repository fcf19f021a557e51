#include "skin/skin_fit.h"

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/surface_elements.h"

#include <cmath>

namespace betamesh {

namespace {

// Σk, Σk y, Σk d, Σk y·d, Σk |y|² of a sphere fit; each vertex has its own kernel.
struct FitSums {
    ElementSamples samples;
    const Lanes (&matrix)[6];  // of the kernels
    OrientedPoints point;
    Lanes (&sums)[9];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], g[6];
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(matrix, first, g);
        const Pack zero{};
        Pack sum[9] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                const Pack square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kVariance];
                Pack t;
                setKernelRoot(g, p, f[kVariance], t);
                Pack c = f[kDx] * n[0] + f[kDy] * n[1] + f[kDz] * n[2];
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

// Share of a step that a fit gets: 0 with narrow kernels, 1 with wide ones.
double fitShare(float width) { return smoothStep((width - kFitBegins) / (kFitFull - kFitBegins)).value; }

}  // namespace

KernelShapes fitSpheres(DeformingMesh& surface, double widest) {
    const Normals normal = surface.smoothNormals();
    const GroupedElements elements(surface);
    KernelShapes shapes = kernelShapes(surface, normal, elements, kernelShapes(elements, surface.spacing(), widest));
    surface.constrainFading(shapes.diagonal);
    surface.constrainFading(shapes.mixed);
    surface.constrainFading(shapes.reach);
    surface.constrainFading(shapes.width);
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    const auto visit = [&](const PointGroup& group, ElementSamples near, const OrientedPoints& point) {
        Lanes matrix[6], sums[9];
        shapes.gather(group, matrix);
        forLanes(FitSums{near, matrix, point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const std::uint32_t v = group.row[lane];
            const double unit = surface.scale(v);
            const Vec3 onto = stepOntoSphere(sums, lane, unit) * fitShare(shapes.width[v]);
            step[v] = Vec3f(limitedTo(onto, kMaxFitStep * unit));
        }
    };
    forElements(surface.groups(), surface.position(), elements, surface.spacing(), shapes.reach, normal, visit);
    std::vector<float> own(step.size());
    parallelFor(own.size(), 8192, [&](std::size_t v) {
        const double share = (shapes.width[v] - kOwnStepBegins) / (kOwnStepFull - kOwnStepBegins);
        own[v] = static_cast<float>(smoothStep(share).value);
    });
    surface.moveAveraged(step, own);
    surface.measure();
    return shapes;
}

}  // namespace betamesh
