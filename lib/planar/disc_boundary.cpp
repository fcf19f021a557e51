
#include "planar/disc_boundary.h"

#include "base/angles.h"
#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "exact/neighbour_finder.h"
#include "exact/plane_predicates.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

constexpr double kNearlyZero = 1e-3;  // radians, far above rounding
constexpr std::size_t kParticlesPerTask = 256;

std::int64_t dotXY(const Vec3i& a, const Vec3i& b) { return a.x * b.x + a.y * b.y; }

// A disc as a neighbour of another one.
Neighbour neighbourOf(const DiscBoundary& boundary, std::uint32_t disc, std::uint32_t other) {
    const Vec3 offset = toDouble(boundary.position[other] - boundary.position[disc]);
    const std::int64_t own = boundary.radiusOf(disc), radius = boundary.radiusOf(other);
    return {offset, dot(offset, offset) + static_cast<double>(own * own - radius * radius), other,
            static_cast<std::int32_t>(radius)};
}

}  // namespace

std::vector<double> DiscBoundary::scales() const {
    std::vector<double> scale(radius_of.size());
    for (std::size_t d = 0; d < scale.size(); ++d) scale[d] = scaleOf(d);
    return scale;
}

double DiscBoundary::leastScale() const {
    double least = 1;
    for (std::size_t d = 0; d < radius_of.size(); ++d) least = std::min(least, scaleOf(d));
    return least;
}

double arcAngle(const DiscBoundary& boundary, std::uint32_t v) {
    const std::uint32_t before = boundary.segment[v][0], disc = boundary.segment[v][1],
                        after = boundary.segment[boundary.next[v]][1];
    const Vec3 centre = boundary.centre(disc), begin = boundary.vertex[v] - centre,
               end = boundary.vertex[boundary.next[v]] - centre;
    const double angle = angleOf(crossZ(begin, end), begin.x * end.x + begin.y * end.y);
    if (std::abs(angle) > kNearlyZero) return angle < 0 ? angle + kTwoPi : angle;
    // The arc is either nearly empty or nearly the whole circle. In the latter case the covered rest begins with one
    // neighbour and ends with the other, both distant in nearly the same direction, and each covers less than half of
    // the circle. (Around a nearly empty arc these directions can be so close only if one covers more than half.)
    const auto coversLess = [&](std::uint32_t other) { return neighbourOf(boundary, disc, other).power > 0; };
    const Vec3i from = boundary.position[before] - boundary.position[disc],
                to = boundary.position[after] - boundary.position[disc];
    const bool follow = before == after || (crossZ(from, to) < 0 && dotXY(from, to) > 0);
    const bool whole = follow && coversLess(before) && coversLess(after);
    return whole ? std::min(kTwoPi, kTwoPi + angle) : std::max(0.0, angle);
}

namespace {

// Alpha segments that start at some particles, and those particles that have no neighbours.
struct AlphaSegments {
    std::vector<std::array<std::uint32_t, 2>> segment;  // of snapped particles
    std::vector<std::uint32_t> isolated;
};

// The CircleIntersection of discs of one radius, where the predicate is simpler.
class EqualCircleIntersection {
public:
    EqualCircleIntersection(const Neighbour& u, double radius, double) : u_(u.offset), radius_(radius) {}

    Vec3 position() const { return discCentre(u_, radius_); }
    bool isInside(const Neighbour& w) const { return insideDisc(u_, w.offset, radius_); }

private:
    Vec3 u_;
    double radius_;
};

// Is the point where the circles of a particle and of u meet in no other disc? `blocker` is the neighbour found around
// the previous point; it is tested first, because it probably contains this one, too.
template <typename Intersection>
bool isExposed(const Neighbour& u, const std::vector<Neighbour>& neighbours, double radius, double largest,
               const Neighbour*& blocker) {
    const Intersection intersection(u, radius, largest);
    const auto isInside = [&](const Neighbour& w) { return w.particle != u.particle && intersection.isInside(w); };
    if (blocker != nullptr && isInside(*blocker)) return false;
    const auto found = std::find_if(neighbours.begin(), neighbours.end(), isInside);
    if (found == neighbours.end()) return true;
    blocker = &*found;
    return false;
}

// Is the disc inside that of a neighbour?
bool isHidden(const std::vector<Neighbour>& neighbours, double radius) {
    return std::any_of(neighbours.begin(), neighbours.end(), [&](const Neighbour& n) {
        const double difference = n.radius - radius;
        return difference > 0 && n.squaredDistance() < difference * difference;
    });
}

template <typename Intersection>
AlphaSegments segmentsFrom(const SnappedParticles& particles, std::uint32_t begin, std::uint32_t end) {
    const auto largest = static_cast<double>(particles.radius);
    AlphaSegments found;
    NeighbourFinder finder(particles);
    std::vector<Neighbour> neighbours, ends;
    for (std::uint32_t i = begin; i < end; ++i) {
        const auto radius = static_cast<double>(particles.radiusOf(i));
        finder.find(i, neighbours);
        if (neighbours.empty()) found.isolated.push_back(i);
        if (!particles.radius_of.empty() && isHidden(neighbours, radius)) continue;
        ends.clear();
        const Neighbour* blocker = nullptr;
        for (const Neighbour& u : neighbours)
            if (isExposed<Intersection>(u, neighbours, radius, largest, blocker)) ends.push_back(u);
        std::sort(ends.begin(), ends.end(),
                  [](const Neighbour& a, const Neighbour& b) { return directionBefore(a.offset, b.offset); });
        for (const Neighbour& u : ends) found.segment.push_back({i, u.particle});
    }
    return found;
}

AlphaSegments allSegments(const SnappedParticles& particles) {
    const auto n = static_cast<std::uint32_t>(particles.size());
    std::vector<AlphaSegments> parts((n + kParticlesPerTask - 1) / kParticlesPerTask);
    parallelFor(parts.size(), 1, [&](std::size_t task) {
        const auto begin = static_cast<std::uint32_t>(task * kParticlesPerTask);
        const std::uint32_t end = std::min<std::uint32_t>(n, begin + kParticlesPerTask);
        parts[task] = particles.radius_of.empty() ? segmentsFrom<EqualCircleIntersection>(particles, begin, end)
                                                  : segmentsFrom<CircleIntersection>(particles, begin, end);
    });
    AlphaSegments all;
    for (const AlphaSegments& part : parts) {
        all.segment.insert(all.segment.end(), part.segment.begin(), part.segment.end());
        all.isolated.insert(all.isolated.end(), part.isolated.begin(), part.isolated.end());
    }
    return all;
}

// Numbers the exposed particles, which become the discs, and converts the segments to these numbers.
void numberDiscs(const SnappedParticles& particles, AlphaSegments& alpha, DiscBoundary& boundary) {
    std::vector<std::uint32_t> disc(particles.size(), 0);
    for (const auto& [from, to] : alpha.segment) disc[from] = disc[to] = 1;
    for (const std::uint32_t i : alpha.isolated) disc[i] = 1;
    for (std::uint32_t i = 0; i < disc.size(); ++i) {
        if (disc[i] == 0) continue;
        disc[i] = static_cast<std::uint32_t>(boundary.position.size());
        boundary.position.push_back(particles.position[i]);
        boundary.row.push_back(particles.row[i]);
        boundary.snapped_row.push_back(i);
        if (!particles.radius_of.empty()) boundary.radius_of.push_back(particles.radius_of[i]);
    }
    for (auto& segment : alpha.segment) segment = {disc[segment[0]], disc[segment[1]]};
    for (std::uint32_t& i : alpha.isolated) i = disc[i];
    boundary.segment = std::move(alpha.segment);
    boundary.isolated = std::move(alpha.isolated);
}

// An end of an arc on the circle of a disc: a vertex at which the boundary enters or leaves this circle.
struct ArcEnd {
    Vec3 direction;  // to the other disc of the vertex
    std::uint32_t vertex;
    bool leaves;
};

// On each circle the vertex that enters is linked to the next one, counter-clockwise, that leaves. The part of the
// circle that is covered between two arcs begins with one disc and ends with another or the same one. The directions of
// the two follow each other in this order, whatever their radii: each is the middle of what its disc covers, and both
// the begin and the end of this are earlier for the first disc. As each direction is inside the covered part that the
// disc belongs to, the directions of different parts follow each other like the parts.
void linkVertices(DiscBoundary& boundary) {
    const std::size_t discs = boundary.position.size();
    CompressedRows<ArcEnd> ends =
        sortedIntoRows<ArcEnd>(discs, boundary.segment.size(), [&](std::size_t v, const auto& visit) {
            const auto [from, to] = boundary.segment[v];
            const Vec3 offset = toDouble(boundary.position[to] - boundary.position[from]);
            visit(from, {offset, static_cast<std::uint32_t>(v), true});
            visit(to, {-offset, static_cast<std::uint32_t>(v), false});
        });
    boundary.next.resize(boundary.segment.size());
    parallelFor(discs, 256, [&](std::size_t d) {
        const auto first = ends[d].begin(), last = ends[d].end();
        std::sort(first, last, [](const ArcEnd& a, const ArcEnd& b) {
            if (directionBefore(a.direction, b.direction)) return true;
            return !directionBefore(b.direction, a.direction) && a.leaves && !b.leaves;
        });
        for (auto end = first; end != last; ++end) {
            if (end->leaves) continue;
            const auto& following = end + 1 == last ? *first : *(end + 1);
            assert(following.leaves);
            boundary.next[end->vertex] = following.vertex;
        }
    });
}

void collectCycles(DiscBoundary& boundary) {
    std::vector<bool> visited(boundary.next.size(), false);
    for (std::uint32_t start = 0; start < boundary.next.size(); ++start) {
        if (visited[start]) continue;
        for (std::uint32_t v = start; !visited[v]; v = boundary.next[v]) {
            visited[v] = true;
            boundary.cycle.item.push_back(v);
        }
        boundary.cycle.begin.push_back(static_cast<std::uint32_t>(boundary.cycle.item.size()));
    }
}

template <typename Intersection>
void setVertices(DiscBoundary& boundary) {
    const auto largest = static_cast<double>(boundary.radius);
    boundary.vertex.resize(boundary.segment.size());
    parallelFor(boundary.segment.size(), 1024, [&](std::size_t v) {
        const std::uint32_t from = boundary.segment[v][0], to = boundary.segment[v][1];
        const Intersection intersection(neighbourOf(boundary, from, to), static_cast<double>(boundary.radiusOf(from)),
                                        largest);
        boundary.vertex[v] = (toDouble(boundary.position[from]) + intersection.position()) * boundary.quantum;
    });
}

}  // namespace

DiscBoundary discBoundary(const SnappedParticles& particles) {
    DiscBoundary boundary;
    boundary.quantum = particles.quantum;
    boundary.radius = particles.radius;
    AlphaSegments alpha = allSegments(particles);
    numberDiscs(particles, alpha, boundary);
    if (particles.radius_of.empty())
        setVertices<EqualCircleIntersection>(boundary);
    else
        setVertices<CircleIntersection>(boundary);
    linkVertices(boundary);
    collectCycles(boundary);
    return boundary;
}

namespace {

// The sample that represents the part of a circle from one angle to another.
BoundarySample arcSample(const DualVec3& centre, Dual radius, Dual begin, Dual end) {
    const Dual angle = (begin + end) / 2;
    const auto [s, c] = sineCosine(angle.value);
    const DualVec3 outwards{{c, s, 0}, Vec3(-s, c, 0) * angle.rate};
    return {centre + outwards * radius, outwards, (end - begin) * radius};
}

// The angle of a point about a centre.
Dual angleAbout(const DualVec3& point, const DualVec3& centre) {
    const DualVec3 offset = point - centre;
    return {angleOf(offset.position.y, offset.position.x),
            crossZ(offset.position, offset.velocity) / offset.position.length2()};
}

// The angles about its centre at which the arc from a vertex begins and ends.
std::pair<Dual, Dual> movingEnds(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                                 const std::vector<DualVec3>& vertices, std::uint32_t v) {
    const DualVec3& centre = discs[boundary.segment[v][1]];
    const Dual begin = angleAbout(vertices[v], centre);
    return {begin, {begin.value + arcAngle(boundary, v), angleAbout(vertices[boundary.next[v]], centre).rate}};
}

}  // namespace

Dual arcLength(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, const std::vector<DualVec3>& vertices,
               std::uint32_t v) {
    const auto [begin, end] = movingEnds(boundary, discs, vertices, v);
    return (end - begin) * boundary.worldRadiusOf(boundary.segment[v][1]);
}

DiscSamples boundarySamples(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                            const std::vector<DualVec3>& vertices, int directions) {
    const double step = kTwoPi / directions;
    DiscSamples samples;
    const auto add = [&](std::uint32_t disc, std::uint32_t arc, Dual begin, Dual end) {
        samples.sample.push_back(arcSample(discs[disc], boundary.worldRadiusOf(disc), begin, end));
        samples.disc.push_back(disc);
        samples.arc.push_back(arc);
        if (boundary.hasScales()) samples.scale.push_back(boundary.movingScaleOf(disc));
    };
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
        const std::uint32_t disc = boundary.segment[v][1];
        auto [begin, end] = movingEnds(boundary, discs, vertices, v);
        for (double k = std::floor(begin.value / step) + 1; k * step < end.value; ++k) {
            add(disc, v, begin, k * step);
            begin = k * step;
        }
        add(disc, v, begin, end);
    }
    for (const std::uint32_t d : boundary.isolated)
        for (int k = 0; k < directions; ++k) add(d, kInvalidIndex, k * step, (k + 1) * step);
    return samples;
}

}  // namespace betamesh
