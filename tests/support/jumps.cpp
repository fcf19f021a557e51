#include "support/jumps.h"

#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "support/events.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace betamesh {

namespace {

SkinParams paramsOf(Tessellation tessellation, SmoothingMethod smoothing) {
    SkinParams params;
    params.radius = kEventRadius;
    params.tessellation = tessellation;
    params.smoothing = smoothing;
    return params;
}

std::vector<SingleEvent> findSingleEvents() {
    constexpr std::size_t kMost = 8, kMostOfACloud = 2;
    std::vector<SingleEvent> list;
    std::map<std::pair<std::string, bool>, std::size_t> count;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const bool block = seed % 3 == 0, spray = seed % 3 == 2;
        const Particles start = block   ? movingCloud(seed, {5, 5, 5}, 0.25, 1)
                                : spray ? movingCloud(seed, {5, 5, 5}, 0.5, 0.1)
                                        : movingCloud(seed, {5, 5, 1}, 0.25, 0.8);
        const double span = spray ? 2 : 0.1;
        std::map<std::string, std::size_t> here;
        const auto particlesAt = [&](double time) { return advected(start, time); };
        const auto keep = [&](double time, const std::string& kind) {
            if (kind == "several" || count[{kind, block}] == kMost || here[kind] == kMostOfACloud) return;
            ++count[{kind, block}], ++here[kind];
            list.push_back(
                {kind, block, start, time, kind + " of cloud " + std::to_string(seed) + " at " + std::to_string(time)});
        };
        findEvents(0, span, comparedSurface("ours, on the balls"), particlesAt, keep);
    }
    std::stable_sort(list.begin(), list.end(), [](const SingleEvent& x, const SingleEvent& y) {
        return std::pair(x.kind, !x.in_block) < std::pair(y.kind, !y.in_block);
    });
    return list;
}

}  // namespace

const std::vector<SingleEvent>& singleEvents() {
    static const std::vector<SingleEvent> all = findSingleEvents();
    return all;
}

const std::vector<std::pair<std::string, SkinParams>>& comparedSurfaces() {
    static const std::vector<std::pair<std::string, SkinParams>> all = [] {
        const SkinParams skin = paramsOf(Tessellation::complete, SmoothingMethod::coherent);
        SkinParams balls = skin, alpha_mesh = skin;
        balls.skin = 0;
        alpha_mesh.surface = SurfaceKind::alpha;
        return std::vector<std::pair<std::string, SkinParams>>{
            {"ours, the skin", skin},
            {"ours, on the balls", balls},
            {"ours, not smoothed", paramsOf(Tessellation::complete, SmoothingMethod::none)},
            {"paper's, smoothed as ours", paramsOf(Tessellation::paper, SmoothingMethod::coherent)},
            {"paper's, not smoothed", paramsOf(Tessellation::paper, SmoothingMethod::none)},
            {"Algorithm 4", paramsOf(Tessellation::paper, SmoothingMethod::paper)},
            {"alpha mesh", alpha_mesh}};
    }();
    return all;
}

const SkinParams& comparedSurface(const std::string& name) {
    for (const auto& [surface, params] : comparedSurfaces())
        if (surface == name) return params;
    throw std::out_of_range(name);
}

double jumpAcross(const Particles& start, double time, double span, const SkinParams& params) {
    const Mesh before = skinFrame(advected(start, time - span / 2), params).mesh;
    const Mesh after = skinFrame(advected(start, time + span / 2), params).mesh;
    return surfaceDistance(before, after).max / kEventRadius;
}

}  // namespace betamesh
