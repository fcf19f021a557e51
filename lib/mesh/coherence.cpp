
#include "betamesh/coherence.h"

#include "base/parallel.h"
#include "mesh/mesh_measure.h"
#include "mesh/triangle_tree.h"
#include "mesh/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr double kAreaAtCorners = 0.25;  // share of the area; integrates squares of linear functions exactly
constexpr double kMostCuts = 64;         // segments into which a triangle's side is divided
constexpr double kQuantile = 0.999;
constexpr double kRounding = 1e-15;     // of distances, relative to the largest coordinate
constexpr double kInscribedBall = 0.8;  // diameters; below 1 because liquid is curved

struct Sample {
    double weight;  // area
    double distance = 0;
};

double longestSide(const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::sqrt(std::max({(b - a).length2(), (c - b).length2(), (a - c).length2()}));
}

// The measurable triangles of a mesh.
class Surface {
public:
    explicit Surface(const Mesh& mesh) : position_(mesh.position), triangles_(measurableTriangles(mesh)) {}
    const std::vector<Vec3>& position() const { return position_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const Vec3& corner(std::size_t t, std::size_t m) const { return position_[triangles_[t][m]]; }

    // The sum of all triangles' longest sides.
    double sumOfLongestSides() const {
        double sum = 0;
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            sum += longestSide(corner(t, 0), corner(t, 1), corner(t, 2));
        return sum;
    }

    double largestCoordinate() const {
        double largest = 0;
        for (const Triangle& t : triangles_)
            for (const std::uint32_t v : t)
                for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(position_[v][k]));
        return largest;
    }

private:
    const std::vector<Vec3>& position_;
    std::vector<Triangle> triangles_;
};

// Sample points of a surface. Sample v is vertex v, with weight 0 where no triangle uses it; points inside triangles
// follow.
class Sampler {
public:
    Sampler(const Surface& surface, double spacing) : surface_(surface), cuts_(surface.triangles().size()) {
        const std::size_t n = surface.triangles().size();
        std::vector<std::size_t> count(n);
        parallelFor(n, 4096, [&](std::size_t t) {
            const double side = longestSide(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
            cuts_[t] =
                spacing > 0 ? static_cast<std::uint32_t>(std::clamp(std::ceil(side / spacing), 1.0, kMostCuts)) : 1;
            count[t] = std::size_t{cuts_[t]} * cuts_[t];
        });
        begin_ = exclusiveScan(count);
    }
    std::size_t size() const { return surface_.position().size() + begin_.back(); }

    // Writes each sample's area and its distance to the other surface. Both are 0 where the liquid inside the own
    // surface is thinner than `thinner`.
    void measure(const TriangleTree& other, const TriangleTree& own, double thinner, std::span<Sample> out) const {
        const std::vector<Vec3>& position = surface_.position();
        for (Sample& sample : out.first(position.size())) sample = {0};
        for (std::size_t t = 0; t < surface_.triangles().size(); ++t)
            for (const std::uint32_t v : surface_.triangles()[t]) out[v].weight += kAreaAtCorners * area(t) / 3;
        inBlocks(position.size(), [&](std::size_t v, std::size_t& hint) {
            if (out[v].weight > 0) out[v].distance = other.distanceTo(position[v], hint);
        });
        inBlocks(surface_.triangles().size(), [&](std::size_t t, std::size_t& hint) {
            std::size_t row = position.size() + begin_[t];
            const double weight = (1 - kAreaAtCorners) * area(t) / static_cast<double>(begin_[t + 1] - begin_[t]);
            forPointsInside(t, [&](const Vec3& point) { out[row++] = {weight, other.distanceTo(point, hint)}; });
        });
        if (thinner > 0) excludeThinLiquid(own, thinner, out);
    }
    Vec3 point(std::size_t row) const {
        if (row < surface_.position().size()) return surface_.position()[row];
        row -= surface_.position().size();
        const auto t =
            static_cast<std::size_t>(std::upper_bound(begin_.begin(), begin_.end(), row) - begin_.begin()) - 1;
        std::size_t next = begin_[t];
        Vec3 found(0);
        forPointsInside(t, [&](const Vec3& p) {
            if (next++ == row) found = p;
        });
        return found;
    }

private:
    void excludeThinLiquid(const TriangleTree& own, double thinner, std::span<Sample> out) const {
        const std::vector<Vec3>& position = surface_.position();
        const auto test = [&](const Vec3& point, const Vec3& normal, std::size_t& hint, Sample& sample) {
            const double radius = kInscribedBall * thinner / 2;
            if (own.distanceTo(point - normal * (thinner / 2), hint) < radius) sample = {0};
        };
        const std::vector<Vec3> normal = vertexNormals(position.size(), surface_.triangles(),
                                                       [&](std::uint32_t v) -> const Vec3& { return position[v]; });
        inBlocks(position.size(), [&](std::size_t v, std::size_t& hint) {
            if (out[v].weight > 0) test(position[v], normal[v], hint, out[v]);
        });
        inBlocks(surface_.triangles().size(), [&](std::size_t t, std::size_t& hint) {
            const Vec3& a = surface_.corner(t, 0);
            const Vec3 triangle_normal = cross(surface_.corner(t, 1) - a, surface_.corner(t, 2) - a).normalized();
            std::size_t row = position.size() + begin_[t];
            forPointsInside(t, [&](const Vec3& point) { test(point, triangle_normal, hint, out[row++]); });
        });
    }

    // Calls body(row, hint) for all rows, where hint is the result of the previous row's search. Blocks do not depend
    // on the number of threads, because the start of a search may change its result by rounding.
    template <typename Body>
    static void inBlocks(std::size_t n, const Body& body) {
        constexpr std::size_t kRows = 512;
        parallelFor((n + kRows - 1) / kRows, 1, [&](std::size_t block) {
            std::size_t hint = 0;
            for (std::size_t row = block * kRows; row < std::min(n, (block + 1) * kRows); ++row) body(row, hint);
        });
    }
    double area(std::size_t t) const {
        return areaOf(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
    }

    // Calls visit(point) for the centroids of the n² congruent triangles that arise when each side is cut into n equal
    // segments.
    template <typename Visit>
    void forPointsInside(std::size_t t, const Visit& visit) const {
        const Vec3 &a = surface_.corner(t, 0), &b = surface_.corner(t, 1), &c = surface_.corner(t, 2);
        const std::uint32_t n = cuts_[t];
        for (std::uint32_t i = 0; i < n; ++i)
            for (std::uint32_t j = 0; i + j < n; ++j)
                for (std::uint32_t inverted = 0; inverted < (i + j + 1 < n ? 2u : 1u); ++inverted) {
                    const double along_b = (i + (1 + inverted) / 3.0) / n, along_c = (j + (1 + inverted) / 3.0) / n;
                    visit(a + (b - a) * along_b + (c - a) * along_c);
                }
    }

    const Surface& surface_;
    std::vector<std::uint32_t> cuts_;
    std::vector<std::size_t> begin_;
};

double quantile(std::vector<Sample>& samples, double total_weight) {
    parallelSort(samples, [](const Sample& a, const Sample& b) {
        return a.distance != b.distance ? a.distance > b.distance : a.weight > b.weight;
    });
    double beyond = 0;
    for (const Sample& sample : samples)
        if ((beyond += sample.weight) >= (1 - kQuantile) * total_weight) return sample.distance;
    return 0;
}

}  // namespace

SurfaceDistance surfaceDistance(const Mesh& from, const Mesh& to, const DistanceSampling& sampling) {
    const Surface surface[2] = {Surface(from), Surface(to)};
    const std::size_t n[2] = {surface[0].triangles().size(), surface[1].triangles().size()};
    SurfaceDistance result;
    if (n[0] == 0 || n[1] == 0) {
        if (n[0] == n[1]) return result;
        result.max = result.quantile999 = result.rms = std::numeric_limits<double>::infinity();
        result.worst = surface[n[0] == 0].corner(0, 0);
        return result;
    }
    const double mean_side =
        (surface[0].sumOfLongestSides() + surface[1].sumOfLongestSides()) / static_cast<double>(n[0] + n[1]);
    const double spacing = sampling.spacing > 0 ? sampling.spacing : 2 * mean_side;
    const Sampler sampler[2] = {{surface[0], spacing}, {surface[1], spacing}};
    std::vector<Sample> samples(sampler[0].size() + sampler[1].size());
    const std::span first = std::span(samples).first(sampler[0].size()),
                    second = std::span(samples).subspan(first.size());
    const TriangleTree tree[2] = {{surface[0].position(), surface[0].triangles()},
                                  {surface[1].position(), surface[1].triangles()}};
    sampler[0].measure(tree[1], tree[0], sampling.thinner, first);
    sampler[1].measure(tree[0], tree[1], sampling.thinner, second);

    const double rounding = kRounding * std::max(surface[0].largestCoordinate(), surface[1].largestCoordinate());
    double total_weight = 0, squares = 0;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (samples[i].distance < rounding) samples[i].distance = 0;
        total_weight += samples[i].weight;
        squares += samples[i].weight * samples[i].distance * samples[i].distance;
        if (samples[i].distance > samples[worst].distance) worst = i;
    }
    result.samples = samples.size();
    result.max = samples[worst].distance;
    result.worst = worst < first.size() ? sampler[0].point(worst) : sampler[1].point(worst - first.size());
    result.area = total_weight;
    result.rms = total_weight > 0 ? std::sqrt(squares / total_weight) : 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!(samples[i].distance > sampling.beyond)) continue;
        const bool after = i >= first.size();
        const Vec3 point = after ? sampler[1].point(i - first.size()) : sampler[0].point(i);
        result.far.push_back({point, samples[i].distance, samples[i].weight, after});
    }
    result.quantile999 = quantile(samples, total_weight);
    return result;
}

std::optional<ParticleMotion> particleMotion(const Particles& from, const Particles& to) {
    const bool by_id = !from.id.empty() && !to.id.empty();
    if (!by_id && from.size() != to.size()) return std::nullopt;
    ParticleMotion motion;
    const auto match = [&](std::size_t before, std::size_t after) {
        const double distance = (Vec3(to.position[after]) - Vec3(from.position[before])).length();
        ++motion.matched;
        if (distance <= motion.max) return;
        motion.max = distance;
        motion.farthest = Vec3(from.position[before]);
    };
    if (!by_id) {
        for (std::size_t i = 0; i < from.size(); ++i) match(i, i);
        return motion;
    }
    const auto rowsById = [](const Particles& particles) {
        std::vector<std::pair<std::uint64_t, std::size_t>> rows(particles.size());
        parallelFor(rows.size(), 4096, [&](std::size_t i) { rows[i] = {particles.id[i], i}; });
        parallelSort(rows, std::less<>());
        return rows;
    };
    const auto before = rowsById(from), after = rowsById(to);
    for (const auto* rows : {&before, &after}) {
        const auto repeated =
            std::ranges::adjacent_find(*rows, std::equal_to<>(), [](const auto& r) { return r.first; });
        if (repeated != rows->end() && !motion.repeated_id) motion.repeated_id = repeated->first;
    }
    for (std::size_t i = 0, j = 0; i < before.size() && j < after.size();) {
        if (before[i].first == after[j].first) {
            match(before[i++].second, after[j++].second);
        } else {
            ++(before[i].first < after[j].first ? i : j);
        }
    }
    return motion;
}

Particles advected(const Particles& particles, double seconds) {
    Particles later = particles;
    parallelFor(later.size(), 4096, [&](std::size_t i) {
        later.position[i] = Vec3f(Vec3(particles.position[i]) + Vec3(particles.velocity[i]) * seconds);
    });
    return later;
}

}  // namespace betamesh
