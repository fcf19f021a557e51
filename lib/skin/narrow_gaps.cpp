#include "skin/narrow_gaps.h"

#include "base/angles.h"
#include "base/cell_grid.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

namespace betamesh {

namespace {

// A ray from a point of the boundary, on one or two spheres, away from their centres. The power to these balls at a
// distance t along it is t² + 2 t height.
struct Ray {
    Vec3 origin, direction;
    std::array<std::uint32_t, 2> balls;  // the same twice where it is one
    double height;                       // of the origin over the centres
    double share;                        // 0 for a point that has just appeared, 1 for a permanent one
    double weight;                       // at the origin, as that of outer samples

    bool isOf(std::uint32_t ball) const { return ball == balls[0] || ball == balls[1]; }
};

// A sample at the end of a ray, with the square radius of the ball that rolls there, both in world units; negative
// where it has hardly any influence.
struct GapSample {
    Vec3 point;
    double weight, square_radius;
    std::uint32_t ball;
};

// Rays from the points inside arcs and on circles, then from the middles of short arcs, then from points inside faces.
// None from vertices: where four balls meet, vertices with rays in other directions replace them.
class Rays {
public:
    Rays(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const ArcNetwork& network,
         const FacePoints& points, double spacing)
        : boundary_(boundary),
          balls_(balls),
          network_(network),
          points_(points),
          on_lines_(unfadedPoints(network)),
          share_(network.point.size(), 1),
          weight_(weightsOfPoints(boundary, network, on_lines_, spacing)),
          line_(network.point.size()),
          ball_(points.direction.size()),
          spacing_(spacing) {
        for (const FadingVertex& fading : network.fading) share_[fading.vertex] = static_cast<float>(fading.fade.value);
        const auto set = [](std::vector<std::uint32_t>& values, std::uint32_t begin, std::uint32_t end,
                            std::size_t to) {
            std::fill(values.begin() + begin, values.begin() + end, static_cast<std::uint32_t>(to));
        };
        for (std::size_t a = 0; a < arcs(); ++a) set(line_, network.arc_begin[a], network.arc_begin[a + 1], a);
        for (std::size_t k = 0; k + 1 < network.circle_begin.size(); ++k)
            set(line_, network.circle_begin[k], network.circle_begin[k + 1], arcs() + k);
        for (std::size_t b = 0; b < balls.size(); ++b) set(ball_, points.begin[b], points.begin[b + 1], b);
        const double radius = boundary.worldRadius() / spacing;
        area_ = 4 * std::numbers::pi * radius * radius / static_cast<double>(points.directions.position.size());
    }

    std::size_t size() const { return onLines() + arcs() + ball_.size(); }
    Ray operator[](std::size_t i) const {
        if (i < onLines()) {
            const std::size_t p = network_.vertices + i;
            return onLine(line_[p], on_lines_[p].position, share_[p], weight_[p]);
        }
        i -= onLines();
        return i < arcs() ? inMiddle(i) : insideFace(static_cast<std::uint32_t>(i - arcs()));
    }

private:
    std::size_t onLines() const { return on_lines_.size() - network_.vertices; }
    std::size_t arcs() const { return network_.arc_start.size(); }
    Ray onLine(std::size_t line, const Vec3& origin, double share, double weight) const {
        const std::array<std::uint32_t, 2>& balls = network_.line[line].balls;
        const Vec3 from = balls_[balls[0]].position, outwards = origin - from, axis = axisOf(balls);
        const Vec3 direction = (outwards - axis * dot(axis, outwards)).normalized();
        return {origin, direction, balls, dot(direction, outwards), share, weight};
    }
    Ray inMiddle(std::size_t arc) const {
        const std::array<std::uint32_t, 2>& balls = network_.line[arc].balls;
        const Vec3 from = balls_[balls[0]].position, axis = axisOf(balls);
        const Vec3 to_start = network_.point[network_.arc_start[arc] / 3].position - from;
        const Vec3 along = axis * dot(axis, to_start), radius = to_start - along;
        const double angle = network_.arc_angle[arc].value;
        const auto [sine, cosine] = sineCosine(angle / 2);
        const Vec3 to_middle = radius * cosine + cross(axis, radius) * sine;
        const double length = network_.line[arc].length.value / (spacing_ * network_.scaleOfLine(arc, boundary_));
        const double share =
            smoothStep(angle / kFullArc).value * (1 - smoothStep((angle - kLongArc) / (kLongestArc - kLongArc)).value);
        return onLine(arc, from + along + to_middle, share, length / 2);
    }
    Vec3 axisOf(const std::array<std::uint32_t, 2>& balls) const {
        return (balls_[balls[1]].position - balls_[balls[0]].position).normalized();
    }
    Ray insideFace(std::uint32_t p) const {
        const std::uint32_t ball = ball_[p];
        const double radius = boundary_.worldRadiusOf(ball).value;
        const Vec3 direction = points_.outwards(p).position;
        const double share = points_.contactOf(p) ? 0 : smoothStep(points_.rim_distance[p] / kOuterFadeWidth).value;
        return {balls_[ball].position + direction * radius, direction, {ball, ball}, radius, share, area_ * share};
    }

    const BallBoundary& boundary_;
    const std::vector<DualVec3>& balls_;
    const ArcNetwork& network_;
    const FacePoints& points_;
    std::vector<DualVec3> on_lines_;     // points of the network, those that fade in in full
    std::vector<float> share_, weight_;  // of these
    std::vector<std::uint32_t> line_;    // of these; undefined for vertices
    std::vector<std::uint32_t> ball_;    // of each point inside a face
    double spacing_;
    double area_;  // of such a point, square spacings of the largest ball
};

// Finds where rays end half-way to an opposite ball.
class GapFinder {
public:
    GapFinder(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const SkinLengths& lengths,
              double spacing)
        : boundary_(boundary), balls_(balls), rolling_(lengths.rolling() * spacing), spacing_(spacing) {}

    // near: the balls within two outer radii of the ray's own
    std::optional<GapSample> end(const Ray& ray, std::span<const std::uint32_t> near) const {
        const std::uint32_t ball = ray.balls[0];
        const double height = ray.height, own_square = squareRolling(ball);
        double length = std::sqrt(height * height + own_square) - height;  // to the outer boundary
        std::uint32_t other = kInvalidIndex;
        for (const std::uint32_t b : near) {
            if (ray.isOf(b)) continue;
            const Vec3 offset = ray.origin - balls_[b].position;
            const double power = dot(offset, offset) - squareRadius(b);
            const double approach = height - dot(ray.direction, offset);
            if (power > 0 && power < 2 * length * approach) length = power / (2 * approach), other = b;
        }
        if (other == kInvalidIndex) return std::nullopt;
        const double power = length * (length + 2 * height);  // to the own balls and the other one
        const double square_outer = std::min(own_square, squareRolling(other));
        const double part = std::min(std::sqrt(power / square_outer), 1.0);  // of the rolling ball's radius
        const double radius = std::sqrt(squareRadius(ball)), unit = spacing_ * boundary_.scaleOf(ball);
        double is_gap = ray.share * smoothStep(height / (kFullHeight * radius)).value *
                        smoothStep((std::sqrt(power) / unit - kTightGap) / (kWideGap - kTightGap)).value;
        if (!(is_gap > 0)) return std::nullopt;
        const Vec3 end = ray.origin + ray.direction * length;
        is_gap *= opposition(end, ray.direction, std::sqrt(power), unit, near);
        if (!(is_gap > 0)) return std::nullopt;
        const double reduction = 1 - kGapEnd * smoothStep((part - kGapEndBegins) / (1 - kGapEndBegins)).value;
        const double widening = 1 + length / radius;
        // A ball of this square radius is out of reach of every vertex that another one reaches.
        const double reach_fade = kReachFade * unit, none = -reach_fade * (2 * std::sqrt(own_square) + reach_fade);
        const double square = is_gap * reduction * part * part * square_outer + (1 - is_gap) * none;
        return GapSample{end, ray.weight * widening * widening, square, ball};
    }

private:
    double squareRadius(std::uint32_t ball) const {
        const double radius = boundary_.worldRadiusOf(ball).value;
        return radius * radius;
    }
    double squareRolling(std::uint32_t ball) const {
        const double radius = rolling_ * boundary_.scaleOf(ball);
        return radius * radius;
    }
    // 0 … 1: whether some ball that is hardly farther away than the nearest is opposite.
    // root: of the power of the nearest; unit: particle spacing there
    double opposition(const Vec3& point, const Vec3& direction, double root, double unit,
                      std::span<const std::uint32_t> near) const {
        double most = 0;
        for (const std::uint32_t b : near) {
            const Vec3 offset = point - balls_[b].position;
            const double square = dot(offset, offset), along = dot(direction, offset) / std::sqrt(square);
            if (!(along < kOppositeBegins)) continue;
            const double excess = std::sqrt(std::max(0.0, square - squareRadius(b))) - root;
            most = std::max(most, smoothStep((along - kOppositeBegins) / (kOppositeFull - kOppositeBegins)).value *
                                      (1 - smoothStep(excess / (kOppositeExcess * unit)).value));
        }
        return most;
    }

    const BallBoundary& boundary_;
    const std::vector<DualVec3>& balls_;
    double rolling_, spacing_;
};

}  // namespace

void addNarrowGaps(const BallBoundary& boundary, const std::vector<DualVec3>& balls, const ArcNetwork& network,
                   const FacePoints& points, const SkinLengths& lengths, double spacing, OuterSamples& samples) {
    const Rays rays(boundary, balls, network, points, spacing);
    const GapFinder finder(boundary, balls, lengths, spacing);
    const double reach = (2 * lengths.outer() - lengths.joining) * spacing;
    const auto centreOf = [&](std::size_t b) { return balls[b].position; };
    const CellGrid origins(rays.size(), reach / 2, [&](std::size_t i) { return rays[i].origin; });
    const CellGrid around(balls.size(), reach / 2, centreOf);
    std::vector<std::vector<GapSample>> found(origins.cells());
    forCellsAndNeighbours(reach, origins, around, centreOf,
                          [&](std::uint32_t cell, std::span<const std::uint32_t> near) {
                              for (const std::uint32_t i : origins.rowsOf(cell))
                                  if (const std::optional<GapSample> sample = finder.end(rays[i], near))
                                      found[cell].push_back(*sample);
                          });
    const bool have_scales = !samples.scale.empty(), have_growth = !samples.growth.empty();
    for (const std::vector<GapSample>& here : found)
        for (const GapSample& sample : here) {
            const double scale = boundary.scaleOf(sample.ball), unit = scale * spacing;
            const double square = sample.square_radius / (unit * unit);
            samples.point.push_back({sample.point, balls[sample.ball].velocity});
            samples.weight.push_back(static_cast<float>(sample.weight));
            samples.squared_offset.push_back(static_cast<float>(lengths.rolling() * lengths.rolling() - square));
            samples.exposure.push_back(0);
            if (have_scales) samples.scale.push_back(static_cast<float>(scale));
            if (have_growth) samples.growth.push_back(0);
        }
}

}  // namespace betamesh
