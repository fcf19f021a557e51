// The refinement of a DeformingMesh: long edges are split at vertices that fade in.

#include "base/index.h"
#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/deforming_mesh.h"

#include <algorithm>
#include <utility>

namespace betamesh {

namespace {

// An edge by its ends, ascending, and the demand for a vertex in its middle, 0 to 1.
struct LongEdge {
    std::uint32_t from, to;
    double demand;
    std::pair<std::uint32_t, std::uint32_t> ends() const { return {from, to}; }
};

}  // namespace

// The fade weight of each vertex: 1 unless it fades in.
std::vector<float> DeformingMesh::fadeWeights() const {
    std::vector<float> fade(size(), 1);
    for (const auto& group : mesh_.fading)
        for (const FadingVertex& fading : group) fade[fading.vertex] = static_cast<float>(fading.fade.value);
    return fade;
}

// Weighs the diagonals of quads by the fade weights of their ends, because quads appear and vanish with such corners.
void DeformingMesh::weighDiagonals(const std::vector<float>& fade) {
    for (FadingVertex& fading : mesh_.fading[2]) {
        const auto& [a, b, c, d] = fading.anchor;
        const double of_other = fading.anchor_weight[2].value + fading.anchor_weight[3].value;
        const double edge = (1 - of_other) * fade[a] * fade[b], other = of_other * fade[c] * fade[d];
        if (edge + other > 0) placeOnDiagonals(fading, other / (edge + other), 0);
    }
}

// Places a vertex in a quad between its diagonals; of_other: weight of the second one. On each diagonal it is where
// they pass each other (middle = 0), in the middle (1) or in between.
void DeformingMesh::placeOnDiagonals(FadingVertex& fading, double of_other, double middle) {
    Vec3 position(0);
    for (std::size_t k = 0; k < 4; k += 2) {
        const double share = k == 0 ? 1 - of_other : of_other;
        const double sum = fading.anchor_weight[k].value + fading.anchor_weight[k + 1].value;
        double of_first = sum > 0 ? fading.anchor_weight[k].value / sum : 0.5;
        of_first += (0.5 - of_first) * middle;
        fading.anchor_weight[k] = share * of_first;
        fading.anchor_weight[k + 1] = share * (1 - of_first);
        for (const std::size_t m : {k, k + 1}) position += position_[fading.anchor[m]] * fading.anchor_weight[m].value;
    }
    position_[fading.vertex] = position;
}

// The demand for a vertex in the middle of an edge, 0 to 1, from values per vertex.
struct DeformingMesh::SplitDemand {
    const DeformingMesh& surface;
    std::vector<float> longest;     // longest edge that is not split
    std::vector<float> fade;        // fade weight: edges of a vertex that has just appeared are not split
    std::vector<float> curved;      // 0 … 1: curved enough for the rim of a hole
    std::vector<Vec3f> normal;      // means over what is near
    std::vector<Vec3f> own_normal;  // of the one-ring alone
    double longest_on_saddles, shortest;
    std::uint32_t settled = 0;  // vertices before this one: edges between them have been split where they are long

    double operator()(std::uint32_t a, std::uint32_t b) const {
        if (std::max(a, b) < settled) return 0;
        const double spacing = surface.spacing_ * (static_cast<double>(surface.scale(a)) + surface.scale(b)) / 2;
        const Vec3 along = (surface.position_[b] - surface.position_[a]) / spacing;
        const double length = along.length();
        double longest_here = (longest[a] + longest[b]) / 2;
        if (const float both = curved[a] + curved[b]; both > 0 && length > longest_on_saddles) {
            const double concavity = dot(Vec3(normal[a] - normal[b]), along) / (length * length);  // radians per dx
            const double saddle =
                smoothStep((concavity - kSaddleBegins) / (kSaddleFull - kSaddleBegins)).value * both / 2;
            longest_here += (std::min(longest_here, longest_on_saddles) - longest_here) * saddle;
        }
        if (length > shortest) {  // around pinholes and on their rims edges may turn by less
            const double turn = std::abs(dot(Vec3(own_normal[a] - own_normal[b]), along)) / length;
            if (turn * longest_here > kMaxTurn * length) longest_here = std::max(shortest, kMaxTurn * length / turn);
        }
        const double excess = length / longest_here - 1;
        return excess > 0 ? smoothStep(excess / kSplitFade).value * (fade[a] * fade[b]) : 0;
    }
};

void DeformingMesh::refine(double radius, double edge_factor) {
    const double longest_flat = std::max(kMaxFlatEdge, kMaxFlatEdgeRadii * radius);
    measure();
    const std::vector<Vec3f> normals = meanNormals();
    SplitDemand demand{*this,
                       kernelNormals(kVariationKernel, normals).variation,
                       fadeWeights(),
                       std::vector<float>(size()),
                       normals,
                       normal_,
                       kMaxSaddleEdge * edge_factor,
                       kMinTurningEdge * edge_factor};
    parallelFor(size(), 4096, [&](std::size_t v) {
        const double variation = demand.longest[v];
        const double round = smoothStep((variation - kFlatVariation) / (kRoundVariation - kFlatVariation)).value;
        demand.curved[v] = static_cast<float>(smoothStep((variation - kSaddleVariation) / kSaddleVariation).value);
        const double rim = smoothStep((variation - kRoundVariation) / (kRimVariation - kRoundVariation)).value;
        demand.longest[v] = static_cast<float>(
            edge_factor * (longest_flat * (1 - round) + kMaxRoundEdge * round - kRimEdgeReduction * rim));
    });
    // A vertex that fades in on a long edge replaces one that would split the edge, and gets at least its fade weight.
    const auto increaseFade = [&](FadingVertex& fading, double demanded) {
        fading.fade = 1 - (1 - fading.fade.value) * (1 - demanded);
        demand.fade[fading.vertex] = static_cast<float>(fading.fade.value);
    };
    auto &on_edges = mesh_.fading[0], &in_quads = mesh_.fading[2];
    for (FadingVertex& fading : on_edges) increaseFade(fading, demand(fading.anchor[0], fading.anchor[1]));
    for (FadingVertex& fading : in_quads) {
        const double of_other = fading.anchor_weight[2].value + fading.anchor_weight[3].value;
        const double demanded = demand(fading.anchor[0], fading.anchor[1]) * (1 - of_other) +
                                demand(fading.anchor[2], fading.anchor[3]) * of_other;
        if (!(demanded > 0)) continue;
        placeOnDiagonals(fading, of_other, smoothStep(demanded / kQuadCentreFade).value);
        increaseFade(fading, demanded);
    }
    for (std::size_t refinement = 0; refinement < kRefinements; ++refinement) splitLongEdges(refinement, demand);
    arrange();
}

void DeformingMesh::splitLongEdges(std::size_t refinement, SplitDemand& demand) {
    const std::size_t triangles = mesh_.triangles.size();
    constexpr std::size_t kPerTask = 8192;
    std::vector<std::vector<LongEdge>> parts((triangles + kPerTask - 1) / kPerTask);
    std::vector<std::array<bool, 3>> is_long(triangles);
    parallelFor(parts.size(), 1, [&](std::size_t task) {
        for (std::size_t t = task * kPerTask; t < std::min(triangles, (task + 1) * kPerTask); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                const double demanded = demand(std::min(a, b), std::max(a, b));
                is_long[t][k] = demanded > 0;
                if (is_long[t][k] && a < b) parts[task].push_back({a, b, demanded});  // not again from the other side
            }
    });
    std::vector<LongEdge> edges = concatenate(parts);
    if (edges.empty()) return;
    std::sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) { return a.ends() < b.ends(); });
    edges.erase(std::unique(edges.begin(), edges.end(),
                            [](const LongEdge& a, const LongEdge& b) { return a.ends() == b.ends(); }),
                edges.end());
    const auto first = static_cast<std::uint32_t>(size());
    const auto middleOf = [&](std::uint32_t a, std::uint32_t b) {
        const std::pair ends(std::min(a, b), std::max(a, b));
        const auto at = std::lower_bound(edges.begin(), edges.end(), ends,
                                         [](const LongEdge& edge, const auto& sought) { return edge.ends() < sought; });
        return first + static_cast<std::uint32_t>(at - edges.begin());
    };
    const auto addVertex = [&](std::vector<FadingVertex>& group, const std::array<std::uint32_t, 4>& from,
                               const std::array<double, 4>& weight, double fade) {
        FadingVertex fading{static_cast<std::uint32_t>(size()), from, {}, fade, {}};
        Vec3 position(0);
        double longest = 0, curved = 0, scale = 0;
        Vec3f normal(0), own_normal(0);
        for (std::size_t k = 0; k < 4; ++k) {
            fading.anchor_weight[k] = weight[k];
            fading.unfaded = fading.unfaded + mesh_.vertex[from[k]] * weight[k];
            position += position_[from[k]] * weight[k];
            longest += demand.longest[from[k]] * weight[k];
            curved += demand.curved[from[k]] * weight[k];
            scale += static_cast<double>(this->scale(from[k])) * weight[k];
            normal += demand.normal[from[k]] * static_cast<float>(weight[k]);
            own_normal += demand.own_normal[from[k]] * static_cast<float>(weight[k]);
        }
        mesh_.vertex.push_back(fading.unfaded);
        if (!mesh_.scale.empty()) mesh_.scale.push_back(static_cast<float>(scale));
        position_.push_back(position);
        demand.longest.push_back(static_cast<float>(longest));
        demand.fade.push_back(static_cast<float>(fade));
        demand.curved.push_back(static_cast<float>(curved));
        demand.normal.push_back(normal.normalized());
        demand.own_normal.push_back(own_normal.normalized());
        group.push_back(fading);
    };
    auto& on_edges = mesh_.fading[kTessellationGroups + 2 * refinement];
    auto& in_quads = mesh_.fading[kTessellationGroups + 2 * refinement + 1];
    for (const LongEdge& edge : edges)
        addVertex(on_edges, {edge.from, edge.to, edge.to, edge.to}, {0.5, 0.5, 0, 0}, edge.demand);
    std::vector<std::array<std::uint32_t, 3>> middles(triangles);
    parallelFor(triangles, 4096, [&](std::size_t t) {
        const Triangle& q = mesh_.triangles[t];
        for (std::size_t k = 0; k < 3; ++k)
            middles[t][k] = is_long[t][k] ? middleOf(q[k], q[(k + 1) % 3]) : kInvalidIndex;
    });
    std::vector<Triangle> split;
    split.reserve(triangles + 4 * edges.size());
    std::size_t ball = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        for (; ball < mesh_.ball_begin.size() && mesh_.ball_begin[ball] == t; ++ball)
            mesh_.ball_begin[ball] = static_cast<std::uint32_t>(split.size());
        const Triangle q = mesh_.triangles[t];
        const std::array<std::uint32_t, 3>& middle = middles[t];
        const auto cuts = 3 - std::count(middle.begin(), middle.end(), kInvalidIndex);
        if (cuts == 0) {
            split.push_back(q);
        } else if (cuts == 3) {
            for (std::size_t k = 0; k < 3; ++k) split.push_back({q[k], middle[k], middle[(k + 2) % 3]});
            split.push_back({middle[0], middle[1], middle[2]});
        } else if (cuts == 1) {
            const std::size_t k = middle[0] != kInvalidIndex ? 0 : middle[1] != kInvalidIndex ? 1 : 2;
            split.push_back({q[k], middle[k], q[(k + 2) % 3]});
            split.push_back({middle[k], q[(k + 1) % 3], q[(k + 2) % 3]});
        } else {  // a corner triangle, and a quad with a vertex between its diagonals, by the fade weights of the cuts
            const std::size_t whole = middle[0] == kInvalidIndex ? 0 : middle[1] == kInvalidIndex ? 1 : 2;
            const std::uint32_t a = q[whole], b = q[(whole + 1) % 3], c = q[(whole + 2) % 3];
            const std::uint32_t bc = middle[(whole + 1) % 3], ca = middle[(whole + 2) % 3];
            split.push_back({c, ca, bc});
            const std::array<std::uint32_t, 4> quad{a, b, bc, ca};
            const auto centre = static_cast<std::uint32_t>(size());
            const double to_bc = demand.fade[bc] / (2.0 * (demand.fade[bc] + demand.fade[ca])), to_ca = 0.5 - to_bc;
            addVertex(in_quads, quad, {to_bc, to_ca, to_bc, to_ca}, 0);
            for (std::size_t k = 0; k < 4; ++k) split.push_back({quad[k], quad[(k + 1) % 4], centre});
        }
    }
    for (; ball < mesh_.ball_begin.size(); ++ball) mesh_.ball_begin[ball] = static_cast<std::uint32_t>(split.size());
    mesh_.triangles = std::move(split);
    demand.settled = first;
}

}  // namespace betamesh
