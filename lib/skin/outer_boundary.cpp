
#include "skin/outer_boundary.h"

#include "base/cell_grid.h"
#include "base/octaves.h"
#include "base/parallel.h"
#include "betamesh/skin_params.h"
#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"
#include "skin/coverage.h"
#include "skin/face_points.h"
#include "skin/near_surface.h"
#include "skin/velocity.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace betamesh {

namespace {

// Snapped particles as ordinary particles, in the same order.
Particles unsnapped(const Particles& particles, const SnappedParticles& snapped) {
    Particles all;
    all.position.resize(snapped.size());
    all.velocity.resize(particles.velocity.empty() ? 0 : snapped.size());
    parallelFor(snapped.size(), 8192, [&](std::size_t i) {
        all.position[i] = Vec3f(toDouble(snapped.position[i]) * snapped.quantum);
        if (!all.velocity.empty()) all.velocity[i] = particles.velocity[snapped.row[i]];
    });
    return all;
}

// Is some ball's centre at most this far from a point? In quanta.
bool anyWithin(const BallBoundary& boundary, const CellGrid& grid, const Vec3& point, double reach) {
    bool any = false;
    grid.forCellsIn(point - Vec3(reach), point + Vec3(reach), [&](std::uint32_t cell) {
        if (any) return;
        for (const std::uint32_t ball : grid.rowsOf(cell))
            any = any || (toDouble(boundary.position[ball]) - point).length2() <= reach * reach;
    });
    return any;
}

// How far the centre of a ball that is exposed at the larger radius L can be from that of one exposed at the smaller R,
// in world units. On the way from its centre to a point that is exposed at L, one leaves the smaller balls where one of
// them is exposed, k. Different radii: the two centres are at most R and L from there. One radius: no centre is nearer
// to the point than L, so k would be the ball itself, were it not that the grid of L moves centres by up to √3/2 of its
// quantum q. With s >= L - R - q the distance that is left to the point, the directions from there to both centres
// differ by a chord of at most √(2 √3 q L / (s R)), and the distances by at most √3 q.
double reachToExposed(const SnappedParticles& larger, const BallBoundary& boundary) {
    const double quantum = larger.quantum, radius = boundary.worldRadius();
    const double outer = static_cast<double>(larger.radius) * quantum, both = 1.001 * (outer + radius);
    const double left = outer - radius - quantum;
    if (larger.size_classes || !(left > 0)) return both;
    return std::min(both, 2 * std::sqrt(quantum * outer * radius / left) + 2 * quantum);
}

// Particles that may be exposed at the larger radius: those not certainly covered, and near one that is exposed at the
// smaller radius.
std::vector<std::uint32_t> exposureCandidates(const SnappedParticles& larger, const SnappedParticles& snapped,
                                              const BallBoundary& boundary) {
    std::vector<std::uint32_t> candidates = exposureCandidates(larger);
    std::vector<std::uint8_t> is_exposed(snapped.size(), 0);
    for (const std::uint32_t row : boundary.snapped_row) is_exposed[row] = 1;
    const double reach = reachToExposed(larger, boundary) / boundary.quantum;
    const CellGrid grid(boundary.position.size(), 2 * reach,
                        [&](std::size_t ball) { return toDouble(boundary.position[ball]); });
    const std::vector<std::uint32_t> near = indicesWhere(candidates.size(), [&](std::uint32_t k) {
        const std::uint32_t row = larger.row[candidates[k]];
        return is_exposed[row] || anyWithin(boundary, grid, toDouble(snapped.position[row]), reach);
    });
    for (std::size_t k = 0; k < near.size(); ++k) candidates[k] = candidates[near[k]];
    candidates.resize(near.size());
    return candidates;
}

// The particles with larger balls, of which the largest has this radius.
SnappedParticles enlarged(const SnappedParticles& snapped, const Particles& particles, double radius) {
    if (!snapped.size_classes) {
        SkinParams params;
        params.radius = radius;
        NearSurfaceFinder finder(params);
        finder.add(particles.position);
        return snapParticles(particles, radius, finder.find());
    }
    std::vector<double> radii(snapped.size());
    for (std::size_t i = 0; i < radii.size(); ++i)
        radii[i] = radius * (static_cast<double>(snapped.radius_of[i]) / static_cast<double>(snapped.radius));
    SnappedParticles larger = snapParticles(particles, radii, radius);
    larger.is_covered = coverage(larger);
    return larger;
}

// Sets the rates of the larger balls' radii, which are in proportion to those of the smaller ones; 0 for balls that are
// covered among the smaller ones.
void setRadiusRates(const BallBoundary& boundary, BallBoundary& outer) {
    if (boundary.radius_rate.empty()) return;
    const double factor = outer.worldRadius() / boundary.worldRadius();
    outer.radius_rate.assign(outer.position.size(), 0);
    for (std::size_t b = 0; b < outer.row.size(); ++b) {
        const auto& rows = boundary.snapped_row;
        const auto found = std::lower_bound(rows.begin(), rows.end(), outer.row[b]);
        if (found != rows.end() && *found == outer.row[b])
            outer.radius_rate[b] = factor * boundary.radius_rate[static_cast<std::size_t>(found - rows.begin())];
    }
}

// Lowers the scales of samples so that the rolling ball at each reaches hardly deeper than to the skin of any particle.
// Only the skins of smaller particles can be nearer than that of the sample's own.
void keepOutOfSkins(const Particles& particles, const SnappedParticles& larger,
                    const std::vector<std::uint32_t>& uncovered, const SkinLengths& lengths, double spacing,
                    OuterSamples& samples) {
    const double least_depth = std::max(0.0, lengths.skin - kOutermost);
    const auto scaleOf = [&](std::uint32_t i) {
        return static_cast<double>(larger.radiusOf(i)) / static_cast<double>(larger.radius);
    };
    std::vector<float> particle_scale(larger.size());
    for (const std::uint32_t i : uncovered) particle_scale[i] = static_cast<float>(scaleOf(i));
    const std::vector<float> own = samples.scale;
    const auto samples_of = byOctave(allRows(own.size()), own);
    const auto particles_of = byOctave(std::vector<std::uint32_t>(uncovered), particle_scale);
    const auto positionOf = [&](std::uint32_t i) { return Vec3(particles.position[larger.row[i]]); };
    for (std::size_t coarse = 0; coarse < samples_of.size(); ++coarse)
        for (std::size_t fine = coarse; fine < particles_of.size(); ++fine) {
            const std::vector<std::uint32_t>&rows = samples_of[coarse], &near = particles_of[fine];
            if (rows.empty() || near.empty()) continue;
            const double reach =
                spacing * (lengths.rolling() * largestOfOctave(coarse) + lengths.skin * largestOfOctave(fine));
            const auto nearAt = [&](std::size_t i) { return positionOf(near[i]); };
            const CellGrid points(rows.size(), reach / 2,
                                  [&](std::size_t i) { return samples.point[rows[i]].position; });
            const CellGrid around(near.size(), reach / 2, nearAt);
            forCellsAndNeighbours(
                reach, points, around, nearAt, [&](std::uint32_t cell, std::span<const std::uint32_t> found) {
                    for (const std::uint32_t row : points.rowsOf(cell)) {
                        const std::uint32_t sample = rows[row];
                        for (const std::uint32_t other : found) {
                            const std::uint32_t i = near[other];
                            if (!(particle_scale[i] < own[sample])) continue;
                            const double distance = (positionOf(i) - samples.point[sample].position).length();
                            const double room = distance / spacing - least_depth * scaleOf(i);
                            samples.scale[sample] =
                                std::min(samples.scale[sample], static_cast<float>(room / lengths.rolling()));
                        }
                    }
                });
        }
}

// What is added to the squared distances from samples that have just appeared.
float newSampleOffset(const BallBoundary& outer) {
    const bool have_scales = !outer.radius_of.empty() || !outer.radius_rate.empty();
    return have_scales ? kNewSampleSquaredOffsetOfUnequal : kNewSampleSquaredOffset;
}

// entranceOffset() of each point of the network: at vertices for the arcs that begin there, inside an arc the mean
// of both ends.
std::vector<float> entranceOffsets(const BallBoundary& outer, const ArcNetwork& network, double rolling,
                                   double spacing) {
    const auto lengthOf = [&](std::size_t line) {
        return network.line[line].length.value / (spacing * network.scaleOfLine(line, outer));
    };
    const auto offsetFor = [&](double length) { return static_cast<float>(entranceOffset(length, rolling).value); };
    std::vector<float> offset(network.point.size());
    for (std::size_t v = 0; v < network.vertices; ++v) {
        double length = 0;
        for (std::size_t h = 3 * v; h < 3 * v + 3; ++h) length += lengthOf(network.arc_of[h]) / 3;
        offset[v] = offsetFor(length);
    }
    const auto setPoints = [&](std::uint32_t begin, std::uint32_t end, float value) {
        std::fill(offset.begin() + begin, offset.begin() + end, value);
    };
    const std::size_t arcs = network.arc_start.size();
    for (std::size_t a = 0; a < arcs; ++a) {
        const std::uint32_t start = network.arc_start[a], end = outer.twin[start];
        setPoints(network.arc_begin[a], network.arc_begin[a + 1], (offset[start / 3] + offset[end / 3]) / 2);
    }
    for (std::size_t k = 0; k + 1 < network.circle_begin.size(); ++k)
        setPoints(network.circle_begin[k], network.circle_begin[k + 1], offsetFor(lengthOf(arcs + k)));
    return offset;
}

// The points of the network as samples.
OuterSamples samplesOnArcs(const BallBoundary& outer, const ArcNetwork& network, const SkinLengths& lengths,
                           double spacing) {
    const double rolling_share = lengths.rolling() / lengths.outer();
    OuterSamples samples;
    samples.scale = network.pointScales(outer);
    if (!outer.radius_rate.empty()) {
        samples.growth =
            network.pointMeans(outer, [&](std::size_t ball) { return outer.radius_rate[ball] * rolling_share; });
        samples.scale.resize(samples.growth.size(), 1);
    }
    samples.point = unfadedPoints(network);
    samples.weight = weightsOfPoints(outer, network, samples.point, spacing);
    samples.squared_offset = entranceOffsets(outer, network, lengths.rolling(), spacing);
    for (const FadingVertex& fading : network.fading)
        samples.squared_offset[fading.vertex] += newSampleOffset(outer) * static_cast<float>(1 - fading.fade.value);
    samples.exposure.assign(samples.point.size(), 0);
    return samples;
}

// Adds the points inside faces that are far enough from rims.
void addSamplesInFaces(const BallBoundary& outer, const std::vector<DualVec3>& balls, const FacePoints& inside,
                       const SkinLengths& lengths, double spacing, OuterSamples& samples) {
    const bool have_growth = !outer.radius_rate.empty(), have_scales = have_growth || !outer.radius_of.empty();
    const double radius = lengths.outer() * spacing, rolling_share = lengths.rolling() / lengths.outer();
    const auto directions = static_cast<double>(inside.directions.position.size());
    const double face_area = 4 * std::numbers::pi * radius * radius / directions / (spacing * spacing);
    const float offset = newSampleOffset(outer);
    for (std::size_t b = 0; b < balls.size(); ++b) {
        const Dual of_ball(radius * outer.scaleOf(b), outer.worldRadiusOf(b).rate);
        double exposed = 0;
        for (std::uint32_t p = inside.begin[b]; p < inside.begin[b + 1]; ++p) {
            const double fade = smoothStep(inside.rim_distance[p] / kOuterFadeWidth).value;
            if (inside.contactOf(p) || !(fade > 0)) continue;
            samples.point.push_back(balls[b] + inside.outwards(p) * of_ball);
            samples.weight.push_back(static_cast<float>(face_area * fade));
            samples.squared_offset.push_back(offset * static_cast<float>(1 - fade));
            exposed += fade;
        }
        samples.exposure.resize(samples.point.size(), static_cast<float>(exposed / directions));
        if (have_scales) samples.scale.resize(samples.point.size(), static_cast<float>(outer.scaleOf(b)));
        if (have_growth) samples.growth.resize(samples.point.size(), static_cast<float>(of_ball.rate * rolling_share));
    }
}

}  // namespace

std::vector<DualVec3> unfadedPoints(const ArcNetwork& network) {
    std::vector<DualVec3> point = network.point;
    for (const FadingVertex& fading : network.fading) point[fading.vertex] = fading.unfaded;
    return point;
}

std::vector<float> weightsOfPoints(const BallBoundary& boundary, const ArcNetwork& network,
                                   const std::vector<DualVec3>& unfaded, double spacing) {
    std::vector<float> weight(unfaded.size(), 0);
    const auto addSegment = [&](std::size_t line, std::uint32_t from, std::uint32_t to) {
        const double unit = spacing * network.scaleOfLine(line, boundary);
        const double length = (unfaded[from].position - unfaded[to].position).length() / unit;
        for (const std::uint32_t end : {from, to}) weight[end] += static_cast<float>(length / 2);
    };
    for (std::size_t a = 0; a < network.arc_start.size(); ++a) {
        std::uint32_t last = network.arc_start[a] / 3;
        for (std::uint32_t p = network.arc_begin[a]; p < network.arc_begin[a + 1]; ++p)
            addSegment(a, std::exchange(last, p), p);
        addSegment(a, last, boundary.twin[network.arc_start[a]] / 3);
    }
    for (std::size_t k = 0; k + 1 < network.circle_begin.size(); ++k) {
        std::uint32_t last = network.circle_begin[k + 1] - 1;
        for (std::uint32_t p = network.circle_begin[k]; p < network.circle_begin[k + 1]; ++p)
            addSegment(network.arc_start.size() + k, std::exchange(last, p), p);
    }
    for (const FadingVertex& fading : network.fading) {
        const float moved = weight[fading.vertex] * static_cast<float>(1 - fading.fade.value);
        weight[fading.vertex] -= moved;
        for (const std::size_t k : {0U, 1U}) weight[fading.support[k]] += moved / 2;
    }
    return weight;
}

OuterSamples outerSamples(const Particles& particles, const SnappedParticles& snapped, const BallBoundary& boundary,
                          const SkinLengths& lengths, double spacing) {
    const double radius = lengths.outer() * spacing;
    const Particles all = unsnapped(particles, snapped);
    const SnappedParticles larger = enlarged(snapped, all, radius);
    Icosphere directions = icosphereOf(kOuterFaceAngle);
    BallBoundary outer = ballBoundary(larger, exposureCandidates(larger, snapped, boundary), directions.position);
    setRadiusRates(boundary, outer);
    const std::vector<DualVec3> balls = ballCentres(outer, all);
    ArcSubdivision subdivision;
    subdivision.max_angle = kOuterArcAngle;
    subdivision.appearance = Appearance::gradual;
    const ArcNetwork network = arcPoints(outer, balls, boundaryVertices(all, larger, outer, balls), subdivision);
    const FacePoints inside = facePoints(larger, outer, balls, std::move(directions));

    OuterSamples samples = samplesOnArcs(outer, network, lengths, spacing);
    addSamplesInFaces(outer, balls, inside, lengths, spacing, samples);
    if (!outer.radius_of.empty()) keepOutOfSkins(all, larger, notAmongAlike(larger), lengths, spacing, samples);
    return samples;
}

}  // namespace betamesh
