
#include "planar/smooth_skin.h"

#include "base/cell_order.h"
#include "planar/curve_means.h"
#include "planar/uncrossed_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace betamesh {

namespace {

// Lengths in particle spacings.
constexpr double kNormalWidth = 0.6;  // of the mean that makes the normal
constexpr double kLeastMean = 0.1;    // |mean direction|² up to which what is too thin is left alone
constexpr double kSureMean = 0.4;     // and from which it is smoothed fully
constexpr double kNarrow = 0.8;       // width of the bi-Laplacian
constexpr int kNarrowBefore = 4;      // passes of it
constexpr int kNarrowAfter = 2;
constexpr double kLongestNarrow = 0.15;  // step
constexpr double kEven = 0.12;           // width of the mean of steps
constexpr double kLeastWide = 1;         // widths of a fit up to which it moves nothing
constexpr double kFullWide = 2;          // and from which it does fully
constexpr double kLongestWide = 0.3;
constexpr double kBack = 3;       // width of the mean of what was taken
constexpr double kSameWay = 0.5;  // cosines between which the curve goes sideways
constexpr double kOtherWay = -0.3;
constexpr double kBlur = 0.25;     // of these
constexpr double kPresent = 0.5;   // so long a piece that goes sideways ends a fit where it is
constexpr double kNearest = 0.2;   // nearer ones count as if they were so far away
constexpr double kSteepest = 0.2;  // square of how steeply what a fit takes in may lie
constexpr double kRound = 1e-3;    // added to the variance of places, square spacings
constexpr double kDiscord = 0.25;  // mean square by which directions may miss those of the circle

Dual positive(Dual a) { return a.value > 0 ? a : Dual(0); }
Dual clamped(Dual a, double low, double high) { return a.value < low ? low : a.value > high ? high : a; }

// An edge of the curve. Here as in all that follows lengths are in particle spacings.
struct EdgeSample {
    DualVec3 middle, direction;  // outwards, unit vector
    Dual length;
    Dual value;  // mean of its ends'
    std::array<std::uint32_t, 2> ends;
};

struct Normal {
    DualVec3 direction;  // unit vector
    Dual trust;        // 0 where opposite sides are too near to tell them apart, else 1
};

class SkinSmoother {
public:
    SkinSmoother(BetaCurve& curve, const SkinSmoothing& params) : curve_(curve), params_(params) {
        begin_ = curve.vertex;
    }

    void smoothNarrowly() {
        sample({});
        const std::vector<Normal> normal = normals();
        const auto means = [&](bool of_values) {
            std::vector<Dual> mean(size());
            forEdgesNear(kNarrow, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
                Dual sum = 0, total = 0;
                for (const std::uint32_t e : near) {
                    if (!counts(e, v, kNarrow, normal[v])) continue;
                    const EdgeSample& edge = edges_[e];
                    const DualVec3 offset = edge.middle - place_[v];
                    const Dual weight = kernel(offset, kNarrow) * facing(edge, normal[v]) * edge.length;
                    sum = sum + weight * (of_values ? edge.value : dot(offset, normal[v].direction));
                    total = total + weight;
                }
                if (total.value > 0) mean[v] = sum / total;
            });
            return mean;
        };
        std::vector<Dual> height = means(false);
        sample(height);
        const std::vector<Dual> usual = means(true);
        for (std::size_t v = 0; v < size(); ++v)
            height[v] = clamped(height[v] - usual[v], -kLongestNarrow, kLongestNarrow);
        move(normal, height, std::vector<Dual>(size(), 0));
    }

    void smoothWidely() {
        sample({});
        const std::vector<Normal> normal = normals();
        widths_ = widths(normal);
        std::vector<Dual> height(size()), raw(size());
        forEdgesNear(widest(), [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            raw[v] = wide(v);
            if (raw[v].value > 0) height[v] = stepOntoCircle(v, normal[v], near) * raw[v];
        });
        move(normal, height, raw);
    }

    void giveBack() {
        std::vector<Dual> lost(size());
        sample({});
        const std::vector<Normal> normal = normals();
        for (std::size_t v = 0; v < size(); ++v)
            lost[v] = dot((begin_[v] - curve_.vertex[v]) / params_.spacing, normal[v].direction);
        sample(lost);
        std::vector<Dual> height(size());
        forEdgesNear(kBack, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            if (!(wide(v).value > 0)) return;
            const Dual width = widths_[v].value < kBack ? widths_[v] : Dual(kBack);
            Dual sum = 0, total = 0;
            for (const std::uint32_t e : near) {
                if (!counts(e, v, width.value, normal[v])) continue;
                const EdgeSample& edge = edges_[e];
                const DualVec3 offset = edge.middle - place_[v];
                const Dual face = facing(edge, normal[v]);
                const Dual weight = kernel(offset, width) * face * face * level(offset, normal[v]) * edge.length;
                sum = sum + weight * edge.value;
                total = total + weight;
            }
            if (total.value > 0) height[v] = sum / total * wide(v);
        });
        move(normal, height, std::vector<Dual>(size(), 0));
    }

private:
    std::size_t size() const { return curve_.vertex.size(); }
    double widest() const { return params_.widest / params_.spacing; }

    void sample(const std::vector<Dual>& value) {
        const double scale = 1 / params_.spacing;
        origin_ = size() > 0 ? curve_.vertex[0].position : Vec3(0);
        place_.resize(size());
        for (std::size_t v = 0; v < size(); ++v) place_[v] = (curve_.vertex[v] - DualVec3{origin_, Vec3(0)}) * scale;
        edges_.clear();
        forEveryVertex(curve_, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
            const DualVec3 way = place_[after] - place_[v];
            const Dual size = length(way);
            if (!(size.value > 0)) return;
            const DualVec3 along = way / size;
            const DualVec3 outwards{{along.position.y, -along.position.x, 0}, {along.velocity.y, -along.velocity.x, 0}};
            edges_.push_back({(place_[v] + place_[after]) * 0.5,
                              outwards,
                              size,
                              value.empty() ? Dual(0) : (value[v] + value[after]) * 0.5,
                              {v, after}});
        });
    }

    // Calls visit(vertex, edges whose middles are within reach of it or little farther).
    template <typename Visit>
    void forEdgesNear(double reach, const Visit& visit) const {
        const auto middleOf = [&](std::size_t e) -> const Vec3& { return edges_[e].middle.position; };
        const CellOrder middles(edges_.size(), reach / 2, middleOf);
        const CellOrder cells(size(), std::min(reach / 2, 1.0), [&](std::size_t v) { return place_[v].position; });
        forCellsWithin(reach, cells, middles, middleOf, [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
            for (const std::uint32_t v : cells.rowsOf(cell)) visit(v, near);
        });
    }

    bool isWithin(double width, std::uint32_t e, std::uint32_t v) const {
        return (edges_[e].middle.position - place_[v].position).length2() < width * width;
    }
    // Is an edge near a vertex and faces its way?
    bool counts(std::uint32_t e, std::uint32_t v, double width, const Normal& normal) const {
        return isWithin(width, e, v) && dot(edges_[e].direction.position, normal.direction.position) > 0;
    }
    static Dual kernel(const DualVec3& offset, Dual width) {
        const Dual t = positive(1 - dot(offset, offset) / (width * width));
        return t * t;
    }
    static Dual facing(const EdgeSample& edge, const Normal& normal) {
        return positive(dot(edge.direction, normal.direction));
    }
    // Of what a fit takes in: 1 beside a point, 0 far above and below it.
    static Dual level(const DualVec3& offset, const Normal& normal) {
        const Dual height = dot(offset, normal.direction);
        const Dual t = positive(1 - height * height / ((dot(offset, offset) + 1) * kSteepest));
        return t * t;
    }
    // How much of a fit counts at a vertex.
    Dual wide(std::uint32_t v) const { return smoothStep((widths_[v] - kLeastWide) / (kFullWide - kLeastWide)); }

    std::vector<Normal> normals() const {
        std::vector<Normal> normals(size());
        forEdgesNear(kNormalWidth, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            DualVec3 sum;
            Dual total = 0;
            for (const std::uint32_t e : near) {
                if (!isWithin(kNormalWidth, e, v)) continue;
                const Dual weight = kernel(edges_[e].middle - place_[v], kNormalWidth) * edges_[e].length;
                sum = sum + edges_[e].direction * weight;
                total = total + weight;
            }
            if (!(total.value > 0)) return;
            const DualVec3 mean = sum / total;
            normals[v] = {normalized(mean), smoothStep((dot(mean, mean) - kLeastMean) / (kSureMean - kLeastMean))};
        });
        return normals;
    }

    // How far a vertex's fit reaches: about to where the curve goes neither its way nor the opposite one, and the less
    // far the more of it does.
    std::vector<Dual> widths(const std::vector<Normal>& normal) const {
        std::vector<Dual> widths(size());
        const double reach = widest();
        std::vector<DualVec3> direction;  // of edges: a facet between others goes about their way
        for (const EdgeSample& edge : edges_)
            direction.push_back(normalized(normal[edge.ends[0]].direction + normal[edge.ends[1]].direction));
        forEdgesNear(reach, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            Dual sum = 1 / (reach * reach * reach * reach);  // of inverse fourth powers of distances
            for (const std::uint32_t e : near) {
                if (!isWithin(reach, e, v)) continue;
                const EdgeSample& edge = edges_[e];
                const double way = dot(direction[e].position, normal[v].direction.position);
                if (!(way < kSameWay + kBlur && way > kOtherWay - kBlur)) continue;
                const Dual cosine = dot(direction[e], normal[v].direction);
                const DualVec3 offset = edge.middle - place_[v];
                const Dual sideways = smoothStep((kSameWay + kBlur - cosine) / kBlur) *
                                      smoothStep((cosine - kOtherWay + kBlur) / kBlur) * kernel(offset, reach);
                const Dual square = dot(offset, offset) + kNearest * kNearest;
                sum = sum + sideways * edge.length / (square * square * kPresent);
            }
            widths[v] = squareRoot(squareRoot(1 / sum));
        });
        return widths;
    }

    // Along the normal, from a vertex onto the circle that fits the curve near it.
    Dual stepOntoCircle(std::uint32_t v, const Normal& normal, std::span<const std::uint32_t> near) const {
        DualVec3 places, directions;
        Dual total = 0, along = 0, square = 0;
        for (const std::uint32_t e : near) {
            if (!counts(e, v, widths_[v].value, normal)) continue;
            const EdgeSample& edge = edges_[e];
            const DualVec3 offset = edge.middle - place_[v];
            const Dual face = facing(edge, normal);
            const Dual weight = kernel(offset, widths_[v]) * face * face * level(offset, normal) * edge.length;
            total = total + weight;
            places = places + offset * weight;
            directions = directions + edge.direction * weight;
            along = along + weight * dot(offset, edge.direction);
            square = square + weight * dot(offset, offset);
        }
        if (!(total.value > 0)) return 0;
        const DualVec3 a = places / total, b = directions / total;
        const Dual opening = along / total - dot(a, b), bend = opening / (square / total - dot(a, a) + kRound);
        const DualVec3 linear = b - a * bend;
        const Dual half_bend = bend / 2, minus_constant = dot(linear, a) + half_bend * (square / total);
        const Dual slope = dot(linear, linear) + 1e-6;
        const Dual root = squareRoot(slope * slope + half_bend * minus_constant * slope * 4);
        const Dual missed = (1 - dot(b, b) - opening * bend) / kDiscord;
        const Dual agreed = 1 / (1 + missed * missed * missed * missed);
        const DualVec3 step = linear * (minus_constant * 2 / (slope + root)) * agreed;
        return clamped(dot(step, normal.direction), -kLongestWide, kLongestWide);
    }

    // Along normals by heights, of which all but a share `raw` is averaged along the curve.
    void move(const std::vector<Normal>& normal, const std::vector<Dual>& height, const std::vector<Dual>& raw) {
        std::vector<DualVec3> step(size());
        for (std::size_t v = 0; v < size(); ++v)
            step[v] = normal[v].direction * (height[v] * normal[v].trust * params_.spacing);
        const std::vector<DualVec3> even = meansOf(step, curve_, kEven * params_.spacing);
        for (std::size_t v = 0; v < size(); ++v) step[v] = even[v] + (step[v] - even[v]) * raw[v];
        moveUncrossed(curve_, step, params_.spacing);
    }

    BetaCurve& curve_;
    SkinSmoothing params_;
    std::vector<DualVec3> begin_;
    Vec3 origin_{0, 0, 0};
    std::vector<DualVec3> place_;  // of vertices, from the origin
    std::vector<EdgeSample> edges_;
    std::vector<Dual> widths_;  // of fits
};

}  // namespace

void smoothSkin(BetaCurve& curve, const SkinSmoothing& params) {
    SkinSmoother smoother(curve, params);
    for (int i = 0; i < kNarrowBefore; ++i) smoother.smoothNarrowly();
    for (int pass = 0; pass < params.passes; ++pass) smoother.smoothWidely();
    for (int i = 0; i < kNarrowAfter; ++i) smoother.smoothNarrowly();
    smoother.giveBack();
}

}  // namespace betamesh
