
#include "planar/disc_boundary.h"

#include "base/angles.h"
#include "base/compressed_rows.h"
#include "base/parallel.h"
#include "exact/plane_predicates.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kNearlyNothing = 1e-3;  // radians, far above rounding

std::int64_t dotPlane(const Vec3i& a, const Vec3i& b) { return a.x * b.x + a.y * b.y; }

}  // namespace

double arcAngle(const DiscBoundary& boundary, std::uint32_t v) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const auto [before, disc] = boundary.segment[v];
    const std::uint32_t after = boundary.segment[boundary.next[v]][1];
    const Vec3 centre = boundary.centre(disc), begin = boundary.vertex[v] - centre,
               end = boundary.vertex[boundary.next[v]] - centre;
    const double angle = angleOf(crossZ(begin, end), begin.x * end.x + begin.y * end.y);
    if (std::abs(angle) > kNearlyNothing) return angle < 0 ? angle + kTurn : angle;
    // Next to nothing, or nearly the whole circle? Then what covers the rest begins with the one neighbour and ends
    // with the other, both far away in nearly the same direction.
    const Vec3i from = boundary.position[before] - boundary.position[disc],
                to = boundary.position[after] - boundary.position[disc];
    const bool whole = before == after || (crossZ(from, to) < 0 && dotPlane(from, to) > 0);
    return whole ? std::min(kTurn, kTurn + angle) : std::max(0.0, angle);
}

namespace {

constexpr std::size_t kParticlesPerTask = 256;

// Segments that leave one particle, and whether anything comes near it.
struct Leaving {
    std::vector<std::array<std::uint32_t, 2>> segment;  // of snapped particles
    std::vector<std::uint32_t> isolated;
};

// Is the disc to the right of the way to `u` empty? `last` is whoever was in the way the last time, asked first.
bool isEmpty(const Neighbour& u, const std::vector<Neighbour>& neighbours, double radius, const Neighbour*& last) {
    const auto inside = [&](const Neighbour& w) {
        return w.particle != u.particle && insideDisc(u.offset, w.offset, radius);
    };
    if (last != nullptr && inside(*last)) return false;
    const auto found = std::find_if(neighbours.begin(), neighbours.end(), inside);
    if (found == neighbours.end()) return true;
    last = &*found;
    return false;
}

Leaving leavingSegments(const SnappedParticles& particles, std::uint32_t begin, std::uint32_t end) {
    const auto radius = static_cast<double>(particles.radius);
    Leaving leaving;
    NeighbourFinder finder(particles);
    std::vector<Neighbour> neighbours, empty;
    for (std::uint32_t i = begin; i < end; ++i) {
        finder.find(i, neighbours);
        if (neighbours.empty()) leaving.isolated.push_back(i);
        empty.clear();
        const Neighbour* last = nullptr;
        for (const Neighbour& u : neighbours)
            if (isEmpty(u, neighbours, radius, last)) empty.push_back(u);
        std::sort(empty.begin(), empty.end(),
                  [](const Neighbour& a, const Neighbour& b) { return directionBefore(a.offset, b.offset); });
        for (const Neighbour& u : empty) leaving.segment.push_back({i, u.particle});
    }
    return leaving;
}

Leaving allSegments(const SnappedParticles& particles) {
    const auto n = static_cast<std::uint32_t>(particles.size());
    std::vector<Leaving> parts((n + kParticlesPerTask - 1) / kParticlesPerTask);
    parallelFor(parts.size(), 1, [&](std::size_t task) {
        const auto begin = static_cast<std::uint32_t>(task * kParticlesPerTask);
        parts[task] = leavingSegments(particles, begin, std::min<std::uint32_t>(n, begin + kParticlesPerTask));
    });
    Leaving all;
    for (const Leaving& part : parts) {
        all.segment.insert(all.segment.end(), part.segment.begin(), part.segment.end());
        all.isolated.insert(all.isolated.end(), part.isolated.begin(), part.isolated.end());
    }
    return all;
}

// Numbers the exposed particles: they become the discs.
void nameDiscs(const SnappedParticles& particles, Leaving& leaving, DiscBoundary& boundary) {
    std::vector<std::uint32_t> disc(particles.size(), 0);
    for (const auto& [from, to] : leaving.segment) disc[from] = disc[to] = 1;
    for (const std::uint32_t i : leaving.isolated) disc[i] = 1;
    for (std::uint32_t i = 0; i < disc.size(); ++i) {
        if (disc[i] == 0) continue;
        disc[i] = static_cast<std::uint32_t>(boundary.position.size());
        boundary.position.push_back(particles.position[i]);
        boundary.row.push_back(particles.row[i]);
        boundary.snapped_row.push_back(i);
    }
    for (auto& segment : leaving.segment) segment = {disc[segment[0]], disc[segment[1]]};
    for (std::uint32_t& i : leaving.isolated) i = disc[i];
    boundary.segment = std::move(leaving.segment);
    boundary.isolated = std::move(leaving.isolated);
}

// A vertex on the circle of a disc: where another disc begins or ceases to cover it, seen counter-clockwise.
struct Mark {
    Vec3 direction;  // to the other disc
    std::uint32_t vertex;
    bool leaves;
};

// Each vertex that comes to a disc is followed by the next one that leaves it. What covers the circle between two arcs
// begins with one disc and ends with another or the same, whose directions follow each other in that order.
void linkVertices(DiscBoundary& boundary) {
    const std::size_t discs = boundary.position.size();
    CompressedRows<Mark> marks = sortedIntoRows<Mark>(discs, boundary.segment.size(), [&](std::size_t v, const auto& visit) {
        const auto [from, to] = boundary.segment[v];
        const Vec3 way = toDouble(boundary.position[to] - boundary.position[from]);
        visit(from, {way, static_cast<std::uint32_t>(v), true});
        visit(to, {-way, static_cast<std::uint32_t>(v), false});
    });
    boundary.next.resize(boundary.segment.size());
    parallelFor(discs, 256, [&](std::size_t d) {
        const auto first = marks[d].begin(), last = marks[d].end();
        std::sort(first, last, [](const Mark& a, const Mark& b) {
            if (directionBefore(a.direction, b.direction)) return true;
            return !directionBefore(b.direction, a.direction) && a.leaves && !b.leaves;
        });
        for (auto mark = first; mark != last; ++mark) {
            if (mark->leaves) continue;
            const auto& following = mark + 1 == last ? *first : *(mark + 1);
            assert(following.leaves);
            boundary.next[mark->vertex] = following.vertex;
        }
    });
}

void followCycles(DiscBoundary& boundary) {
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

}  // namespace

DiscBoundary discBoundary(const SnappedParticles& particles) {
    DiscBoundary boundary;
    boundary.quantum = particles.quantum;
    boundary.radius = particles.radius;
    Leaving leaving = allSegments(particles);
    nameDiscs(particles, leaving, boundary);
    const auto radius = static_cast<double>(particles.radius);
    boundary.vertex.resize(boundary.segment.size());
    parallelFor(boundary.segment.size(), 1024, [&](std::size_t v) {
        const auto [from, to] = boundary.segment[v];
        const Vec3 way = toDouble(boundary.position[to] - boundary.position[from]);
        boundary.vertex[v] = (toDouble(boundary.position[from]) + discCentre(way, radius)) * particles.quantum;
    });
    linkVertices(boundary);
    followCycles(boundary);
    return boundary;
}

}  // namespace betamesh
