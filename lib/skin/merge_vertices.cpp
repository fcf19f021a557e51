#include "skin/merge_vertices.h"

#include "base/index.h"
#include "base/parallel.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace betamesh {

namespace {

using Edge = std::array<std::uint32_t, 2>;

// Edges of no length, ascending.
std::vector<Edge> emptyEdges(const BetaMesh& mesh) {
    using Edges = std::vector<Edge>;
    Edges edges =
        concatenate(parallelParts<Edges>(mesh.triangles.size(), 8192, [&](auto first, auto last, Edges& found) {
            for (std::size_t t = first; t < last; ++t)
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
                    if (a < b && mesh.vertex[a].position == mesh.vertex[b].position) found.push_back({a, b});
                }
        }));
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

class Merger {
public:
    Merger(BetaMesh& mesh, const std::vector<Edge>& edges)
        : mesh_(mesh),
          valence_(mesh.vertex.size(), 0),
          row_(mesh.vertex.size(), kInvalidIndex),
          into_(mesh.vertex.size()),
          is_gone_(mesh.triangles.size(), false) {
        std::iota(into_.begin(), into_.end(), 0);
        for (const Edge& edge : edges)
            for (const std::uint32_t v : edge)
                if (row_[v] == kInvalidIndex) {
                    row_[v] = static_cast<std::uint32_t>(star_.size());
                    star_.emplace_back();
                }
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (const std::uint32_t v : mesh.triangles[t]) {
                ++valence_[v];
                if (row_[v] != kInvalidIndex) star_[row_[v]].push_back(t);
            }
    }

    // Merges the ends of an edge if that keeps the topology; false if it does not, or if they are one already.
    bool merge(const Edge& edge) {
        const auto [to, from] = std::minmax({remaining(edge[0]), remaining(edge[1])});
        if (to == from || !keepsTopology(to, from)) return false;
        for (const std::uint32_t t : std::exchange(star(from), {})) {
            Triangle& corners = mesh_.triangles[t];
            if (std::find(corners.begin(), corners.end(), to) == corners.end()) {
                std::replace(corners.begin(), corners.end(), from, to);
                star(to).push_back(t);
                ++valence_[to];
                continue;
            }
            is_gone_[t] = true;
            for (const std::uint32_t v : corners) {
                --valence_[v];
                if (row_[v] != kInvalidIndex) std::erase(star(v), t);
            }
        }
        into_[from] = to;
        return true;
    }

    // Removes the triangles that are gone, and lets vertices fade in from those that remain.
    void finish() {
        keepTriangles(mesh_, [&](std::size_t t) { return !is_gone_[t]; });
        for (auto& group : mesh_.fading)
            for (FadingVertex& fading : group)
                for (std::uint32_t& support : fading.support) support = remaining(support);
    }

private:
    std::vector<std::uint32_t>& star(std::uint32_t v) { return star_[row_[v]]; }
    std::uint32_t remaining(std::uint32_t v) const {
        while (into_[v] != v) v = into_[v];
        return v;
    }

    // Does the surface stay a manifold of the same topology? So it does if the two have exactly two common neighbours,
    // and these keep three triangles or more.
    //
    // source  the link condition: Dey, Edelsbrunner, Guha & Nekhayev 1999
    bool keepsTopology(std::uint32_t a, std::uint32_t b) {
        const std::vector<std::uint32_t> of_a = neighbours(a), of_b = neighbours(b);
        std::vector<std::uint32_t> common;
        std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(common));
        return common.size() == 2 &&
               std::all_of(common.begin(), common.end(), [&](std::uint32_t v) { return valence_[v] > 3; });
    }
    std::vector<std::uint32_t> neighbours(std::uint32_t v) {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t t : star(v))
            for (const std::uint32_t w : mesh_.triangles[t])
                if (w != v) found.push_back(w);
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }

    BetaMesh& mesh_;
    std::vector<std::uint32_t> valence_;  // triangles of each vertex
    std::vector<std::uint32_t> row_;      // in star_, of each end of an edge of no length
    std::vector<std::vector<std::uint32_t>> star_;
    std::vector<std::uint32_t> into_;  // the vertex into which each has been merged, or itself
    std::vector<bool> is_gone_;        // of each triangle
};

}  // namespace

void mergeCoincidentVertices(BetaMesh& mesh) {
    std::vector<Edge> edges = emptyEdges(mesh);
    if (edges.empty()) return;
    Merger merger(mesh, edges);
    for (bool is_done = false; !is_done;) {  // some can be merged only after others
        const std::size_t before = edges.size();
        std::erase_if(edges, [&](const Edge& edge) { return merger.merge(edge); });
        is_done = edges.size() == before;
    }
    merger.finish();
}

}  // namespace betamesh
