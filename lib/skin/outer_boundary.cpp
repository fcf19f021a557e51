
#include "skin/outer_boundary.h"

#include "base/parallel.h"
#include "betamesh/skin_params.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"
#include "skin/exposure_candidates.h"
#include "skin/face_points.h"
#include "skin/near_surface.h"
#include "skin/velocity.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace betamesh {

namespace {

// Snapped particles as ordinary particles, in the same order.
Particles unsnapped(const Particles& particles, const SnappedParticles& snapped) {
    Particles all;
    all.position.resize(snapped.size());
    all.velocity.resize(particles.velocity.empty() ? 0 : snapped.size());
    parallelFor(snapped.size(), 8192, [&](std::size_t i) {
        all.position[i] = Vec3f(toDouble(snapped.position[i]) * snapped.quantum);
        if (!all.velocity.empty()) all.velocity[i] = particles.velocity[snapped.row[i]];
    });
    return all;
}

// Particles that may be exposed at the larger radius: those not certainly covered, and exposed at the smaller radius.
// If the coarser grid of the larger radius has merged particles, rows no longer correspond and only the first test
// applies.
std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& larger, std::size_t particles,
                                              const BallBoundary& boundary) {
    std::vector<std::uint32_t> candidates = exposureCandidates(larger);
    if (larger.size() != particles) return candidates;
    std::vector<std::uint8_t> is_exposed(particles, 0);
    for (const std::uint32_t row : boundary.snapped_row) is_exposed[row] = 1;
    std::erase_if(candidates, [&](std::uint32_t i) { return !is_exposed[larger.row[i]]; });
    return candidates;
}

}  // namespace

OuterSamples outerSamples(const Particles& particles, const SnappedParticles& snapped, const BallBoundary& boundary,
                          double radius, double spacing) {
    const Particles all = unsnapped(particles, snapped);
    SkinParams params;
    params.radius = radius;
    NearSurfaceFinder finder(params);
    finder.add(all.position);
    const SnappedParticles larger = snapParticles(all, radius, finder.find());
    Icosphere directions = icosphereOf(kOuterFaceAngle);
    const auto direction_count = static_cast<double>(directions.position.size());
    const BallBoundary outer =
        ballBoundary(larger, exposureCandidates(larger, snapped.size(), boundary), directions.position);
    const std::vector<DualVec3> balls = ballCentres(outer, all);
    ArcSubdivision subdivision;
    subdivision.max_angle = kOuterArcAngle;
    subdivision.appearance = Appearance::gradual;
    ArcNetwork network = arcPoints(outer, balls, boundaryVertices(all, larger, outer, balls), subdivision);
    const FacePoints inside = facePoints(larger, outer, balls, std::move(directions));

    OuterSamples samples;
    samples.point = std::move(network.point);
    for (const FadingVertex& fading : network.fading) samples.point[fading.vertex] = fading.whole;
    const std::size_t on_arcs = samples.point.size();
    samples.weight.assign(on_arcs, 0);
    samples.fading.assign(on_arcs, 0);
    const auto addSegment = [&](std::uint32_t from, std::uint32_t to) {
        const double length = (samples.point[from].position - samples.point[to].position).length() / spacing;
        for (const std::uint32_t end : {from, to}) samples.weight[end] += static_cast<float>(length / 2);
    };
    for (std::size_t a = 0; a < network.arc_start.size(); ++a) {
        std::uint32_t last = network.arc_start[a] / 3;
        for (std::uint32_t p = network.arc_begin[a]; p < network.arc_begin[a + 1]; ++p)
            addSegment(std::exchange(last, p), p);
        addSegment(last, outer.twin[network.arc_start[a]] / 3);
    }
    for (std::size_t k = 0; k + 1 < network.circle_begin.size(); ++k) {
        std::uint32_t last = network.circle_begin[k + 1] - 1;
        for (std::uint32_t p = network.circle_begin[k]; p < network.circle_begin[k + 1]; ++p)
            addSegment(std::exchange(last, p), p);
    }
    for (const FadingVertex& fading : network.fading) {  // what they lack of their weight belongs to their neighbours
        const auto rest = static_cast<float>(1 - fading.share.value), moved = samples.weight[fading.vertex] * rest;
        samples.fading[fading.vertex] = rest;
        samples.weight[fading.vertex] -= moved;
        for (const std::size_t k : {0U, 1U}) samples.weight[fading.from[k]] += moved / 2;
    }
    samples.exposure.assign(on_arcs, 0);

    const double face_area = 4 * std::numbers::pi * radius * radius / direction_count / (spacing * spacing);
    for (std::size_t b = 0; b < balls.size(); ++b) {
        double exposed = 0;
        for (std::uint32_t p = inside.begin[b]; p < inside.begin[b + 1]; ++p) {
            const double fade = smoothStep(inside.rim_distance[p] / kOuterFadeWidth).value;
            if (inside.contactOf(p) || !(fade > 0)) continue;
            samples.point.push_back(balls[b] + inside.outwards(p) * radius);
            samples.weight.push_back(static_cast<float>(face_area * fade));
            samples.fading.push_back(static_cast<float>(1 - fade));
            exposed += fade;
        }
        samples.exposure.resize(samples.point.size(), static_cast<float>(exposed / direction_count));
    }
    return samples;
}

}  // namespace betamesh
