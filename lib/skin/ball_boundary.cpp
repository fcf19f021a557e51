#include "skin/ball_boundary.h"

#include "base/icosphere.h"
#include "base/index.h"
#include "base/parallel.h"
#include "exact/neighbour_finder.h"
#include "exact/predicates.h"
#include "mesh/mesh_edges.h"
#include "skin/exposed_region.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace betamesh {

std::uint32_t reverseSide(const BallBoundary& boundary, std::uint32_t v) {
    const auto reversed = [&](std::size_t other) {
        const Triangle &a = boundary.triangle[v], &b = boundary.triangle[other];
        return a[0] == b[0] && a[1] == b[2] && a[2] == b[1];
    };
    if (v > 0 && reversed(v - 1)) return v - 1;
    if (v + 1 < boundary.triangle.size() && reversed(v + 1)) return v + 1;
    return v;
}

std::int64_t eulerCharacteristic(const BallBoundary& boundary) {
    const auto vertices = static_cast<std::int64_t>(boundary.vertex.size());
    std::int64_t faces = 0;  // sum of Euler characteristics: a face with c cycles is a sphere with c holes
    for (std::size_t f = 0; f < boundary.face.size(); ++f)
        faces += 2 - static_cast<std::int64_t>(boundary.face[f].size());
    return vertices - 3 * vertices / 2 + faces;
}

namespace {

// What one task finds. Balls are given by rows of SnappedParticles until all exposed balls are known.
struct Parts {
    std::vector<Triangle> triangle;
    std::vector<Vec3> vertex;
    std::vector<std::array<std::uint32_t, 2>> circle;
    std::vector<std::uint32_t> isolated;
    std::vector<std::uint32_t> candidate, directions;  // exposure candidates, and their numbers of exposed directions
    std::vector<ExposedDirection> exposed;
};

// Is the point where the spheres of particles i, j and k meet in no other ball? last: index of the neighbour that was
// inside last time, which often is again.
template <typename Balls>
bool isEmpty(const Balls& balls, int side, const ExposedRegion& region, std::uint32_t j, std::uint32_t k,
             std::size_t& last) {
    const Vec3 centre = balls.centre(side);
    const std::vector<Neighbour>& neighbours = region.neighbours();
    const auto isInside = [&](const Neighbour& n) {
        return n.particle != j && n.particle != k && balls.contains(centre, side, n);
    };
    if (last < neighbours.size() && isInside(neighbours[last])) return false;
    for (std::size_t n = 0; n < neighbours.size(); ++n)
        if (isInside(neighbours[n])) {
            last = n;
            return false;
        }
    return true;
}

// Is the whole circle in which the sphere of `other` meets the one at the origin exposed?
template <typename Balls>
bool isFullCircle(const Vec3& origin, const Neighbour& other, const std::vector<Neighbour>& neighbours,
                  std::int64_t radius, std::int64_t largest) {
    for (const Neighbour& n : neighbours) {
        if (n.particle == other.particle) continue;
        if (Balls(origin, other, n, static_cast<double>(radius), static_cast<double>(largest)).exist()) return false;
        if (coversCircle(other.ball(), n.ball(), radius)) return false;
    }
    return true;
}

// Is the ball inside that of a neighbour? Then p = |u|² + r² - r_n² is less than with the spheres touching inside.
bool isHidden(const std::vector<Neighbour>& neighbours, std::int64_t radius) {
    const auto twice = static_cast<double>(2 * radius), square = twice * static_cast<double>(radius);
    return std::any_of(neighbours.begin(), neighbours.end(),
                       [&](const Neighbour& n) { return n.power < square - twice * n.radius; });
}

// A neighbour that may share an exposed circle with the ball.
struct Partner {
    Neighbour ball;
    bool is_crossed = false;  // by a third sphere
};

// Adds the vertices and full circles of which i is the lowest ball.
template <typename Balls>
void addBall(const SnappedParticles& particles, const std::vector<bool>& is_candidate, std::uint32_t i,
             const std::vector<Neighbour>& neighbours, const ExposedRegion& region, std::vector<Partner>& partners,
             Parts& out) {
    if (neighbours.empty()) {
        out.isolated.push_back(i);
        return;
    }
    const std::int64_t radius = particles.radiusOf(i);
    partners.clear();
    for (const std::uint32_t row : region.bounding())
        if (const Neighbour& n = neighbours[row]; n.particle > i && is_candidate[n.particle]) partners.push_back({n});

    std::size_t last = 0;
    const Vec3 origin = toDouble(particles.position[i]);
    for (std::size_t a = 0; a < partners.size(); ++a) {
        const Neighbour& j = partners[a].ball;
        for (std::size_t b = a + 1; b < partners.size(); ++b) {
            const Neighbour& k = partners[b].ball;
            const Balls balls(origin, j, k, static_cast<double>(radius), static_cast<double>(particles.radius));
            if (!balls.exist()) continue;
            partners[a].is_crossed = partners[b].is_crossed = true;
            for (const int side : {1, -1}) {
                if (!isEmpty(balls, side, region, j.particle, k.particle, last)) continue;
                out.triangle.push_back(side > 0 ? Triangle{i, j.particle, k.particle}
                                                : Triangle{i, k.particle, j.particle});
                out.vertex.push_back((origin + balls.centre(side)) * particles.quantum);
            }
        }
        if (!partners[a].is_crossed && isFullCircle<Balls>(origin, j, neighbours, radius, particles.radius))
            out.circle.push_back({i, j.particle});
    }
}

// Is a particle in a dense cell surely covered? Nearly always its nearest neighbours alone cover it.
bool isCoveredInDenseCell(std::uint32_t i, std::int64_t radius, NeighbourFinder& finder,
                          std::vector<Neighbour>& neighbours, ExposedRegion& region) {
    const auto isCovered = [&] { return region.isCoveredBy(neighbours, radius); };
    return (finder.findSomeInDenseCell(i, neighbours) && isCovered()) ||
           (finder.findInDenseCell(i, neighbours) && isCovered());
}

template <typename Balls>
std::vector<Parts> exposedParts(const SnappedParticles& particles, const std::vector<std::uint32_t>& exposed,
                                const std::vector<Vec3>& directions) {
    std::vector<bool> is_candidate(particles.size(), false);
    for (const std::uint32_t i : exposed) is_candidate[i] = true;
    return parallelParts<Parts>(exposed.size(), kBallsPerTask, [&](std::size_t begin, std::size_t end, Parts& part) {
        NeighbourFinder finder(particles);
        ExposedRegion region;
        ExposedDirections exposed_directions(directions);
        std::vector<Neighbour> neighbours;
        std::vector<Partner> partners;
        bool was_covered = false;
        for (std::size_t s = begin; s < end; ++s) {
            const std::int64_t radius = particles.radiusOf(exposed[s]);
            if (isCoveredInDenseCell(exposed[s], radius, finder, neighbours, region)) continue;
            finder.find(exposed[s], neighbours);
            if (particles.size_classes && isHidden(neighbours, radius)) continue;
            if (was_covered) {  // then this one probably is, too
                was_covered = region.isCoveredBy(neighbours, radius);
            } else {
                region.construct(neighbours, radius);
                was_covered = region.empty();
            }
            if (was_covered) continue;
            addBall<Balls>(particles, is_candidate, exposed[s], neighbours, region, partners, part);
            if (directions.empty()) continue;
            const std::size_t before = part.exposed.size();
            exposed_directions.find(region, neighbours, radius, part.exposed);
            part.candidate.push_back(exposed[s]);
            part.directions.push_back(static_cast<std::uint32_t>(part.exposed.size() - before));
        }
    });
}

// The exposed directions of each ball. ball: of each row of SnappedParticles, or kInvalidIndex.
CompressedRows<ExposedDirection> exposedDirectionsOf(const std::vector<Parts>& parts,
                                                     const std::vector<std::uint32_t>& ball, std::size_t balls) {
    std::vector<std::uint32_t> count(balls, 0);
    for (const Parts& part : parts)
        for (std::size_t k = 0; k < part.candidate.size(); ++k)
            if (const std::uint32_t b = ball[part.candidate[k]]; b != kInvalidIndex) count[b] = part.directions[k];
    CompressedRows<ExposedDirection> exposed;
    exposed.begin = exclusiveScan(count);
    firstTouchResize(exposed.item, exposed.begin.back());
    parallelFor(parts.size(), 4, [&](std::size_t p) {
        const ExposedDirection* from = parts[p].exposed.data();
        for (std::size_t k = 0; k < parts[p].candidate.size(); from += parts[p].directions[k++]) {
            const std::uint32_t b = ball[parts[p].candidate[k]];
            if (b == kInvalidIndex) continue;
            std::copy_n(from, parts[p].directions[k], exposed[b].begin());
            for (ExposedDirection& direction : exposed[b])
                if (direction.nearest != kInvalidIndex) direction.nearest = ball[direction.nearest];
        }
    });
    return exposed;
}

// Joins the parts and numbers the exposed balls.
BallBoundary assemble(const SnappedParticles& particles, const std::vector<Parts>& parts) {
    BallBoundary boundary;
    boundary.quantum = particles.quantum;
    boundary.radius = particles.radius;
    boundary.triangle = concatenate(parts, &Parts::triangle);
    boundary.vertex = concatenate(parts, &Parts::vertex);
    boundary.circle = concatenate(parts, &Parts::circle);
    boundary.isolated = concatenate(parts, &Parts::isolated);
    std::vector<std::uint32_t> ball(particles.size(), kInvalidIndex);
    const auto forEachBallIndex = [&](const auto& visit) {
        constexpr std::size_t kGrain = 4096;
        parallelFor(boundary.triangle.size(), kGrain, [&](std::size_t t) {
            for (std::uint32_t& p : boundary.triangle[t]) visit(p);
        });
        parallelFor(boundary.circle.size(), kGrain, [&](std::size_t c) {
            for (std::uint32_t& p : boundary.circle[c]) visit(p);
        });
        parallelFor(boundary.isolated.size(), kGrain, [&](std::size_t b) { visit(boundary.isolated[b]); });
    };
    forEachBallIndex([&](std::uint32_t p) { std::atomic_ref(ball[p]).store(0, std::memory_order_relaxed); });
    boundary.snapped_row = indicesWhere(ball.size(), [&](std::uint32_t p) { return ball[p] != kInvalidIndex; });
    firstTouchResize(boundary.position, boundary.snapped_row.size());
    firstTouchResize(boundary.row, boundary.snapped_row.size());
    if (!particles.radius_of.empty()) boundary.radius_of.resize(boundary.snapped_row.size());
    parallelFor(boundary.snapped_row.size(), 4096, [&](std::size_t b) {
        const std::uint32_t p = boundary.snapped_row[b];
        ball[p] = static_cast<std::uint32_t>(b);
        boundary.position[b] = particles.position[p];
        boundary.row[b] = particles.row[p];
        if (!particles.radius_of.empty()) boundary.radius_of[b] = particles.radius_of[p];
    });
    forEachBallIndex([&](std::uint32_t& p) { p = ball[p]; });
    boundary.exposed = exposedDirectionsOf(parts, ball, boundary.position.size());
    return boundary;
}

// Each side of a triangle, between balls low < high, is an end of an arc on their circle. Going counter-clockwise round
// the axis from low to high, the arc begins there if the side runs from low to high, otherwise it ends there.
using ArcEnd = TriangleSide;
bool begins(const ArcEnd& end) { return end.direction > 0; }

// Sorts the ends on one circle counter-clockwise by the direction of their apex particles; at equal directions an end
// comes before a beginning.
// source  §2 of the paper's Algorithm 3, with exact signs
void sortRoundAxis(std::span<ArcEnd> ends, const BallBoundary& boundary) {
    const Vec3i origin = boundary.position[ends[0].low];
    const Vec3i axis = boundary.position[ends[0].high] - origin;
    const auto apex = [&](const ArcEnd& end) {
        const std::uint32_t opposite = previousInTriangle(end.side);
        return boundary.position[boundary.triangle[opposite / 3][opposite % 3]] - origin;
    };
    const Vec3i start = apex(ends[0]);
    const auto quadrant = [&](const Vec3i& a) {  // 0: along start, 1: less than half a turn on, 2: opposite, 3: more
        const int t = turn(axis, start, a);
        return t > 0 ? 1 : t < 0 ? 3 : sameSide(axis, start, a) > 0 ? 0 : 2;
    };
    std::sort(ends.begin(), ends.end(), [&](const ArcEnd& p, const ArcEnd& q) {
        const Vec3i a = apex(p), b = apex(q);
        const int quadrant_a = quadrant(a), quadrant_b = quadrant(b);
        if (quadrant_a != quadrant_b) return quadrant_a < quadrant_b;
        if (const int t = turn(axis, a, b)) return t > 0;
        if (begins(p) != begins(q)) return begins(q);
        return p.side < q.side;
    });
}

// Pairs the two ends of every arc on one circle. Returns what is wrong if that is impossible.
std::optional<UnpairedEdge> pairEndsOnCircle(std::span<ArcEnd> ends, BallBoundary& boundary) {
    const std::uint32_t low = boundary.row[ends[0].low], high = boundary.row[ends[0].high];
    std::ptrdiff_t surplus = 0;
    for (const ArcEnd& end : ends) surplus += end.direction;
    if (surplus != 0) {
        constexpr std::string_view kFault = "is used more often than its opposite";
        return surplus > 0 ? UnpairedEdge{low, high, kFault} : UnpairedEdge{high, low, kFault};
    }
    if (ends.size() > 2) sortRoundAxis(ends, boundary);
    for (std::size_t a = 0; a < ends.size(); ++a) {
        if (!begins(ends[a])) continue;
        const ArcEnd& other = ends[(a + 1) % ends.size()];
        if (begins(other)) return UnpairedEdge{low, high, "has triangles that overlap instead of pairing up"};
        boundary.twin[ends[a].side] = other.side;
        boundary.twin[other.side] = ends[a].side;
    }
    return std::nullopt;
}

// Pairs the ends on all circles. Returns the first edge that cannot be paired, if any.
std::optional<UnpairedEdge> pairArcEnds(BallBoundary& boundary) {
    constexpr std::size_t kEndsPerTask = 4096;  // at least
    std::vector<ArcEnd> ends = sortedSides(boundary.triangle);
    firstTouchResize(boundary.twin, ends.size());
    std::vector<std::size_t> task_begin{0};
    while (task_begin.back() + kEndsPerTask < ends.size())
        task_begin.push_back(endOfEdge(ends, task_begin.back() + kEndsPerTask));
    task_begin.push_back(ends.size());
    std::vector<std::optional<UnpairedEdge>> unpaired(task_begin.size() - 1);
    parallelFor(unpaired.size(), 1, [&](std::size_t task) {
        const auto own = std::span(ends).first(task_begin[task + 1]);
        for (std::size_t begin = task_begin[task], end; begin < own.size() && !unpaired[task]; begin = end) {
            end = endOfEdge(own, begin);
            unpaired[task] = pairEndsOnCircle(own.subspan(begin, end - begin), boundary);
        }
    });
    const auto first =
        std::find_if(unpaired.begin(), unpaired.end(), [](const auto& edge) { return edge.has_value(); });
    return first == unpaired.end() ? std::nullopt : *first;
}

// Traces the cycles of all faces: on ball i, from half-edge i -> j along the arc that leaves on the side of the
// triangle's third particle to the far end of that arc.
void traceCycles(BallBoundary& boundary) {
    std::vector<bool> visited(boundary.twin.size(), false);
    for (std::uint32_t first = 0; first < visited.size(); ++first) {
        if (visited[first]) continue;
        for (std::uint32_t h = first; !visited[h]; h = boundary.twin[previousInTriangle(h)]) {
            visited[h] = true;
            boundary.cycle.item.push_back(h);
        }
        boundary.cycle.begin.push_back(static_cast<std::uint32_t>(boundary.cycle.item.size()));
    }
}

// Sets twins and cycles. Returns what is wrong if that is impossible.
std::optional<UnpairedEdge> traceArcs(BallBoundary& boundary) {
    const auto unpaired = pairArcEnds(boundary);
    if (!unpaired) traceCycles(boundary);
    return unpaired;
}

// A ball with an exposed point but without triangle or circle, if any. Where all triangles of a lattice were rejected
// alike, pairing ends finds nothing to object to.
std::optional<UnpairedEdge> ballWithoutTriangle(const SnappedParticles& particles,
                                                const std::vector<std::uint32_t>& exposed,
                                                const BallBoundary& boundary) {
    std::vector<bool> is_in_boundary(particles.size(), false);
    for (const std::uint32_t p : boundary.snapped_row) is_in_boundary[p] = true;
    NeighbourFinder finder(particles);
    std::vector<Neighbour> neighbours;
    const Icosphere sphere = icosphere(8);
    const double reach = 2 * static_cast<double>(particles.radius) * (1 + 1e-6);
    for (std::size_t s = 0; s < exposed.size(); ++s) {
        if (is_in_boundary[exposed[s]]) continue;
        finder.find(exposed[s], neighbours);
        for (const Vec3& direction : sphere.position) {
            const auto covers = [&](const Neighbour& n) { return reach * dot(direction, n.offset) >= n.power; };
            if (std::any_of(neighbours.begin(), neighbours.end(), covers)) continue;
            const auto nearest = std::min_element(neighbours.begin(), neighbours.end(),
                                                  [](const auto& a, const auto& b) { return a.power < b.power; });
            return UnpairedEdge{particles.row[exposed[s]], particles.row[nearest->particle],
                                "has no triangle, though the first particle's ball is exposed"};
        }
    }
    return std::nullopt;
}

}  // namespace

BallBoundary ballBoundary(const SnappedParticles& particles, const std::vector<std::uint32_t>& exposed,
                          const std::vector<Vec3>& directions, ArcTracing arcs) {
    BallBoundary boundary = assemble(particles, exposedParts<ExactBalls>(particles, exposed, directions));
    if (arcs == ArcTracing::traced && traceArcs(boundary))
        throw std::logic_error("exact predicates left an edge unpaired");
    return boundary;
}

std::variant<BallBoundary, UnpairedEdge> ballBoundaryInFloats(const SnappedParticles& particles,
                                                              const std::vector<std::uint32_t>& exposed,
                                                              const std::vector<Vec3>& directions) {
    BallBoundary boundary = assemble(particles, exposedParts<FloatBalls>(particles, exposed, directions));
    if (const auto unpaired = traceArcs(boundary)) return *unpaired;
    if (const auto missing = ballWithoutTriangle(particles, exposed, boundary)) return *missing;
    return boundary;
}

}  // namespace betamesh
