// The fairing of the deforming mesh: along its edges instead of by kernels, where these cannot follow the surface.

#include "base/parallel.h"
#include "skin/constants.h"
#include "skin/deforming_mesh.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kLeastWeight = 1e-6;  // of a neighbour

}  // namespace

// Adds the displacement that moves the corner opposite the longest edge of an inverted triangle to the other side of
// that edge.
void DeformingMesh::turnInverted(std::uint32_t triangle, std::vector<Vec3f>& step) const {
    const Triangle& t = mesh_.triangles[triangle];
    const Vec3 surface_normal = Vec3(normal_[t[0]] + normal_[t[1]] + normal_[t[2]]).normalized();
    std::array<double, 3> square;  // of the edge opposite each corner
    for (std::size_t k = 0; k < 3; ++k) square[k] = (position_[t[(k + 1) % 3]] - position_[t[(k + 2) % 3]]).length2();
    const auto k = static_cast<std::size_t>(std::max_element(square.begin(), square.end()) - square.begin());
    if (!(square[k] > 0)) return;
    const Vec3 &from = position_[t[(k + 1) % 3]], &to = position_[t[(k + 2) % 3]], &apex = position_[t[k]];
    const Vec3 edge = to - from, normal = cross(edge, apex - from).normalized();
    // Nothing moves where another edge is as long, so that the choice of the longest is continuous.
    const double second = std::max(square[(k + 1) % 3], square[(k + 2) % 3]);
    const double turned = smoothStep((kInvertedCosine - dot(normal, surface_normal)) / kInvertedCosine).value *
                          smoothStep((1 - second / square[k]) / kLongestEdgeMargin).value;
    const Vec3 foot = from + edge * (dot(apex - from, edge) / square[k]);
    const Vec3 target = foot + cross(surface_normal, edge) * kTurnedHeight;
    step[t[k]] += Vec3f((target - apex) * (turned / spacing_));
}

// How much a triangle counts in the means of one-rings: 1, and 0 without area. A vertex that has only just been divided
// in two, as where four particles have a common sphere, has such triangles between the halves. A corner that fades in
// is beside others that make as good a triangle without it.
double DeformingMesh::triangleWeight(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const Vec3 &p = position_[a], &q = position_[b], &r = position_[c];
    const double squares = ((q - p).length2() + (r - q).length2() + (p - r).length2()) / (spacing_ * spacing_);
    const double equilateral = squares / (4 * std::numbers::sqrt3);  // its area with as long edges
    const double shape = std::min(1.0, 3 * static_cast<double>(third_[triangle].area) / (kWellShaped * equilateral));
    double fade = 1;
    for (const std::uint32_t v : mesh_.triangles[triangle])
        if (constraint_of_[v]) fade = std::min(fade, static_cast<double>(constraint_of_[v]->fade));
    return squares > 0 ? 1 - fade * (1 - shape) : 0;
}

// A vertex that fades in counts as a neighbour of v by its fade weight. For the rest, the neighbour is who would be if
// the vertex were not there: the other end of the edge or diagonal on which it lies, if v is at the one end.
template <typename Visit>
void DeformingMesh::visitNeighbour(std::uint32_t v, std::uint32_t neighbour, double weight, const Visit& visit) const {
    const Constraint* constraint = constraint_of_[neighbour];
    if (!constraint) return visit(neighbour, weight);
    const auto& [vertex, row, from, share, fade, group] = *constraint;
    if (fade > 0) visit(neighbour, weight * fade);
    weight *= 1 - fade;
    if (group == kOnFacets || !(weight > kLeastWeight)) return;  // on facets they lie on no edge
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t other = k ^ 1U;
        const double of_diagonal = share[k] + share[other];
        if (from[k] == v && of_diagonal > 0 && from[other] != v)
            visitNeighbour(v, from[other], weight * of_diagonal, visit);
    }
}

// Calls visit(u, k) for vertices that nearly coincide with v, as far as these count as one, k in (0, 1/2]: each is in
// two of the triangles.
template <typename Visit>
void DeformingMesh::forCoincident(std::uint32_t v, const Visit& visit) const {
    const double limit = static_cast<double>(kFoldCluster * scale(v)) * spacing_;
    for (const std::uint32_t t : triangles_of_[v])
        for (const std::uint32_t u : mesh_.triangles[t]) {
            const double k = 1 - (position_[u] - position_[v]).length2() / (limit * limit);
            if (u != v && k > 0) visit(u, k * k / 2);
        }
}

// The neighbours of a vertex, and of those that nearly coincide with it, with their shares of a mean, in order.
void DeformingMesh::listOneRing(std::uint32_t v, std::vector<RingVertex>& ring) const {
    ring.clear();
    const auto addRingOf = [&](std::uint32_t u, double k) {
        for (const std::uint32_t t : triangles_of_[u]) {
            const double weight = k * triangleWeight(t);
            for (const std::uint32_t x : mesh_.triangles[t])
                if (x != u)
                    visitNeighbour(u, x, weight, [&](std::uint32_t neighbour, double of_neighbour) {
                        ring.push_back({neighbour, of_neighbour});
                    });
        }
    };
    addRingOf(v, 1);
    forCoincident(v, [&](std::uint32_t u, double k) {
        const Constraint* constraint = constraint_of_[u];
        addRingOf(u, constraint ? k * static_cast<double>(constraint->fade) : k);
    });
    std::stable_sort(ring.begin(), ring.end(),
                     [](const RingVertex& a, const RingVertex& b) { return a.vertex < b.vertex; });
    std::size_t distinct = 0;
    double sum = 0;
    for (const RingVertex& x : ring) {
        sum += x.share;
        if (distinct > 0 && ring[distinct - 1].vertex == x.vertex)
            ring[distinct - 1].share += x.share;
        else
            ring[distinct++] = x;
    }
    ring.resize(sum > 0 ? distinct : 0);
    for (RingVertex& x : ring) x.share /= sum;
}

// Area and flatness of the one-ring of a vertex, together with those of vertices that nearly coincide with it.
DeformingMesh::RingShape DeformingMesh::ringShape(std::uint32_t v) const {
    if (has_short_edges_[v] == 0) return {area_[v], flatness_[v]};
    Vec3f vector_area(0);
    float area = 0;
    const auto add = [&](std::uint32_t u, double k) {
        const float weighted = area_[u] * static_cast<float>(k);
        vector_area += normal_[u] * (flatness_[u] * weighted);
        area += weighted;
    };
    add(v, 1);
    forCoincident(v, add);
    return {area, area > 0 ? vector_area.length() / area : flatness_[v]};
}

void DeformingMesh::relaxFolds() {
    std::vector<Vec3f> step(size(), Vec3f(0));
    parallelFor(size(), 2048, [&](std::size_t row) {
        const auto v = static_cast<std::uint32_t>(row);
        const double flatness = ringShape(v).flatness;
        const double share = smoothStep((kFoldBegins - flatness) / (kFoldBegins - kFoldFull)).value;
        if (!(share > 0)) return;
        std::vector<RingVertex> ring;
        listOneRing(v, ring);
        Vec3 mean(0);
        for (const auto& [neighbour, of_mean] : ring) mean += (position_[neighbour] - position_[v]) * of_mean;
        step[v] = Vec3f(mean * (kFoldRelaxation * share / spacing_));
    });
    const std::vector<std::uint32_t> inverted = indicesWhere(mesh_.triangles.size(), [&](std::uint32_t triangle) {
        const auto& [a, b, c] = mesh_.triangles[triangle];
        const Vec3f sum = normal_[a] + normal_[b] + normal_[c];
        const auto& [vector_area, area, has_short_edge] = third_[triangle];
        return !(dot(vector_area, sum) > static_cast<float>(kInvertedCosine) * area * sum.length());
    });
    for (const std::uint32_t triangle : inverted) turnInverted(triangle, step);
    parallelFor(size(), 8192, [&](std::size_t v) { step[v] = limitedTo(step[v], kMaxFoldStep * scale(v)); });
    move(step);
    measure();
}

// How much each vertex takes part in fairSharpParts(), 0 to 1: those of sharp one-rings in full, others the less the
// farther they are from these.
std::vector<float> DeformingMesh::fairingShares(const std::vector<float>& largest) const {
    std::vector<Vec3f> sharp(size(), Vec3f(0));
    parallelFor(size(), 2048, [&](std::size_t v) {
        const auto& [area, flatness] = ringShape(static_cast<std::uint32_t>(v));
        const double of_drop = kDropBend * static_cast<double>(area / (scale(v) * scale(v)));
        const double missing = std::min(kSharpBegins, 1 - of_drop) - static_cast<double>(flatness);
        sharp[v].x = static_cast<float>(smoothStep(missing / (kSharpBegins - kSharpFull)).value);
    });
    sharp = kernelMeansOfFew(kSharpKernel, sharp);
    std::vector<float> share(size());
    parallelFor(size(), 8192, [&](std::size_t v) {
        share[v] = largest[v] * std::clamp(kSharpGain * sharp[v].x - kLeastSharp, 0.0F, 1.0F);
    });
    return share;
}

// Lists the vertices that take part, then their other neighbours, with their one-rings among these.
DeformingMesh::LocalRings DeformingMesh::localRings(const std::vector<float>& share) const {
    LocalRings local{indicesWhere(share.size(), [&](std::uint32_t v) { return share[v] > 0; }), 0, {}, {}};
    std::vector<std::uint32_t>& vertex = local.vertex;
    local.moving = vertex.size();
    std::vector<std::vector<RingVertex>> ring(local.moving);
    parallelFor(ring.size(), 64, [&](std::size_t i) { listOneRing(vertex[i], ring[i]); });
    std::vector<std::uint32_t> row_of(size(), kInvalidIndex);
    for (std::uint32_t i = 0; i < local.moving; ++i) row_of[vertex[i]] = i;
    for (std::size_t i = 0; i < local.moving; ++i)
        for (const RingVertex& x : ring[i])
            if (row_of[x.vertex] == kInvalidIndex) {
                row_of[x.vertex] = static_cast<std::uint32_t>(vertex.size());
                vertex.push_back(x.vertex);
            }
    ring.resize(vertex.size());
    local.neighbours.resize(vertex.size());
    local.to_mean.resize(vertex.size());
    parallelFor(vertex.size(), 64, [&](std::size_t i) {
        if (i >= local.moving) listOneRing(vertex[i], ring[i]);
        Vec3 mean(0);
        for (const auto& [x, of_mean] : ring[i]) {
            mean += (position_[x] - position_[vertex[i]]) * of_mean;
            if (row_of[x] != kInvalidIndex) local.neighbours[i].push_back({row_of[x], of_mean});
        }
        local.to_mean[i] = Vec3f(mean / spacing_);
    });
    return local;
}

void DeformingMesh::fairSharpParts(const std::vector<float>& largest_share) {
    const std::vector<float> share = fairingShares(largest_share);
    const LocalRings local = localRings(share);
    const auto toMean = [&](const std::vector<Vec3f>& values, std::size_t i) {
        Vec3f mean = -values[i];
        for (const auto& [row, of_mean] : local.neighbours[i]) mean += values[row] * static_cast<float>(of_mean);
        return mean;
    };
    const std::size_t rows = local.vertex.size();
    std::vector<Vec3f> displacement(rows, Vec3f(0)), to_mean(rows), last_step(local.moving, Vec3f(0));
    for (int k = 0; k < kFairingSteps; ++k) {
        parallelFor(rows, 1024, [&](std::size_t i) { to_mean[i] = local.to_mean[i] + toMean(displacement, i); });
        parallelFor(local.moving, 1024, [&](std::size_t i) {
            Vec3f& step = last_step[i];
            step = step * kFairingMomentum - toMean(to_mean, i) * (kFairingGain * share[local.vertex[i]]);
            displacement[i] += step;
        });
    }
    std::vector<Vec3f> step(size(), Vec3f(0));
    for (std::size_t i = 0; i < local.moving; ++i) step[local.vertex[i]] = displacement[i];
    move(step);
    measure();
}

}  // namespace betamesh
