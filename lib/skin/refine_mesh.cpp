// The refinement of a DeformingMesh: long edges are split at vertices that fade in.

#include "base/index.h"
#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/deforming_mesh.h"

#include <algorithm>
#include <utility>

namespace betamesh {

// The fade weight of each vertex: 1 unless it fades in.
std::vector<float> DeformingMesh::fadeWeights() const {
    std::vector<float> fade(size(), 1);
    for (const auto& group : mesh_.fading)
        for (const FadingVertex& fading : group) fade[fading.vertex] = static_cast<float>(fading.fade.value);
    return fade;
}

// Weighs the diagonals of quads by the fade weights of their ends, because quads appear and vanish with such corners.
void DeformingMesh::weighDiagonals(const std::vector<float>& fade) {
    for (FadingVertex& fading : mesh_.fading[kInQuads]) {
        const auto& [a, b, c, d] = fading.support;
        const double of_other = fading.support_weight[2].value + fading.support_weight[3].value;
        const double edge = (1 - of_other) * fade[a] * fade[b], other = of_other * fade[c] * fade[d];
        if (edge + other > 0) placeOnDiagonals(fading, other / (edge + other), 0);
    }
}

// Moves a vertex that fades in in a quad between its diagonals; of_other: weight of the second one. On each diagonal it
// is where they pass each other (middle = 0), in the middle (1) or in between.
void DeformingMesh::placeOnDiagonals(FadingVertex& fading, double of_other, double middle) {
    Vec3 step(0);
    for (std::size_t k = 0; k < 4; k += 2) {
        const double share = k == 0 ? 1 - of_other : of_other;
        const double sum = fading.support_weight[k].value + fading.support_weight[k + 1].value;
        double of_first = sum > 0 ? fading.support_weight[k].value / sum : 0.5;
        of_first += (0.5 - of_first) * middle;
        for (const std::size_t m : {k, k + 1}) {
            const double weight = share * (m == k ? of_first : 1 - of_first);
            step += position_[fading.support[m]] * (weight - fading.support_weight[m].value);
            fading.support_weight[m] = weight;
        }
    }
    position_[fading.vertex] += step;
}

// The demand for a vertex in the middle of an edge, 0 to 1, from values per vertex.
struct DeformingMesh::SplitDemand {
    const DeformingMesh& surface;
    std::vector<float> longest;     // longest edge that is not split
    std::vector<float> fade;        // fade weight
    std::vector<float> curved;      // 0 … 1: curved enough for the rim of a hole
    std::vector<Vec3f> normal;      // means over what is near
    std::vector<Vec3f> own_normal;  // of the one-ring alone
    double longest_on_rims, shortest;

    double operator()(std::uint32_t a, std::uint32_t b) const {
        const double spacing = surface.spacing_ * (static_cast<double>(surface.scale(a)) + surface.scale(b)) / 2;
        const Vec3 along = (surface.position_[b] - surface.position_[a]) / spacing;
        const double length = along.length();
        double longest_here = (longest[a] + longest[b]) / 2;
        if (const float both = curved[a] + curved[b]; both > 0 && length > longest_on_rims) {
            const double concavity = dot(Vec3(normal[a] - normal[b]), along) / (length * length);  // radians per dx
            const double rim = smoothStep((concavity - kRimBegins) / (kRimFull - kRimBegins)).value * both / 2;
            longest_here += (std::min(longest_here, longest_on_rims) - longest_here) * rim;
        }
        if (length > shortest) {  // around pinholes and on their rims edges may turn by less
            const double turn = std::abs(dot(Vec3(own_normal[a] - own_normal[b]), along)) / length;
            if (turn * longest_here > kMaxTurn * length) longest_here = std::max(shortest, kMaxTurn * length / turn);
        }
        const double excess = length / longest_here - 1;
        return excess > 0 ? smoothStep(excess / kSplitFade).value : 0;
    }
};

DeformingMesh::SplitDemand DeformingMesh::splitDemand(double radius, double edge_factor) const {
    const double longest_flat = std::max(kMaxFlatEdge, kMaxFlatEdgeRadii * radius);
    const std::vector<Vec3f> normals = meanNormals();
    const std::vector<float> variation = kernelNormals(kVariationKernel, normals).variation;
    SplitDemand demand{*this,
                       std::vector<float>(size()),
                       fadeWeights(),
                       std::vector<float>(size()),
                       normals,
                       normal_,
                       kMaxRimEdge * edge_factor,
                       kMinTurningEdge * edge_factor};
    parallelFor(size(), 4096, [&](std::size_t v) {
        const double varies = variation[v];
        const double round = smoothStep((varies - kFlatVariation) / (kRoundVariation - kFlatVariation)).value;
        demand.curved[v] = static_cast<float>(smoothStep((varies - kRimVariation) / kRimVariation).value);
        demand.longest[v] = static_cast<float>(edge_factor * (longest_flat * (1 - round) + kMaxRoundEdge * round));
    });
    return demand;
}

void DeformingMesh::refine(double radius, double edge_factor) {
    measure();
    SplitDemand demand = splitDemand(radius, edge_factor);
    splitLongEdges(demand, kFirstRefinement);
    arrange();
}

void DeformingMesh::refineOnCurves(double radius) {
    SplitDemand demand = splitDemand(radius, 1);
    splitLongEdges(demand, kLastRefinement);
    listConnections();
}

// Vertices that fade in on a long edge, or in a quad with a long diagonal, replace those that would split it, and get
// at least their fade weight. So do vertices on facets, the more the nearer they are to the middles of long edges: on
// the facet itself they would be dents in what surrounds them, once that has been refined and moved.
void DeformingMesh::fadeInOnLongEdges(SplitDemand& demand, bool on_curves) {
    const auto raise = [&](FadingVertex& fading, double demanded) {
        fading.fade = 1 - (1 - fading.fade.value) * (1 - demanded);
        demand.fade[fading.vertex] = static_cast<float>(fading.fade.value);
    };
    for (FadingVertex& fading : mesh_.fading[kOnFacets]) {
        double all = 0;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const double both = fading.support_weight[i].value * fading.support_weight[j].value;  // 1/4 in a middle
                if (both > 0) all += 4 * both * demand(fading.support[j], fading.support[i]);
            }
        if (all > 0) raise(fading, std::min(all, 1.0));
    }
    for (const std::size_t group : {kOnEdges, kInQuads, kFirstRefinement, kFirstRefinement + 1})
        for (FadingVertex& fading : mesh_.fading[group]) {
            const auto& from = fading.support;
            std::array<double, 2> share, demanded;  // of each diagonal, or of the edge
            double all = 0;
            for (const std::size_t k : {0U, 1U}) {
                share[k] = fading.support_weight[2 * k].value + fading.support_weight[2 * k + 1].value;
                demanded[k] = share[k] > 0 ? share[k] * demand(from[2 * k], from[2 * k + 1]) : 0;
                all += demanded[k];
            }
            if (!(all > 0)) continue;
            if (group == kInQuads) placeOnDiagonals(fading, share[1], smoothStep(all / kQuadCentreFade).value);
            for (const std::size_t k : {0U, 1U})
                if (on_curves && demanded[k] > 0)
                    position_[fading.vertex] +=
                        curveOffset(from[2 * k], from[2 * k + 1], fading.support_weight[2 * k + 1].value / share[k],
                                    demand.normal) *
                        (demanded[k] * (1 - fading.fade.value));
            raise(fading, all);
        }
}

// How far the curve over an edge is from the edge at a fraction t of its length: a cubic curve that is perpendicular to
// the normals at both ends, as the edges of PN triangles are.
Vec3 DeformingMesh::curveOffset(std::uint32_t from, std::uint32_t to, double t,
                                const std::vector<Vec3f>& normal) const {
    const Vec3 along = position_[to] - position_[from], at_from(normal[from]), at_to(normal[to]);
    return (at_to * (dot(at_to, along) * t) - at_from * (dot(at_from, along) * (1 - t))) * (t * (1 - t));
}

// Splits the edges in demand at vertices in their middles, and the triangles with them.
class DeformingMesh::EdgeSplitter {
public:
    EdgeSplitter(DeformingMesh& surface, SplitDemand& demand)
        : surface_(surface),
          mesh_(surface.mesh_),
          demand_(demand),
          is_long_(mesh_.triangles.size()),
          edges_(longEdges()),
          first_middle_(static_cast<std::uint32_t>(surface.size())) {}

    bool hasLongEdges() const { return !edges_.empty(); }

    // Adds the vertices in the middles of the edges, and lists them.
    void addMiddles(bool on_curves, std::vector<FadingVertex>& listed) {
        for (const LongEdge& edge : edges_) {
            addVertex(listed, {edge.from, edge.to, edge.to, edge.to}, {0.5, 0.5, 0, 0}, edge.demand);
            if (on_curves)
                surface_.position_.back() +=
                    surface_.curveOffset(edge.from, edge.to, 0.5, demand_.normal) * edge.demand;
        }
    }

    // Splits the triangles at these, and lists the vertices that are added in quads.
    void splitTriangles(std::vector<FadingVertex>& listed) {
        const std::size_t triangles = mesh_.triangles.size();
        std::vector<Middles> middles(triangles);
        parallelFor(triangles, 4096, [&](std::size_t t) {
            const Triangle& q = mesh_.triangles[t];
            for (std::size_t k = 0; k < 3; ++k)
                middles[t][k] = is_long_[t][k] ? middleOf(q[k], q[(k + 1) % 3]) : kInvalidIndex;
        });
        std::vector<Triangle> split;
        split.reserve(triangles + 4 * edges_.size());
        std::vector<std::uint32_t>& ball_begin = mesh_.ball_begin;
        std::size_t ball = 0;
        for (std::size_t t = 0; t < triangles; ++t) {
            for (; ball < ball_begin.size() && ball_begin[ball] == t; ++ball)
                ball_begin[ball] = static_cast<std::uint32_t>(split.size());
            addParts(mesh_.triangles[t], middles[t], split, listed);
        }
        for (; ball < ball_begin.size(); ++ball) ball_begin[ball] = static_cast<std::uint32_t>(split.size());
        mesh_.triangles = std::move(split);
    }

private:
    // An edge by its ends, ascending, and the demand for a vertex in its middle, 0 to 1.
    struct LongEdge {
        std::uint32_t from, to;
        double demand;
        std::pair<std::uint32_t, std::uint32_t> ends() const { return {from, to}; }
    };
    // Of each edge of a triangle the vertex in its middle; kInvalidIndex: it is not split.
    using Middles = std::array<std::uint32_t, 3>;

    // The edges in demand, in order, each once. Sets is_long_.
    std::vector<LongEdge> longEdges() {
        constexpr std::size_t kPerTask = 8192;
        using Edges = std::vector<LongEdge>;
        Edges edges = concatenate(parallelParts<Edges>(
            mesh_.triangles.size(), kPerTask, [&](std::size_t begin, std::size_t end, Edges& part) {
                for (std::size_t t = begin; t < end; ++t)
                    for (std::size_t k = 0; k < 3; ++k) {
                        const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                        const double demanded = demand_(std::min(a, b), std::max(a, b));
                        is_long_[t][k] = demanded > 0;
                        if (is_long_[t][k] && a < b) part.push_back({a, b, demanded});  // not from the other side again
                    }
            }));
        std::sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) { return a.ends() < b.ends(); });
        edges.erase(std::unique(edges.begin(), edges.end(),
                                [](const LongEdge& a, const LongEdge& b) { return a.ends() == b.ends(); }),
                    edges.end());
        return edges;
    }

    std::uint32_t middleOf(std::uint32_t a, std::uint32_t b) const {
        const std::pair ends(std::min(a, b), std::max(a, b));
        const auto at = std::lower_bound(edges_.begin(), edges_.end(), ends,
                                         [](const LongEdge& edge, const auto& sought) { return edge.ends() < sought; });
        return first_middle_ + static_cast<std::uint32_t>(at - edges_.begin());
    }

    void addVertex(std::vector<FadingVertex>& listed, const std::array<std::uint32_t, 4>& from,
                   const std::array<double, 4>& weight, double fade) {
        FadingVertex fading{static_cast<std::uint32_t>(surface_.size()), from, {}, fade, {}};
        Vec3 position(0);
        double scale = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            fading.support_weight[k] = weight[k];
            fading.unfaded = fading.unfaded + mesh_.vertex[from[k]] * weight[k];
            position += surface_.position_[from[k]] * weight[k];
            scale += static_cast<double>(surface_.scale(from[k])) * weight[k];
        }
        mesh_.vertex.push_back(fading.unfaded);
        if (!mesh_.scale.empty()) mesh_.scale.push_back(static_cast<float>(scale));
        surface_.position_.push_back(position);
        demand_.fade.push_back(static_cast<float>(fade));
        listed.push_back(fading);
    }

    // Adds the triangles that a triangle is split into; listed: as in splitTriangles().
    void addParts(const Triangle& q, const Middles& middle, std::vector<Triangle>& split,
                  std::vector<FadingVertex>& listed) {
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
            const std::array<std::uint32_t, 4> quad{a, b, bc, ca};  // whose diagonals are a bc and b ca
            const auto centre = static_cast<std::uint32_t>(surface_.size());
            const std::vector<float>& fade = demand_.fade;
            const double to_bc = fade[bc] / (2.0 * (fade[bc] + fade[ca])), to_ca = 0.5 - to_bc;
            addVertex(listed, {a, bc, b, ca}, {to_bc, to_bc, to_ca, to_ca}, 0);
            for (std::size_t k = 0; k < 4; ++k) split.push_back({quad[k], quad[(k + 1) % 4], centre});
        }
    }

    DeformingMesh& surface_;
    BetaMesh& mesh_;
    SplitDemand& demand_;
    std::vector<std::array<bool, 3>> is_long_;  // of each triangle's edges
    std::vector<LongEdge> edges_;
    std::uint32_t first_middle_;  // vertex in the middle of the first edge; the others follow in order
};

// Splits edges in demand; their new vertices are listed from the group given on, those in quads in the next.
void DeformingMesh::splitLongEdges(SplitDemand& demand, std::size_t group) {
    const bool on_curves = group == kLastRefinement;
    fadeInOnLongEdges(demand, on_curves);
    EdgeSplitter splitter(*this, demand);
    if (!splitter.hasLongEdges()) return;
    splitter.addMiddles(on_curves, mesh_.fading[group]);
    splitter.splitTriangles(mesh_.fading[group + 1]);
}

}  // namespace betamesh
