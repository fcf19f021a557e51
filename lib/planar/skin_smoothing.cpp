
#include "planar/skin_smoothing.h"

#include "planar/curve_displacement.h"
#include "planar/scaled_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace betamesh {

namespace {

// Lengths in particle spacings.
constexpr double kNormalWidth = 0.6;     // of the mean direction that gives the normal
constexpr double kLeastMean = 0.1;       // |mean direction|² up to which vertices do not move: the curve is too thin
constexpr double kSureMean = 0.4;        // and from which they move fully
constexpr double kNarrow = 0.8;          // width of the bi-Laplacian
constexpr int kNarrowBefore = 4;         // bi-Laplacian passes before the wide fits
constexpr int kNarrowAfter = 2;          // and after them
constexpr double kLongestNarrow = 0.15;  // longest step of the bi-Laplacian
constexpr double kStepWidth = 0.12;      // width over which steps are smoothed along the curve
constexpr double kLeastWide = 1;         // widths of fits up to which they move nothing
constexpr double kFullWide = 2;          // and from which they move vertices fully
constexpr double kLongestWide = 0.3;     // longest step of a fit
constexpr double kRestored = 3;          // width of the mean displacement that is undone
// The curve is sideways to a vertex's normal where the cosine between the normals is between these two.
constexpr double kSameDirection = 0.5;
constexpr double kOppositeDirection = -0.3;
constexpr double kBlur = 0.25;           // width of the transition at these cosines
constexpr double kSidewaysLength = 0.5;  // length of curve that, sideways at a distance, ends a fit there
constexpr double kLeastDistance = 0.2;   // smaller distances of sideways edges count as this
constexpr double kMeanWidths = 2.5;      // width of the mean over the widths of fits
constexpr double kSteepest = 0.2;        // squared slope at which an edge seen from the vertex has weight 0
constexpr double kVariance = 1e-3;       // square spacings: added to the variance of positions
constexpr double kDisagreement = 0.25;   // mean squared difference of directions that halves a step

Dual positivePart(Dual a) { return a.value > 0 ? a : Dual(0); }
Dual clamped(Dual a, double low, double high) { return a.value < low ? low : a.value > high ? high : a; }

// An edge of the curve. Here and below lengths are in particle spacings; where those differ, in the largest ones.
struct EdgeSample {
    DualVec3 middle, direction;  // direction: outward unit normal
    Dual length;
    Dual value;  // mean of the values of its ends
    std::array<std::uint32_t, 2> ends;
};

struct Normal {
    DualVec3 direction;  // unit vector
    Dual trust;          // 0 where opposite sides are too close to be distinguished, else 1
};

class SkinSmoother {
public:
    SkinSmoother(BetaCurve& curve, const SkinSmoothing& params) : curve_(curve), params_(params) {
        original_ = curve.vertex;
        for (std::uint32_t v = 0; v < curve.vertex.size(); ++v) inverse_scale_.push_back(1 / scaleOf(v));
    }

    void smoothNarrowly() {
        sample({});
        const std::vector<Normal> normal = normals();
        // For each vertex the mean height of the edges above it or, with of_values, the mean of their values.
        const auto means = [&](bool of_values) {
            std::vector<Dual> mean(size());
            forEdgesNear(kNarrow, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
                Dual sum = 0, total = 0;
                for (const std::uint32_t e : near) {
                    if (!isFacingNeighbour(e, v, kNarrow, normal[v])) continue;
                    const EdgeSample& edge = edges_[e];
                    const DualVec3 offset = offsetOf(e, v);
                    const Dual weight = kernel(offset, kNarrow) * facing(edge, normal[v]) * edge.length;
                    sum = sum + weight * (of_values ? edge.value : dot(offset, normal[v].direction) * scaleOf(v));
                    total = total + weight;
                }
                if (total.value > 0) mean[v] = sum / total;
            });
            return mean;
        };
        std::vector<Dual> height = means(false);
        sample(height);
        const std::vector<Dual> mean_height = means(true);
        for (std::size_t v = 0; v < size(); ++v)
            height[v] = clamped(height[v] - mean_height[v], -kLongestNarrow * scaleOf(v), kLongestNarrow * scaleOf(v));
        move(normal, height, std::vector<Dual>(size(), 0));
    }

    void smoothWidely() {
        sample({});
        const std::vector<Normal> normal = normals();
        widths_ = widths(normal);
        std::vector<Dual> height(size()), unsmoothed(size());
        forEdgesNear(widest(), [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            unsmoothed[v] = wideWeight(v);
            if (unsmoothed[v].value > 0) height[v] = stepOntoCircle(v, normal[v], near) * scaleOf(v) * unsmoothed[v];
        });
        move(normal, height, unsmoothed);
    }

    // Moves vertices back by the mean of their displacements so far.
    void restoreLongWaves() {
        std::vector<Dual> lost(size());
        sample({});
        const std::vector<Normal> normal = normals();
        for (std::size_t v = 0; v < size(); ++v)
            lost[v] = dot((original_[v] - curve_.vertex[v]) / params_.spacing, normal[v].direction);
        sample(lost);
        std::vector<Dual> height(size());
        forEdgesNear(kRestored, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            if (!(wideWeight(v).value > 0)) return;
            const Dual width = widths_[v].value < kRestored ? widths_[v] : Dual(kRestored);
            Dual sum = 0, total = 0;
            for (const std::uint32_t e : near) {
                if (!isFacingNeighbour(e, v, width.value, normal[v])) continue;
                const EdgeSample& edge = edges_[e];
                const DualVec3 offset = offsetOf(e, v);
                const Dual face = facing(edge, normal[v]);
                const Dual weight = kernel(offset, width) * face * face * levelWeight(offset, normal[v]) * edge.length;
                sum = sum + weight * edge.value;
                total = total + weight;
            }
            if (total.value > 0) height[v] = sum / total * wideWeight(v);
        });
        move(normal, height, std::vector<Dual>(size(), 0));
    }

private:
    std::size_t size() const { return curve_.vertex.size(); }
    double widest() const { return params_.widest / params_.spacing; }

    // Converts the curve to spacings and makes samples of its edges. value: of each vertex; empty: 0.
    void sample(const std::vector<Dual>& value) {
        const double scale = 1 / params_.spacing;
        origin_ = size() > 0 ? curve_.vertex[0].position : Vec3(0);
        position_.resize(size());
        for (std::size_t v = 0; v < size(); ++v) position_[v] = (curve_.vertex[v] - DualVec3{origin_, Vec3(0)}) * scale;
        edges_.clear();
        forEveryVertex(curve_, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
            const DualVec3 edge = position_[after] - position_[v];
            const Dual size = length(edge);
            if (!(size.value > 0)) return;
            const DualVec3 along = edge / size;
            const DualVec3 outwards{{along.position.y, -along.position.x, 0}, {along.velocity.y, -along.velocity.x, 0}};
            edges_.push_back({(position_[v] + position_[after]) * 0.5,
                              outwards,
                              size,
                              value.empty() ? Dual(0) : (value[v] + value[after]) * 0.5,
                              {v, after}});
        });
    }

    // Calls visit(vertex, edges) for every vertex, with all edges whose midpoints are within reach and some beyond.
    template <typename Visit>
    void forEdgesNear(double reach, const Visit& visit) const {
        const auto middleOf = [&](std::size_t e) -> const Vec3& { return edges_[e].middle.position; };
        forScaledNeighbours(
            {reach, std::min(reach / 2, 1.0), reach / 2}, size(),
            [&](std::size_t v) -> const Vec3& { return position_[v].position; }, curve_.scales(), edges_.size(),
            middleOf, visit);
    }

    double scaleOf(std::size_t v) const { return curve_.scaleOf(v).value; }
    // From a vertex to the middle of an edge; here and below in spacings at the vertex.
    DualVec3 offsetOf(std::uint32_t e, std::uint32_t v) const {
        return (edges_[e].middle - position_[v]) * inverse_scale_[v];
    }
    bool isWithin(double width, std::uint32_t e, std::uint32_t v) const {
        return ((edges_[e].middle.position - position_[v].position) * inverse_scale_[v]).length2() < width * width;
    }
    // Is an edge within `width` of a vertex, and on the same side as the vertex's normal?
    bool isFacingNeighbour(std::uint32_t e, std::uint32_t v, double width, const Normal& normal) const {
        return isWithin(width, e, v) && dot(edges_[e].direction.position, normal.direction.position) > 0;
    }
    static Dual kernel(const DualVec3& offset, Dual width) {
        const Dual t = positivePart(1 - dot(offset, offset) / (width * width));
        return t * t;
    }
    static Dual facing(const EdgeSample& edge, const Normal& normal) {
        return positivePart(dot(edge.direction, normal.direction));
    }
    // Weight of an edge by its slope seen from the vertex: 1 beside the vertex, 0 far above and below it.
    static Dual levelWeight(const DualVec3& offset, const Normal& normal) {
        const Dual height = dot(offset, normal.direction);
        const Dual t = positivePart(1 - height * height / ((dot(offset, offset) + 1) * kSteepest));
        return t * t;
    }
    // The share of a wide fit that a vertex moves.
    Dual wideWeight(std::uint32_t v) const { return smoothStep((widths_[v] - kLeastWide) / (kFullWide - kLeastWide)); }

    std::vector<Normal> normals() const {
        std::vector<Normal> normals(size());
        forEdgesNear(kNormalWidth, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            DualVec3 sum;
            Dual total = 0;
            for (const std::uint32_t e : near) {
                if (!isWithin(kNormalWidth, e, v)) continue;
                const Dual weight = kernel(offsetOf(e, v), kNormalWidth) * edges_[e].length;
                sum = sum + edges_[e].direction * weight;
                total = total + weight;
            }
            if (!(total.value > 0)) return;
            const DualVec3 mean = sum / total;
            normals[v] = {normalized(mean), smoothStep((dot(mean, mean) - kLeastMean) / (kSureMean - kLeastMean))};
        });
        return normals;
    }

    // The width of each vertex's fit: roughly the distance at which the curve is sideways to the vertex's normal, and
    // the smaller the more of it is.
    std::vector<Dual> widths(const std::vector<Normal>& normal) const {
        std::vector<Dual> widths(size());
        const double reach = widest();
        std::vector<DualVec3> direction;  // of edges, as the mean of their ends' normals: smoother than their own
        for (const EdgeSample& edge : edges_)
            direction.push_back(normalized(normal[edge.ends[0]].direction + normal[edge.ends[1]].direction));
        forEdgesNear(reach, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            Dual sum = 1 / (reach * reach * reach * reach);  // inverse fourth powers of distances
            for (const std::uint32_t e : near) {
                if (!isWithin(reach, e, v)) continue;
                const EdgeSample& edge = edges_[e];
                const double estimate = dot(direction[e].position, normal[v].direction.position);
                if (!(estimate < kSameDirection + kBlur && estimate > kOppositeDirection - kBlur)) continue;
                const Dual cosine = dot(direction[e], normal[v].direction);
                const DualVec3 offset = offsetOf(e, v);
                const Dual sideways = smoothStep((kSameDirection + kBlur - cosine) / kBlur) *
                                      smoothStep((cosine - kOppositeDirection + kBlur) / kBlur) * kernel(offset, reach);
                const Dual square = dot(offset, offset) + kLeastDistance * kLeastDistance;
                sum = sum + sideways * (edge.length * inverse_scale_[v]) / (square * square * kSidewaysLength);
            }
            widths[v] = squareRoot(squareRoot(1 / sum));
        });
        return meanWidths(widths, normal);
    }

    // Means of widths over the curve near. From the crest of a blunt bend neither side is sideways, and a fit wider
    // than those beside it would make it straight, with kinks at both ends.
    std::vector<Dual> meanWidths(const std::vector<Dual>& widths, const std::vector<Normal>& normal) const {
        std::vector<Dual> mean = widths;
        forEdgesNear(kMeanWidths, [&](std::uint32_t v, std::span<const std::uint32_t> near) {
            Dual sum = 0, total = 0;
            for (const std::uint32_t e : near) {
                if (!isFacingNeighbour(e, v, kMeanWidths, normal[v])) continue;
                const EdgeSample& edge = edges_[e];
                const Dual weight = kernel(offsetOf(e, v), kMeanWidths) * facing(edge, normal[v]) * edge.length;
                for (const std::uint32_t end : edge.ends) sum = sum + weight / (widths[end] * widths[end]);
                total = total + weight * 2;
            }
            if (total.value > 0) mean[v] = squareRoot(total / sum);
        });
        return mean;
    }

    // The distance along the normal from a vertex to the circle fitted to the curve around it.
    Dual stepOntoCircle(std::uint32_t v, const Normal& normal, std::span<const std::uint32_t> near) const {
        DualVec3 offsets, directions;
        Dual total = 0, along = 0, square = 0;
        for (const std::uint32_t e : near) {
            if (!isFacingNeighbour(e, v, widths_[v].value, normal)) continue;
            const EdgeSample& edge = edges_[e];
            const DualVec3 offset = offsetOf(e, v);
            const Dual face = facing(edge, normal);
            const Dual weight = kernel(offset, widths_[v]) * face * face * levelWeight(offset, normal) * edge.length;
            total = total + weight;
            offsets = offsets + offset * weight;
            directions = directions + edge.direction * weight;
            along = along + weight * dot(offset, edge.direction);
            square = square + weight * dot(offset, offset);
        }
        if (!(total.value > 0)) return 0;
        const DualVec3 a = offsets / total, b = directions / total;
        const Dual opening = along / total - dot(a, b), bend = opening / (square / total - dot(a, a) + kVariance);
        const DualVec3 linear = b - a * bend;
        const Dual half_bend = bend / 2, minus_constant = dot(linear, a) + half_bend * (square / total);
        const Dual slope = dot(linear, linear) + 1e-6;
        const Dual root = squareRoot(slope * slope + half_bend * minus_constant * slope * 4);
        const Dual missed = (1 - dot(b, b) - opening * bend) / kDisagreement;
        const Dual agreed = 1 / (1 + missed * missed * missed * missed);
        const DualVec3 step = linear * (minus_constant * 2 / (slope + root)) * agreed;
        return clamped(dot(step, normal.direction), -kLongestWide, kLongestWide);
    }

    // Moves vertices by heights, in largest spacings, along their normals. Displacements are smoothed along the curve,
    // except for a share `unsmoothed`.
    void move(const std::vector<Normal>& normal, const std::vector<Dual>& height, const std::vector<Dual>& unsmoothed) {
        std::vector<DualVec3> step(size());
        for (std::size_t v = 0; v < size(); ++v)
            step[v] = normal[v].direction * (height[v] * normal[v].trust * params_.spacing);
        const std::vector<DualVec3> smooth = smoothedValues(step, curve_, kStepWidth * params_.spacing);
        for (std::size_t v = 0; v < size(); ++v) step[v] = smooth[v] + (step[v] - smooth[v]) * unsmoothed[v];
        moveWithoutCrossings(curve_, step, params_.spacing * curve_.leastScale());
    }

    BetaCurve& curve_;
    SkinSmoothing params_;
    std::vector<DualVec3> original_;
    std::vector<double> inverse_scale_;
    Vec3 origin_{0, 0, 0};            // world units
    std::vector<DualVec3> position_;  // of vertices, relative to the origin
    std::vector<EdgeSample> edges_;
    std::vector<Dual> widths_;  // of the fit at each vertex
};

}  // namespace

void smoothSkin(BetaCurve& curve, const SkinSmoothing& params) {
    SkinSmoother smoother(curve, params);
    for (int i = 0; i < kNarrowBefore; ++i) smoother.smoothNarrowly();
    for (int pass = 0; pass < params.passes; ++pass) smoother.smoothWidely();
    for (int i = 0; i < kNarrowAfter; ++i) smoother.smoothNarrowly();
    smoother.restoreLongWaves();
}

}  // namespace betamesh
