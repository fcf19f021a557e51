
#include "skin/deforming_mesh.h"

#include "base/index.h"
#include "base/parallel.h"
#include "skin/ball_boundary.h"

#include <algorithm>
#include <utility>

namespace betamesh {

namespace {

// All lengths are in particle spacings.
constexpr double kGroupCell = 4;  // edge of the cells in which vertices are grouped

// Longest edges: where the surface is flat kLongestFlat, or kLongestOnBalls radii if that is more; where it is as round
// as a thread kLongestRound, and kShorterOnRims less on rims. Bend as in SoftNormals, over kBendWidth.
constexpr double kLongestFlat = 0.9, kLongestRound = 0.4, kShorterOnRims = 0.12;
constexpr double kLongestOnBalls = 0.55;  // a little longer than the segments into which arcs are cut
constexpr double kBendWidth = 0.8, kFlatBend = 0.03, kRoundBend = 0.1, kRimBend = 0.2;
// Rims of holes are saddles: hollow along their edges, by kHollow to kVeryHollow radians a unit. Bend counts from
// kSaddleBend on, and in full from twice that.
constexpr double kLongestOnSaddles = 0.2, kHollow = 0.05, kVeryHollow = 0.15, kSaddleBend = 0.07;
constexpr double kMeanNormalWidth = 0.3;
constexpr double kFadesOver = 0.5;  // of the longest length beyond it, until a vertex that splits an edge is all there
constexpr double kIntoMiddle = 0.05;  // the need from which on a vertex in a quad is in the middle of the long diagonal

constexpr double kFoldBegins = 0.95, kFolded = 0.8;  // agreement of normals from which vertices are drawn together
constexpr double kUnfolding = 0.7;                    // of the way to the mean of the vertices round one, in one step
constexpr double kUpright = 0.5;       // cosine to the surface's normal below which a triangle counts as upside down
constexpr double kLongerBy = 0.1;      // the square of that edge than those of the others, for it to be turned in full
constexpr double kLeastHeight = 0.03;  // over its longest edge, as a share of that, that it gets
constexpr float kLongestUnfolding = 0.25F;

enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kFields };

// Σ w n and Σ w, w = area · (1 - d²/width²)²₊ · (n · from)²₊.
struct SumNormals {
    SampleRuns<kFields> samples;
    float inverse_square_width;
    const Lanes (&point)[3], (&normal)[3];
    Lanes (&sums)[4];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3];
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(normal, first, n);
        const Some zero{}, one = zero + 1.0F;
        Some sum[4] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            Some t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) * inverse_square_width;
            Some c = f[kNx] * n[0] + f[kNy] * n[1] + f[kNz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some w = t * t * c * c * f[kArea];
            sum[0] += w * f[kNx];
            sum[1] += w * f[kNy];
            sum[2] += w * f[kNz];
            sum[3] += w;
        });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Σ w value / Σ w.
enum ValueField { kVx = 3, kVy, kVz, kWeight, kValueFields };
struct SumMeans {
    SampleRuns<kValueFields> samples;
    float inverse_square_width;
    const Lanes (&point)[3];
    Lanes (&mean)[3];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3];
        getLanes<kWidth>(point, first, x);
        const Some zero{}, one = zero + 1.0F;
        Some sum[3] = {}, weight = zero + 1e-12F;
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            Some t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) * inverse_square_width;
            t = t > 0 ? t : zero;
            const Some w = t * t * f[kWeight];
            weight += w;
            sum[0] += w * f[kVx];
            sum[1] += w * f[kVy];
            sum[2] += w * f[kVz];
        });
        for (Some& along : sum) along = along / weight;
        setLanes<kWidth>(mean, first, sum);
    }
};

// Edges by their ends, ascending; and how much a vertex in the middle is asked for.
struct LongEdge {
    std::uint32_t from, to;
    double share;
    std::pair<std::uint32_t, std::uint32_t> ends() const { return {from, to}; }
};

}  // namespace

DeformingMesh::DeformingMesh(BetaMesh& mesh, double spacing)
    : mesh_(mesh), spacing_(spacing), position_(mesh.vertex.size()) {
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] = mesh_.vertex[v].position; });
    weighDiagonals(shares());
    arrange();
}

void DeformingMesh::listHeld() {
    std::vector<std::uint8_t> in_group(size(), 0), lent(size(), 0);
    for (std::size_t g = 0; g < held_.size(); ++g) {
        const std::vector<FadingVertex>& group = mesh_.fading[g];
        auto& [all, from_one_another, lent_to_others] = held_[g] = {};
        all.resize(group.size());
        parallelFor(group.size(), 4096, [&](std::size_t i) {
            const FadingVertex& fading = group[i];
            all[i] = {fading.vertex, static_cast<std::uint32_t>(i), fading.from, {},
                      static_cast<float>(fading.share.value)};
            for (std::size_t k = 0; k < 4; ++k) all[i].weight[k] = static_cast<float>(fading.weight[k].value);
        });
        for (const HeldVertex& v : all) in_group[v.vertex] = 1;
        const auto isChained = [&](const HeldVertex& v) {
            return std::any_of(v.from.begin(), v.from.end(), [&](std::uint32_t u) { return in_group[u] != 0; });
        };
        std::copy_if(all.begin(), all.end(), std::back_inserter(from_one_another), isChained);
        for (const HeldVertex& v : from_one_another)
            for (const std::uint32_t u : v.from) lent[u] = in_group[u];
        std::copy_if(all.begin(), all.end(), std::back_inserter(lent_to_others),
                     [&](const HeldVertex& v) { return lent[v.vertex] != 0; });
        for (const HeldVertex& v : all) in_group[v.vertex] = lent[v.vertex] = 0;
    }
}

// How far each vertex is there: 1 where it does not rise.
std::vector<float> DeformingMesh::shares() const {
    std::vector<float> share(size(), 1);
    for (const auto& group : mesh_.fading)
        for (const FadingVertex& fading : group) share[fading.vertex] = static_cast<float>(fading.share.value);
    return share;
}

// Diagonals to corners that only just appear count for no more than these: quads come and go with such corners.
void DeformingMesh::weighDiagonals(const std::vector<float>& share) {
    for (FadingVertex& fading : mesh_.fading[2]) {
        const auto& [a, b, c, d] = fading.from;
        const double of_other = fading.weight[2].value + fading.weight[3].value;
        const double edge = (1 - of_other) * share[a] * share[b], other = of_other * share[c] * share[d];
        if (edge + other > 0) placeBetween(fading, other / (edge + other), 0);
    }
}

// Puts a vertex in a quad onto its diagonals, by their shares: where they pass each other, or into their middles.
void DeformingMesh::placeBetween(FadingVertex& fading, double of_other, double middle) {
    Vec3 place(0);
    for (std::size_t k = 0; k < 4; k += 2) {
        const double share = k == 0 ? 1 - of_other : of_other;
        const double sum = fading.weight[k].value + fading.weight[k + 1].value;
        double of_first = sum > 0 ? fading.weight[k].value / sum : 0.5;
        of_first += (0.5 - of_first) * middle;
        fading.weight[k] = share * of_first;
        fading.weight[k + 1] = share * (1 - of_first);
        for (const std::size_t m : {k, k + 1}) place += position_[fading.from[m]] * fading.weight[m].value;
    }
    position_[fading.vertex] = place;
}

// Vertices whose share is 0 come last and are in no group: they only follow the vertices from which they rise.
void DeformingMesh::arrange() {
    const std::vector<float> share = shares();
    const auto rows = static_cast<std::uint32_t>(size());
    const std::vector<std::uint32_t> shared = indicesWhere(rows, [&](std::uint32_t v) { return share[v] > 0; });
    std::vector<std::uint32_t> order;
    groups_ = PointGroups(inOrder(position_, shared), kGroupCell * spacing_, order);
    order = inOrder(shared, order);
    order.reserve(rows);
    for (std::uint32_t v = 0; v < rows; ++v)
        if (!(share[v] > 0)) order.push_back(v);
    reorderVertices(mesh_, order);
    position_ = inOrder(position_, order);
    groups_.fitBoxes(position_);
    const auto forCorners = [&](std::size_t t, const auto& visit) {
        for (const std::uint32_t v : mesh_.triangles[t]) visit(v, static_cast<std::uint32_t>(t));
    };
    triangles_of_ = sortedIntoRows<std::uint32_t>(size(), mesh_.triangles.size(), forCorners);
    listHeld();
    measure();
}

void DeformingMesh::measure() {
    const std::size_t n = size(), triangles = mesh_.triangles.size();
    facing_.resize(triangles);
    const double scale = 1 / (6 * spacing_ * spacing_);
    parallelFor(triangles, 4096, [&](std::size_t t) {
        const auto& [a, b, c] = mesh_.triangles[t];
        const Vec3f third(cross(position_[b] - position_[a], position_[c] - position_[a]) * scale);
        facing_[t] = {third, third.length()};
    });
    area_.resize(n);
    std::vector<Vec3f> sum(n);
    parallelFor(n, 2048, [&](std::size_t v) {
        Facing all{Vec3f(0), 0};
        for (const std::uint32_t t : triangles_of_[v]) {
            all.third += facing_[t].third;
            all.area += facing_[t].area;
        }
        area_[v] = all.area;
        sum[v] = all.third;
    });
    // Later groups rise from earlier ones; those on facets from one another.
    std::vector<std::pair<float, Vec3f>> kept, handed;
    for (auto group = held_.rbegin(); group != held_.rend(); ++group) {
        kept.assign(group->all.size(), {0.0F, Vec3f(0)});  // so that only what came in since is handed on
        handed.resize(group->all.size());
        for (int round = 0; round < group->rounds(); ++round) {
            const std::vector<HeldVertex>& some = round == 0 ? group->all : group->lent_to_others;
            for (std::size_t i = 0; i < some.size(); ++i) {
                const HeldVertex& v = some[i];
                auto& [area, vector_sum] = kept[v.row];
                handed[i] = {(area_[v.vertex] - area) * (1 - v.share), (sum[v.vertex] - vector_sum) * (1 - v.share)};
                area = area_[v.vertex] -= handed[i].first;
                vector_sum = sum[v.vertex] -= handed[i].second;
            }
            for (std::size_t i = 0; i < some.size(); ++i)
                for (std::size_t k = 0; k < 4; ++k) {
                    area_[some[i].from[k]] += handed[i].first * some[i].weight[k];
                    sum[some[i].from[k]] += handed[i].second * some[i].weight[k];
                }
        }
    }
    // A vertex without a share of its own faces as the triangles round it do.
    normal_.resize(n);
    agreement_.resize(n);
    parallelFor(n, 4096, [&](std::size_t v) {
        Vec3f normal = sum[v];
        agreement_[v] = area_[v] > 0 ? normal.length() / area_[v] : 1;
        if (!(area_[v] > 0)) {
            normal = Vec3f(0);
            for (const std::uint32_t t : triangles_of_[v]) normal += facing_[t].third;
        }
        normal_[v] = normal.normalized();
        area_[v] = std::max(area_[v], 0.0F);
    });
}

void DeformingMesh::move(std::vector<Vec3f>& step) {
    hold(step);
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] += Vec3(step[v]) * spacing_; });
    groups_.fitBoxes(position_);
}

std::vector<Vec3f> DeformingMesh::means(double width, const std::vector<Vec3f>& values) const {
    constexpr float kLeastArea = 1e-9F;  // where nothing has any, all count alike
    std::vector<Vec3f> means(values.size(), Vec3f(0));
    const auto inverse = static_cast<float>(1 / (width * width));
    forVicinities<kValueFields>(
        width,
        [&](std::uint32_t v, SampleFields<kValueFields>& f) {
            const Vec3f& value = values[v];
            f[kVx] = value.x, f[kVy] = value.y, f[kVz] = value.z, f[kWeight] = area_[v] + kLeastArea;
        },
        [&](const GroupLanes& group, SampleRuns<kValueFields> samples) {
            Lanes mean[3];
            forLanes(SumMeans{samples, inverse, group.place, mean});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                means[group.row[lane]] = Vec3f(mean[0][lane], mean[1][lane], mean[2][lane]);
        });
    return means;
}

std::vector<Vec3f> DeformingMesh::meanNormals() const {
    std::vector<Vec3f> normal = means(kMeanNormalWidth, normal_);
    parallelFor(size(), 8192, [&](std::size_t v) { normal[v].normalize(); });
    return normal;
}

DeformingMesh::SoftNormals DeformingMesh::softNormals(double width, const std::vector<Vec3f>& from) const {
    SoftNormals soft{std::vector<Vec3f>(size(), Vec3f(0)), std::vector<float>(size())};
    const auto inverse = static_cast<float>(1 / (width * width));
    forVicinities<kFields>(
        width,
        [&](std::uint32_t v, SampleFields<kFields>& f) {
            f[kArea] = area_[v], f[kNx] = from[v].x, f[kNy] = from[v].y, f[kNz] = from[v].z;
        },
        [&](const GroupLanes& group, SampleRuns<kFields> samples) {
            const GroupLanes::Vectors facing = group.of(from);
            Lanes sums[4];
            forLanes(SumNormals{samples, inverse, group.place, facing.lanes, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const std::uint32_t v = group.row[lane];
                const Vec3f sum(sums[0][lane], sums[1][lane], sums[2][lane]);
                const float length = sum.length();
                soft.normal[v] = length > 0 ? sum / length : from[v];
                soft.bend[v] = sums[3][lane] > 0 ? 1 - length / sums[3][lane] : 1;
            }
        });
    return soft;
}

// How much a vertex is asked for in the middle of an edge.
struct DeformingMesh::Need {
    const DeformingMesh& surface;
    std::vector<float> longest;  // edge there
    std::vector<float> share;    // of vertices: one that only just appears is no reason to split an edge
    std::vector<float> bent;     // 0 … 1: enough for the rim of a hole
    std::vector<Vec3f> normal;
    double longest_on_saddles;

    double operator()(std::uint32_t a, std::uint32_t b) const {
        const Vec3 along = (surface.position_[b] - surface.position_[a]) / surface.spacing_;
        const double length = along.length();
        double longest_here = (longest[a] + longest[b]) / 2;
        if (const float most = bent[a] + bent[b]; most > 0 && length > longest_on_saddles) {
            const double hollow = dot(Vec3(normal[a] - normal[b]), along) / (length * length);
            const double saddle = smoothStep((hollow - kHollow) / (kVeryHollow - kHollow)).value * most / 2;
            longest_here += (std::min(longest_here, longest_on_saddles) - longest_here) * saddle;
        }
        const double excess = length / longest_here - 1;
        return excess > 0 ? smoothStep(excess / kFadesOver).value * (share[a] * share[b]) : 0;
    }
};

void DeformingMesh::refine(double radius, double coarser) {
    const double longest_flat = std::max(kLongestFlat, kLongestOnBalls * radius);
    measure();
    const std::vector<Vec3f> normals = meanNormals();
    Need need{*this,   softNormals(kBendWidth, normals).bend, shares(), std::vector<float>(size()),
              normals, kLongestOnSaddles * coarser};
    parallelFor(size(), 4096, [&](std::size_t v) {
        const double bend = need.longest[v];
        const double round = smoothStep((bend - kFlatBend) / (kRoundBend - kFlatBend)).value;
        need.bent[v] = static_cast<float>(smoothStep((bend - kSaddleBend) / kSaddleBend).value);
        const double rim = smoothStep((bend - kRoundBend) / (kRimBend - kRoundBend)).value;
        need.longest[v] =
            static_cast<float>(coarser * (longest_flat * (1 - round) + kLongestRound * round - kShorterOnRims * rim));
    });
    // A vertex that appears on a long edge takes the place of one that splits it, and has to be there as far.
    const auto raise = [&](FadingVertex& fading, double asked) {
        fading.share = 1 - (1 - fading.share.value) * (1 - asked);
        need.share[fading.vertex] = static_cast<float>(fading.share.value);
    };
    auto &on_edges = mesh_.fading[0], &in_quads = mesh_.fading[2];
    for (FadingVertex& fading : on_edges) raise(fading, need(fading.from[0], fading.from[1]));
    for (FadingVertex& fading : in_quads) {
        const double of_other = fading.weight[2].value + fading.weight[3].value;
        const double asked = need(fading.from[0], fading.from[1]) * (1 - of_other) +
                             need(fading.from[2], fading.from[3]) * of_other;
        if (!(asked > 0)) continue;
        placeBetween(fading, of_other, smoothStep(asked / kIntoMiddle).value);
        raise(fading, asked);
    }
    for (std::size_t refinement = 0; refinement < kRefinements; ++refinement) splitLongEdges(refinement, need);
    arrange();
}

void DeformingMesh::splitLongEdges(std::size_t refinement, Need& need) {
    const std::size_t triangles = mesh_.triangles.size();
    constexpr std::size_t kPerTask = 8192;
    std::vector<std::vector<LongEdge>> parts((triangles + kPerTask - 1) / kPerTask);
    parallelFor(parts.size(), 1, [&](std::size_t task) {
        for (std::size_t t = task * kPerTask; t < std::min(triangles, (task + 1) * kPerTask); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                if (a > b) continue;  // seen from the other side, too
                const double share = need(a, b);
                if (share > 0) parts[task].push_back({a, b, share});
            }
    });
    std::vector<LongEdge> edges = concatenate(parts);
    if (edges.empty()) return;
    std::sort(edges.begin(), edges.end(),
              [](const LongEdge& a, const LongEdge& b) { return a.ends() < b.ends(); });
    edges.erase(std::unique(edges.begin(), edges.end(),
                            [](const LongEdge& a, const LongEdge& b) { return a.ends() == b.ends(); }),
                edges.end());
    const auto first = static_cast<std::uint32_t>(size());
    const auto middleOf = [&](std::uint32_t a, std::uint32_t b) -> std::uint32_t {
        if (!(need(std::min(a, b), std::max(a, b)) > 0)) return kInvalidIndex;
        const std::pair ends(std::min(a, b), std::max(a, b));
        const auto at = std::lower_bound(edges.begin(), edges.end(), ends,
                                         [](const LongEdge& edge, const auto& sought) { return edge.ends() < sought; });
        return first + static_cast<std::uint32_t>(at - edges.begin());
    };
    const auto addVertex = [&](std::vector<FadingVertex>& group, const std::array<std::uint32_t, 4>& from,
                               const std::array<double, 4>& weight, double share) {
        FadingVertex fading{static_cast<std::uint32_t>(size()), from, {}, share, {}};
        Vec3 place(0);
        double longest_here = 0, bent_here = 0;
        Vec3f normal(0);
        for (std::size_t k = 0; k < 4; ++k) {
            fading.weight[k] = weight[k];
            fading.whole = fading.whole + mesh_.vertex[from[k]] * weight[k];
            place += position_[from[k]] * weight[k];
            longest_here += need.longest[from[k]] * weight[k];
            bent_here += need.bent[from[k]] * weight[k];
            normal += need.normal[from[k]] * static_cast<float>(weight[k]);
        }
        mesh_.vertex.push_back(fading.whole);
        position_.push_back(place);
        need.longest.push_back(static_cast<float>(longest_here));
        need.share.push_back(static_cast<float>(share));
        need.bent.push_back(static_cast<float>(bent_here));
        need.normal.push_back(normal.normalized());
        group.push_back(fading);
    };
    auto& on_edges = mesh_.fading[kTessellationGroups + 2 * refinement];
    auto& in_quads = mesh_.fading[kTessellationGroups + 2 * refinement + 1];
    for (const LongEdge& edge : edges)
        addVertex(on_edges, {edge.from, edge.to, edge.to, edge.to}, {0.5, 0.5, 0, 0}, edge.share);
    std::vector<std::array<std::uint32_t, 3>> middles(triangles);
    parallelFor(triangles, 4096, [&](std::size_t t) {
        const Triangle& q = mesh_.triangles[t];
        for (std::size_t k = 0; k < 3; ++k) middles[t][k] = middleOf(q[k], q[(k + 1) % 3]);
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
        } else {  // a corner, and a quad with a vertex in it: on the diagonal to the cut that is further there
            const std::size_t whole = middle[0] == kInvalidIndex ? 0 : middle[1] == kInvalidIndex ? 1 : 2;
            const std::uint32_t a = q[whole], b = q[(whole + 1) % 3], c = q[(whole + 2) % 3];
            const std::uint32_t bc = middle[(whole + 1) % 3], ca = middle[(whole + 2) % 3];
            split.push_back({c, ca, bc});
            const std::array<std::uint32_t, 4> quad{a, b, bc, ca};
            const auto centre = static_cast<std::uint32_t>(size());
            const double to_bc = need.share[bc] / (2.0 * (need.share[bc] + need.share[ca])), to_ca = 0.5 - to_bc;
            addVertex(in_quads, quad, {to_bc, to_ca, to_bc, to_ca}, 0);
            for (std::size_t k = 0; k < 4; ++k) split.push_back({quad[k], quad[(k + 1) % 4], centre});
        }
    }
    for (; ball < mesh_.ball_begin.size(); ++ball) mesh_.ball_begin[ball] = static_cast<std::uint32_t>(split.size());
    mesh_.triangles = std::move(split);
}

// Adds to the steps what takes the corner opposite the longest edge of a triangle that lies upside down to the other
// side of that edge.
void DeformingMesh::turnBack(std::uint32_t triangle, std::vector<Vec3f>& step) const {
    const Triangle& t = mesh_.triangles[triangle];
    const Vec3 facing = Vec3(normal_[t[0]] + normal_[t[1]] + normal_[t[2]]).normalized();
    std::array<double, 3> square;  // of the edge opposite each corner
    for (std::size_t k = 0; k < 3; ++k) square[k] = (position_[t[(k + 1) % 3]] - position_[t[(k + 2) % 3]]).length2();
    const auto k = static_cast<std::size_t>(std::max_element(square.begin(), square.end()) - square.begin());
    if (!(square[k] > 0)) return;
    const Vec3 &from = position_[t[(k + 1) % 3]], &to = position_[t[(k + 2) % 3]], &apex = position_[t[k]];
    const Vec3 edge = to - from, normal = cross(edge, apex - from).normalized();
    // Where another edge is as long, neither corner moves.
    const double second = std::max(square[(k + 1) % 3], square[(k + 2) % 3]);
    const double turned = smoothStep((kUpright - dot(normal, facing)) / kUpright).value *
                          smoothStep((1 - second / square[k]) / kLongerBy).value;
    const Vec3 foot = from + edge * (dot(apex - from, edge) / square[k]);
    const Vec3 target = foot + cross(facing, edge) * kLeastHeight;
    step[t[k]] += Vec3f((target - apex) * (turned / spacing_));
}

void DeformingMesh::unfold() {
    std::vector<Vec3f> step(size(), Vec3f(0));
    parallelFor(size(), 2048, [&](std::size_t v) {
        const double share = smoothStep((kFoldBegins - agreement_[v]) / (kFoldBegins - kFolded)).value;
        const std::span<const std::uint32_t> round = std::as_const(triangles_of_)[v];
        if (!(share > 0) || round.empty()) return;
        Vec3 sum(0);  // of the vertices round it each twice
        for (const std::uint32_t t : round)
            for (const std::uint32_t u : mesh_.triangles[t]) sum += position_[u] - position_[v];
        step[v] = Vec3f(sum * (kUnfolding * share / (2.0 * static_cast<double>(round.size()) * spacing_)));
    });
    const std::vector<std::uint32_t> upset = indicesWhere(mesh_.triangles.size(), [&](std::uint32_t triangle) {
        const auto& [a, b, c] = mesh_.triangles[triangle];
        const Vec3f round = normal_[a] + normal_[b] + normal_[c];
        const auto& [third, area] = facing_[triangle];
        return !(dot(third, round) > static_cast<float>(kUpright) * area * round.length());
    });
    for (const std::uint32_t triangle : upset) turnBack(triangle, step);
    parallelFor(size(), 8192, [&](std::size_t v) {
        if (const float length = step[v].length(); length > kLongestUnfolding) step[v] *= kLongestUnfolding / length;
    });
    move(step);
    measure();
}

void DeformingMesh::setVelocities(std::vector<Vec3f>& velocity) {
    hold(velocity);
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].velocity = Vec3(velocity[v]); });
}

void DeformingMesh::writePositions() {
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].position = position_[v]; });
}

}  // namespace betamesh
