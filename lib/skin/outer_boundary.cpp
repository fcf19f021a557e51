#include "skin/outer_boundary.h"
#include "skin/tune.h"

#include "core/parallel.h"
#include "core/skin_params.h"
#include "exact/near_surface.h"
#include "skin/arc_points.h"
#include "skin/ball_boundary.h"
#include "skin/face_points.h"
#include "skin/survivors.h"
#include "skin/velocity.h"

#include <numbers>
#include <utility>

namespace betamesh {

namespace {

const double kArcSegment = tune("oarc", 0.3);     // radians of a great circle between samples of an arc
const double kFaceSpacing = tune("oface", 0.4);    // radians between samples inside a face
const double kFadesWithin = tune("ofade", 0.15);   // clearance up to which samples inside faces fade out towards the rim

}  // namespace

OuterSamples outerSamples(const std::vector<Moving>& balls, double radius, double unit) {
    const auto n = static_cast<std::uint32_t>(balls.size());
    Particles particles;
    particles.position.resize(n);
    particles.velocity.resize(n);
    parallelFor(n, 4096, [&](std::size_t b) {
        particles.position[b] = Vec3f(balls[b].position);
        particles.velocity[b] = Vec3f(balls[b].velocity);
    });
    SkinParams params;
    params.radius = radius;
    NearSurfaceFinder finder(params);
    finder.add(particles.position);
    const SnappedParticles snapped = snapParticles(particles, radius, finder.find());
    Icosphere directions = icosphereOf(kFaceSpacing);
    const BallBoundary boundary = ballBoundary(snapped, survivors(snapped), directions.position);
    const std::vector<Moving> outer = movingBalls(boundary, particles);
    const std::vector<Vec3> still(outer.size(), Vec3(0));
    ArcSubdivision subdivision;
    subdivision.max_angle = kArcSegment;
    subdivision.appearance = Appearance::gradual;
    ArcNetwork network = arcPoints(boundary, outer, still, movingVertices(particles, snapped, boundary, outer), subdivision);
    const double face_area =
        4 * std::numbers::pi * radius * radius / static_cast<double>(directions.position.size()) / (unit * unit);
    const FacePoints inside = facePoints(snapped, boundary, outer, still, std::move(directions));

    OuterSamples samples;
    samples.point = std::move(network.point);
    samples.weight.assign(samples.point.size(), 0);
    samples.lone.assign(samples.point.size(), 0);
    samples.fading.assign(samples.point.size(), 0);
    for (const RisingVertex& rising : network.rising) samples.point[rising.vertex] = rising.whole;
    const auto addSegment = [&](std::uint32_t from, std::uint32_t to) {
        const double length = (samples.point[from].position - samples.point[to].position).length() / unit;
        samples.weight[from] += static_cast<float>(length / 2);
        samples.weight[to] += static_cast<float>(length / 2);
    };
    for (std::size_t a = 0; a < network.arc_start.size(); ++a) {
        std::uint32_t last = network.arc_start[a] / 3;
        for (std::uint32_t p = network.arc_begin[a]; p < network.arc_begin[a + 1]; ++p)
            addSegment(std::exchange(last, p), p);
        addSegment(last, boundary.twin[network.arc_start[a]] / 3);
    }
    for (std::size_t k = 0; k + 1 < network.circle_begin.size(); ++k) {
        std::uint32_t last = network.circle_begin[k + 1] - 1;
        for (std::uint32_t p = network.circle_begin[k]; p < network.circle_begin[k + 1]; ++p)
            addSegment(std::exchange(last, p), p);
    }
    // Samples that appear on an arc take their share from those beside them by degrees.
    for (const RisingVertex& rising : network.rising) {
        const auto rest = static_cast<float>(1 - rising.share.value), weight = samples.weight[rising.vertex] * rest;
        samples.fading[rising.vertex] = rest;
        samples.weight[rising.vertex] -= weight;
        for (std::size_t k = 0; k < 2; ++k) samples.weight[rising.from[k]] += weight / 2;
    }
    const double directions_count = static_cast<double>(inside.directions.position.size());
    for (std::size_t b = 0; b < outer.size(); ++b) {
        const std::size_t first = samples.point.size();
        double exposed = 0;
        for (std::uint32_t p = inside.begin[b]; p < inside.begin[b + 1]; ++p) {
            if (inside.contactOf(p)) continue;
            const Rate share = smoothStep(inside.clearance[p] / kFadesWithin);
            if (share.value <= 0) continue;
            samples.point.push_back(outer[b] + inside.outwards(p, still[b]) * radius);
            samples.weight.push_back(static_cast<float>(face_area * share.value));
            samples.fading.push_back(static_cast<float>(1 - share.value));
            exposed += share.value;
        }
        samples.lone.resize(samples.point.size(), 0);
        std::fill(samples.lone.begin() + static_cast<std::ptrdiff_t>(first), samples.lone.end(),
                  static_cast<float>(exposed / directions_count));
    }
    return samples;
}

}  // namespace betamesh
