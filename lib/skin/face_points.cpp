#include "skin/face_points.h"

#include "base/box.h"
#include "base/cell_grid.h"
#include "base/index.h"
#include "base/octaves.h"
#include "base/parallel.h"
#include "exact/neighbour_finder.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace betamesh {

namespace {

// Squared distance of balls, over the square of their radii's sum, from which on they cover nothing of each other.
constexpr double kTangentSquared = 1 - 1e-12;
// Radii: a point closer to a ball's centre is covered by it.
constexpr double kSurelyInside = 1 - 1e-6;

struct Part {
    std::vector<std::uint32_t> count, direction;
    std::vector<Dual> rim_distance;
    std::vector<FacePoints::Contact> contact;
};

// Is there a point so close that a point in the direction `towards` would coincide with it? first: the ball's first.
bool hasPointNear(const Vec3& towards, const std::vector<Vec3>& directions, const Part& part, std::size_t first) {
    for (std::size_t p = first; p < part.direction.size(); ++p) {
        const std::uint32_t d = part.direction[p];
        const Vec3& other =
            d < directions.size() ? directions[d] : part.contact[d - directions.size()].direction.position;
        if ((towards - other).length2() < kMinContactSeparation * kMinContactSeparation) return true;
    }
    return false;
}

// The ball of a row of SnappedParticles; kInvalidIndex if it is not exposed.
std::uint32_t ballOf(const BallBoundary& boundary, std::uint32_t snapped_row) {
    const auto& rows = boundary.snapped_row;
    const auto found = std::lower_bound(rows.begin(), rows.end(), snapped_row);
    return found != rows.end() && *found == snapped_row ? static_cast<std::uint32_t>(found - rows.begin())
                                                        : kInvalidIndex;
}

// Rim distance of a direction from one cap, and its rate. offset: from the ball to the other one, and that one's
// radius, both in radii of the ball.
Dual rimDistance(const DualVec3& direction, const DualVec3& offset, Dual radius) {
    const Dual distance = length(offset), cosine = (distance + (1 - radius * radius) / distance) / 2;
    const Dual sine = squareRoot(1 - cosine * cosine);
    const Dual along = dot(direction, offset) / distance;
    const Dual width = sine.value < kWideCapSine ? sine * sine / kWideCapSine : sine;
    return (cosine - along) / width;
}

// The least rim distance of a direction from the caps of all neighbours, and whose cap that is. Stops at the first one
// that is at most `least`.
std::pair<double, std::uint32_t> nearestCap(const Vec3& direction, const std::vector<Neighbour>& neighbours,
                                            double radius, double least) {
    std::pair<double, std::uint32_t> nearest{kMaxRimDistance, kInvalidIndex};
    for (const Neighbour& n : neighbours) {
        if (nearest.first <= least) break;
        const double sum = radius + n.radius;
        if (n.squaredDistance() > sum * sum * kTangentSquared) continue;
        const double rim_distance =
            rimDistance({direction, Vec3(0)}, {n.offset / radius, Vec3(0)}, n.radius / radius).value;
        if (rim_distance < nearest.first) nearest = {rim_distance, n.particle};
    }
    return nearest;
}

// Is the predicate true of any item? Visits them in strides: neighbours in the list are neighbours in space, and a
// spread-out sample finds a covering ball sooner.
template <typename Is>
bool anyInStrides(std::span<const std::uint32_t> items, const Is& is) {
    const auto stride = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(items.size()))));
    for (std::size_t first = 0; first < stride; ++first)
        for (std::size_t k = first; k < items.size(); k += stride)
            if (is(items[k])) return true;
    return false;
}

// Balls by octaves of their radii, in cells in which those of one octave that are about to touch are neighbours.
class BallsByOctave {
public:
    explicit BallsByOctave(const BallBoundary& boundary) : boundary_(boundary), position_(boundary.position.size()) {
        parallelFor(position_.size(), 4096, [&](std::size_t b) { position_[b] = toDouble(boundary.position[b]); });
        std::vector<double> scale(boundary.radius_of.empty() ? 0 : position_.size());
        for (std::size_t b = 0; b < scale.size(); ++b) scale[b] = boundary.scaleOf(b);
        balls_ = byOctave(allRows(position_.size()), scale);
        for (std::size_t octave = 0; octave < balls_.size(); ++octave)
            cells_.emplace_back(balls_[octave].size(), reach(octave, octave),
                                [&](std::size_t i) -> const Vec3& { return position_[balls_[octave][i]]; });
    }

    const std::vector<Vec3>& position() const { return position_; }

    /// Calls visit(balls of a cell, balls of all octaves that may touch one of these or are about to) for each cell, in
    /// parallel. Every thread calls its own copy of `visit`.
    template <typename Visit>
    void forCellsAndNeighbours(const Visit& visit) const {
        for (std::size_t octave = 0; octave < balls_.size(); ++octave)
            parallelRanges(cells_[octave].cells(), 16, [&](std::size_t first, std::size_t last) {
                Visit own(visit);
                std::vector<std::uint32_t> balls, around;
                for (auto cell = static_cast<std::uint32_t>(first); cell < last; ++cell) {
                    balls.clear();
                    Box box;
                    for (const std::uint32_t row : cells_[octave].rowsOf(cell)) {
                        balls.push_back(balls_[octave][row]);
                        box.extendBy(position_[balls.back()]);
                    }
                    around.clear();
                    for (std::size_t other = 0; other < balls_.size(); ++other)
                        addNear(box, reach(octave, other), other, around);
                    own(balls, around);
                }
            });
    }

private:
    // The distance within which balls of two octaves touch or are about to, quanta.
    double reach(std::size_t a, std::size_t b) const {
        return static_cast<double>(boundary_.radius) * (largestOfOctave(a) + largestOfOctave(b)) *
               (1 + kContactGap / 2);
    }
    void addNear(const Box& box, double reach, std::size_t octave, std::vector<std::uint32_t>& near) const {
        cells_[octave].forRowsIn(box.min - Vec3(reach), box.max + Vec3(reach), [&](std::uint32_t row) {
            const std::uint32_t ball = balls_[octave][row];
            if (squaredDistance(box, position_[ball]) < reach * reach) near.push_back(ball);
        });
    }

    const BallBoundary& boundary_;
    std::vector<Vec3> position_;                     // of all balls, quanta
    std::vector<std::vector<std::uint32_t>> balls_;  // of each octave
    std::vector<CellGrid> cells_;                    // of each octave
};

// For each ball the others that are about to touch it in a point that no third ball covers, ascending.
std::vector<std::vector<std::uint32_t>> ballsNearContact(const BallBoundary& boundary) {
    const BallsByOctave by_octave(boundary);
    const std::vector<Vec3>& position = by_octave.position();
    std::vector<std::vector<std::uint32_t>> near(boundary.position.size());
    struct Buffers {
        std::vector<double> x, y, z, squared, radius;
        std::vector<std::uint32_t> found;
    };
    by_octave.forCellsAndNeighbours([&, buffers = Buffers()](const auto& balls, const auto& around) mutable {
        auto& [x, y, z, squared, radius_buffer, found] = buffers;
        std::vector<double>& radius = radius_buffer;
        const std::size_t n = around.size();
        for (std::vector<double>* column : {&x, &y, &z, &squared, &radius}) column->resize(n);
        for (std::size_t k = 0; k < n; ++k) {
            const Vec3& p = position[around[k]];
            x[k] = p.x, y[k] = p.y, z[k] = p.z;
            radius[k] = static_cast<double>(boundary.radiusOf(around[k]));
        }
        found.resize(n + 1);
        for (const std::uint32_t row : balls) {
            const Vec3 here = position[row];
            const auto own = static_cast<double>(boundary.radiusOf(row));
            squaredDistances(Box(here), x.data(), y.data(), z.data(), n, squared.data());
            std::size_t count = 0;
            for (std::uint32_t k = 0; k < n; ++k) {
                const double reach = (own + radius[k]) * (1 + kContactGap / 2);
                found[count] = k;
                count += squared[k] < reach * reach;
            }
            const auto within_reach = std::span<const std::uint32_t>(found).first(count);
            for (const std::uint32_t other : within_reach) {
                const double sum = own + radius[other], reach_here = sum + kContactGap * std::min(own, radius[other]);
                if (squared[other] <= sum * sum || squared[other] >= reach_here * reach_here) continue;
                const Vec3 offset = position[around[other]] - here, contact = here + offset * (own / offset.length());
                const auto isCovering = [&](std::uint32_t k) {
                    const double inside = kSurelyInside * radius[k];
                    return (position[around[k]] - contact).length2() < inside * inside;
                };
                if (!anyInStrides(within_reach, isCovering)) near[row].push_back(around[other]);
            }
            std::sort(near[row].begin(), near[row].end());
        }
    });
    return near;
}

}  // namespace

FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary,
                      const std::vector<DualVec3>& balls, Icosphere directions) {
    FacePoints points;
    points.directions = std::move(directions);
    const std::vector<Vec3>& fixed = points.directions.position;

    const auto offsetTo = [&](std::size_t b, std::uint32_t other) {
        return (balls[other] - balls[b]) / boundary.worldRadiusOf(b);
    };
    const auto ratioTo = [&](std::size_t b, std::uint32_t other) {
        return boundary.worldRadiusOf(other) / boundary.worldRadiusOf(b);
    };
    const std::vector<std::vector<std::uint32_t>> near = ballsNearContact(boundary);
    auto parts = parallelParts<Part>(balls.size(), kBallsPerTask, [&](std::size_t begin, std::size_t end, Part& part) {
        NeighbourFinder finder(particles);
        std::vector<Neighbour> neighbours;
        for (std::size_t b = begin; b < end; ++b) {
            const std::size_t before = part.direction.size();
            const auto add = [&](std::uint32_t d, const DualVec3& outwards, double rim_distance,
                                 std::uint32_t nearest) {
                part.direction.push_back(d);
                part.rim_distance.push_back(nearest == kInvalidIndex
                                                ? Dual(rim_distance)
                                                : rimDistance(outwards, offsetTo(b, nearest), ratioTo(b, nearest)));
            };
            for (const auto& [d, nearest, rim_distance] : boundary.exposed[b])
                add(d, {fixed[d], Vec3(0)}, rim_distance, nearest);
            if (!near[b].empty()) finder.find(boundary.snapped_row[b], neighbours);
            for (const std::uint32_t other : near[b]) {
                const DualVec3 offset = offsetTo(b, other);
                const Dual distance = length(offset);
                const DualVec3 towards = offset / distance;
                const auto [rim_distance, nearest] = nearestCap(
                    towards.position, neighbours, static_cast<double>(boundary.radiusOf(b)), kMinContactSeparation);
                if (!(rim_distance > kMinContactSeparation) || hasPointNear(towards.position, fixed, part, before))
                    continue;
                add(static_cast<std::uint32_t>(fixed.size() + part.contact.size()), towards, rim_distance,
                    ballOf(boundary, nearest));
                const Dual ratio = ratioTo(b, other), smaller = ratio.value < 1 ? ratio : Dual(1);
                part.contact.push_back({towards, 1 - (distance - (1 + ratio)) / (smaller * kContactGap)});
            }
            part.count.push_back(static_cast<std::uint32_t>(part.direction.size() - before));
        }
    });

    std::vector<std::uint32_t> contacts;  // before each part
    for (const Part& part : parts) contacts.push_back(static_cast<std::uint32_t>(part.contact.size()));
    contacts = exclusiveScan(contacts);
    parallelFor(parts.size(), 4, [&](std::size_t p) {
        for (std::uint32_t& d : parts[p].direction) d += d < fixed.size() ? 0 : contacts[p];
    });
    points.begin = exclusiveScan(concatenate(parts, &Part::count));
    points.direction = concatenate(parts, &Part::direction);
    points.rim_distance = concatenate(parts, &Part::rim_distance);
    points.contact = concatenate(parts, &Part::contact);
    return points;
}

}  // namespace betamesh
