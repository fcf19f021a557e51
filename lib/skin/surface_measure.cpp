#include "skin/surface_measure.h"
#include "skin/tune.h"

#include "core/ball_boundary.h"
#include "core/parallel.h"

#include <algorithm>
#include <utility>

namespace betamesh {

MovedSurface::MovedSurface(BetaMesh& mesh, double unit) : mesh_(mesh), unit_(unit), position_(mesh.vertex.size()) {
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] = mesh_.vertex[v].position; });
    if (tune("nohold", 0) > 0) for (int k = 0; k < 2; ++k) mesh_.rising[k].clear();
    if (tune("nohold", 0) > 1) mesh_.rising[2].clear();
    listTriangles();
    measure();
}

void MovedSurface::listTriangles() {
    triangles_of_ = sortedIntoRows<std::uint32_t>(size(), mesh_.triangles.size(), [&](std::size_t t, const auto& visit) {
        for (const std::uint32_t v : mesh_.triangles[t]) visit(v, static_cast<std::uint32_t>(t));
    });
}

void MovedSurface::measure() {
    const std::size_t n = size(), triangles = mesh_.triangles.size();
    std::vector<Vec3f> vector_area(triangles);  // a third
    std::vector<float> third(triangles);
    parallelFor(triangles, 4096, [&](std::size_t t) {
        const auto& [a, b, c] = mesh_.triangles[t];
        const Vec3 across = cross((position_[b] - position_[a]) / unit_, (position_[c] - position_[a]) / unit_) / 6;
        vector_area[t] = Vec3f(across);
        third[t] = static_cast<float>(across.length());
    });
    area_.assign(n, 0);
    std::vector<Vec3f> sum(n, Vec3f(0));
    parallelFor(n, 2048, [&](std::size_t v) {
        for (const std::uint32_t t : triangles_of_[v]) {
            area_[v] += third[t];
            sum[v] += vector_area[t];
        }
    });
    // Later groups rise from earlier ones; those on facets from one another.
    for (auto group = mesh_.rising.rbegin(); group != mesh_.rising.rend(); ++group) {
        std::vector<std::pair<float, Vec3f>> handed(group->size());
        for (std::size_t i = 0; i < group->size(); ++i) {
            const RisingVertex& rising = (*group)[i];
            const auto rest = static_cast<float>(1 - rising.share.value);
            handed[i] = {area_[rising.vertex] * rest, sum[rising.vertex] * rest};
        }
        for (std::size_t i = 0; i < group->size(); ++i) {
            const RisingVertex& rising = (*group)[i];
            area_[rising.vertex] -= handed[i].first;
            sum[rising.vertex] -= handed[i].second;
            for (std::size_t k = 0; k < 4; ++k) {
                const auto weight = static_cast<float>(rising.weight[k].value);
                area_[rising.from[k]] += handed[i].first * weight;
                sum[rising.from[k]] += handed[i].second * weight;
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
            for (const std::uint32_t t : triangles_of_[v]) normal += vector_area[t];
        }
        normal_[v] = normal.normalized();
        area_[v] = std::max(area_[v], 0.0F);
    });
}

void MovedSurface::move(std::vector<Vec3f>& step) {
    hold(step);
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] += Vec3(step[v]) * unit_; });
    float longest = 0;
    for (const Vec3f& s : step) longest = std::max(longest, s.length2());
    moved_ += std::sqrt(longest);
    measure();
}

MovedSurface::Vicinity MovedSurface::vicinity(double reach) {
    const double margin = tune("margin", 0.3);
    const auto at = [&](std::size_t v) -> const Vec3& { return position_[v]; };
    if (groups_.row.size() != size()) {
        groups_ = groupsOf(CellOrder(size(), tune("gcell", 3) * unit_, at), position_);
        reach_ = 0;
    }
    if (reach + 2 * moved_ > reach_ || reach_ > 2 * (reach + margin)) {
        reach_ = reach + margin;
        moved_ = 0;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            groups_.box[g] = Box();
            for (const std::uint32_t v : groups_[g]) groups_.box[g].extendBy(position_[v]);
        }
        const CellOrder order(size(), tune("scell", 0.7) * unit_, at);
        near_ = nearGroups(groups_, order, position_, reach_ * unit_);
    }
    return {groups_, near_};
}

void MovedSurface::refine(std::size_t round, const std::function<double(std::uint32_t, std::uint32_t)>& need) {
    struct LongEdge {
        std::uint32_t from, to;  // ascending
        double length;
        bool operator<(const LongEdge& other) const {
            return from != other.from ? from < other.from : to < other.to;
        }
    };
    const std::size_t triangles = mesh_.triangles.size();
    constexpr std::size_t kPerTask = 8192;
    std::vector<std::vector<LongEdge>> parts((triangles + kPerTask - 1) / kPerTask);
    parallelFor(parts.size(), 1, [&](std::size_t task) {
        for (std::size_t t = task * kPerTask; t < std::min(triangles, (task + 1) * kPerTask); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                if (a > b) continue;
                const double length = need(a, b);
                if (length > 1) parts[task].push_back({a, b, length});
            }
    });
    std::vector<LongEdge> edges = joined(parts);
    if (edges.empty()) return;
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end(),
                            [](const LongEdge& a, const LongEdge& b) { return a.from == b.from && a.to == b.to; }),
                edges.end());
    const auto first = static_cast<std::uint32_t>(size());
    const auto middleOf = [&](std::uint32_t a, std::uint32_t b) -> std::uint32_t {
        if (!(need(a, b) > 1)) return kHidden;
        const LongEdge edge{std::min(a, b), std::max(a, b), 0};
        const auto at = std::lower_bound(edges.begin(), edges.end(), edge);
        return first + static_cast<std::uint32_t>(at - edges.begin());
    };
    auto& on_edges = mesh_.rising[3 + 2 * round];
    auto& in_triangles = mesh_.rising[4 + 2 * round];
    const auto addVertex = [&](std::vector<RisingVertex>& group, const std::array<std::uint32_t, 4>& from,
                               const std::array<double, 4>& weight, Rate share) {
        RisingVertex rising{static_cast<std::uint32_t>(size()), from, {}, share, {}};
        Vec3 place(0);
        for (std::size_t k = 0; k < 4; ++k) {
            rising.weight[k] = weight[k];
            rising.whole = rising.whole + mesh_.vertex[from[k]] * weight[k];
            place += position_[from[k]] * weight[k];
        }
        mesh_.vertex.push_back(rising.whole);
        position_.push_back(place);
        group.push_back(rising);
    };
    const auto shareOf = [&](const LongEdge& edge) { return smoothStep((edge.length - 1) / tune("fadew", 0.5)).value; };
    for (const LongEdge& edge : edges)
        addVertex(on_edges, {edge.from, edge.to, edge.to, edge.to}, {0.5, 0.5, 0, 0}, shareOf(edge));
    std::vector<Triangle> split;
    split.reserve(triangles + 6 * edges.size());
    std::size_t ball = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        for (; ball < mesh_.ball_begin.size() && mesh_.ball_begin[ball] == t; ++ball)
            mesh_.ball_begin[ball] = static_cast<std::uint32_t>(split.size());
        const Triangle q = mesh_.triangles[t];
        std::array<std::uint32_t, 3> middle;
        std::size_t cuts = 0;
        for (std::size_t k = 0; k < 3; ++k) cuts += (middle[k] = middleOf(q[k], q[(k + 1) % 3])) != kHidden;
        if (cuts == 0) {
            split.push_back(q);
        } else if (cuts == 3) {
            for (std::size_t k = 0; k < 3; ++k) split.push_back({q[k], middle[k], middle[(k + 2) % 3]});
            split.push_back({middle[0], middle[1], middle[2]});
        } else if (cuts == 1) {
            const std::size_t k = middle[0] != kHidden ? 0 : middle[1] != kHidden ? 1 : 2;
            split.push_back({q[k], middle[k], q[(k + 2) % 3]});
            split.push_back({middle[k], q[(k + 1) % 3], q[(k + 2) % 3]});
        } else {  // a corner, and a quad with a vertex in it, whose place depends on no choice of a diagonal
            const std::size_t whole = middle[0] == kHidden ? 0 : middle[1] == kHidden ? 1 : 2;
            const std::uint32_t a = q[whole], b = q[(whole + 1) % 3], c = q[(whole + 2) % 3];
            const std::uint32_t bc = middle[(whole + 1) % 3], ca = middle[(whole + 2) % 3];
            split.push_back({c, ca, bc});
            const std::array<std::uint32_t, 4> quad{a, b, bc, ca};
            const auto centre = static_cast<std::uint32_t>(size());
            addVertex(in_triangles, quad, {0.25, 0.25, 0.25, 0.25}, 0);
            for (std::size_t k = 0; k < 4; ++k) split.push_back({quad[k], quad[(k + 1) % 4], centre});
        }
    }
    for (; ball < mesh_.ball_begin.size(); ++ball) mesh_.ball_begin[ball] = static_cast<std::uint32_t>(split.size());
    mesh_.triangles = std::move(split);
    listTriangles();
    measure();
}

namespace {

// The mean offset of what is near a point, (1 - d²/width²)² times area its weight.
struct SumOffset {
    std::span<const SampleFields<4>> samples;  // position, area
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
        for (const auto& f : samples) {
            const Some px = f[0] - x[0], py = f[1] - x[1], pz = f[2] - x[2];
            Some t = one - (px * px + py * py + pz * pz) * inverse_square_width;
            t = t > 0 ? t : zero;
            const Some w = t * t * f[3];
            weight += w;
            sum[0] += w * px;
            sum[1] += w * py;
            sum[2] += w * pz;
        }
        for (auto& s : sum) s = s / weight;
        setLanes<kWidth>(mean, first, sum);
    }
};

}  // namespace

void MovedSurface::unfold() {
    const double begin = tune("ufbegin", 0.75), end = tune("ufend", 0.45), width = tune("ufw", 0.4);
    (void)width;
    std::vector<Vec3f> step(size(), Vec3f(0));
    parallelFor(size(), 2048, [&](std::size_t v) {
        const double share = smoothStep((begin - agreement_[v]) / (begin - end)).value;
        const std::span<const std::uint32_t> round = std::as_const(triangles_of_)[v];
        if (!(share > 0) || round.empty()) return;
        Vec3 sum(0);
        for (const std::uint32_t t : round)
            for (const std::uint32_t u : mesh_.triangles[t]) sum += position_[u] - position_[v];
        step[v] = Vec3f(sum / (2.0 * static_cast<double>(round.size()) * unit_) * (tune("ufstep", 0.5) * share));
    });
    move(step);
}

void MovedSurface::setVelocities(std::vector<Vec3f>& velocity) {
    hold(velocity);
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].velocity = Vec3(velocity[v]); });
}

void MovedSurface::finish() {
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].position = position_[v]; });
}

}  // namespace betamesh
