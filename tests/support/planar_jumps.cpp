#include "support/planar_jumps.h"

#include "base/random.h"
#include "betamesh/skin.h"
#include "exact/snapped_particles.h"
#include "planar/disc_boundary.h"
#include "support/oracles.h"
#include "support/planar_clouds.h"

#include <algorithm>
#include <functional>
#include <map>
#include <stdexcept>

namespace betamesh {

namespace {

SegmentSet combinatoricsOf(const Particles& particles) {
    const DiscBoundary boundary = discBoundary(snapParticles(particles, kDiscRadius));
    SegmentSet segments;
    for (const auto& [from, to] : boundary.segment) segments.insert({boundary.row[from], boundary.row[to]});
    return segments;
}

std::string kindOf(const SegmentSet& before, const SegmentSet& after) {
    std::vector<std::array<std::uint32_t, 2>> gone, come;
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(gone));
    std::set_difference(after.begin(), after.end(), before.begin(), before.end(), std::back_inserter(come));
    const auto [less, more] = std::minmax({gone.size(), come.size()});
    if (less == 1 && more == 2) return "birth";
    if (less == 0 && more == 2) return "contact";
    if (less == 0 && more == 3) return "hole";
    return "several";
}

using Found = std::function<void(double time, const std::string& kind)>;
void findEvents(const Particles& start, double begin, const SegmentSet& before, double end, const SegmentSet& after,
                const Found& found) {
    if (before == after) return;
    const double middle = (begin + end) / 2;
    if (end - begin < 1e-9) return found(middle, kindOf(before, after));
    const SegmentSet between = combinatoricsOf(movedInPlane(start, middle));
    findEvents(start, begin, before, middle, between, found);
    findEvents(start, middle, between, end, after, found);
}

std::vector<PlanarEvent> findPlanarEvents() {
    constexpr std::size_t kMost = 24, kMostOfACloud = 3;
    constexpr double kSpan = 0.2;
    std::vector<PlanarEvent> list;
    std::map<std::string, std::size_t> count;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Particles start = movingPlanarCloud(seed);
        std::map<std::string, std::size_t> here;
        const auto keep = [&](double time, const std::string& kind) {
            if (kind == "several" || count[kind] == kMost || here[kind] == kMostOfACloud) return;
            ++count[kind], ++here[kind];
            list.push_back(
                {kind, kind + " of cloud " + std::to_string(seed) + " at " + std::to_string(time), start, time});
        };
        findEvents(start, 0, combinatoricsOf(start), kSpan, combinatoricsOf(movedInPlane(start, kSpan)), keep);
    }
    std::stable_sort(list.begin(), list.end(),
                     [](const PlanarEvent& a, const PlanarEvent& b) { return a.kind < b.kind; });
    return list;
}

// The Hausdorff distance of two curves, radii.
double distance(const Curves& one, const Curves& other) {
    double farthest = 0;
    for (const auto& [from, to] : {std::pair(&one, &other), std::pair(&other, &one)})
        for (const Edge& edge : from->edges)
            for (const double t : {0.0, 0.25, 0.5, 0.75}) {
                const Vec3 point = from->position[edge[0]] * (1 - t) + from->position[edge[1]] * t;
                farthest = std::max(farthest, distanceTo(*to, point));
            }
    return farthest / kDiscRadius;
}

SkinParams paramsOf(Tessellation tessellation, SmoothingMethod smoothing) {
    SkinParams params;
    params.radius = kDiscRadius;
    params.tessellation = tessellation;
    params.smoothing = smoothing;
    return params;
}

}  // namespace

Particles movingPlanarCloud(std::uint64_t seed) {
    Random random(seed);
    const double jitter = seed % 2 == 0 ? 0.25 : 1, keep = seed % 2 == 0 ? 0.9 : 0.35;
    Particles particles;
    for (int y = -4; y <= 4; ++y)
        for (int x = -4; x <= 4; ++x) {
            const Vec3 place = Vec3(x, y, 0) + random.cube() * jitter, velocity = random.cube();
            if (random.unit() > keep) continue;
            particles.position.emplace_back(Vec3(place.x, place.y, 0));
            particles.velocity.emplace_back(Vec3(velocity.x, velocity.y, 0));
        }
    return particles;
}

Particles movedInPlane(const Particles& start, double time) {
    Particles particles = start;
    for (std::size_t i = 0; i < start.size(); ++i)
        particles.position[i] = Vec3f(Vec3(start.position[i]) + Vec3(start.velocity[i]) * time);
    return particles;
}

const std::vector<PlanarEvent>& planarEvents() {
    static const std::vector<PlanarEvent> all = findPlanarEvents();
    return all;
}

const std::vector<std::pair<std::string, SkinParams>>& comparedCurves() {
    static const std::vector<std::pair<std::string, SkinParams>> all = [] {
        const SkinParams skin = paramsOf(Tessellation::complete, SmoothingMethod::coherent);
        const SkinParams not_smoothed = paramsOf(Tessellation::complete, SmoothingMethod::none);
        SkinParams three_passes = skin, discs = skin, raw_skin = not_smoothed, alpha_mesh = not_smoothed;
        three_passes.passes = 3;
        discs.skin = 0;
        raw_skin.skin = 0.5;
        alpha_mesh.surface = SurfaceKind::alpha;
        return std::vector<std::pair<std::string, SkinParams>>{
            {"ours, the skin", skin},
            {"ours, three passes", three_passes},
            {"ours, the skin, not smoothed", raw_skin},
            {"ours, on the discs", discs},
            {"ours, not smoothed", not_smoothed},
            {"paper's, not smoothed", paramsOf(Tessellation::paper, SmoothingMethod::none)},
            {"Algorithm 4", paramsOf(Tessellation::paper, SmoothingMethod::paper)},
            {"alpha mesh", alpha_mesh}};
    }();
    return all;
}

const SkinParams& comparedCurve(const std::string& name) {
    for (const auto& [curve, params] : comparedCurves())
        if (curve == name) return params;
    throw std::out_of_range(name);
}

double planarJumpAcross(const PlanarEvent& event, double span, const SkinParams& params) {
    return distance(skinPlane(movedInPlane(event.particles, event.time - span / 2), params).curves,
                    skinPlane(movedInPlane(event.particles, event.time + span / 2), params).curves);
}

}  // namespace betamesh
