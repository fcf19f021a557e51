#include "skin/boundary_samples.h"

#include "core/moving_circle.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLongestPiece = 0.8;  // radians
constexpr std::uint32_t kPiecesOfCircle = 8;
constexpr double kLift = 0.5;              // of the way from the arc to the sphere round its centre
constexpr double kAreaWeight = 3;          // length that stands for an area, times the radius
constexpr std::uint32_t kDirections = 42;  // that are enough for a whole sphere
constexpr double kRimWidth = 0.3;          // faces count in full from twice this clearance on, not below once

Rate smoothStep(Rate t) {
    if (t.value <= 0) return 0;
    if (t.value >= 1) return 1;
    return t * t * (3 - t * 2);
}

// A piece of a circle that covers an angle, seen from its middle.
BoundarySample pieceAt(const MovingCircle& circle, Rate angle, Rate covered) {
    const Moving outwards = circle.outwards(angle);
    const Rate lifted = circle.radius() * (1 - kLift) + kLift * circle.sphereRadius();
    return {circle.centre() + outwards * lifted, outwards * (circle.radius() / circle.sphereRadius()),
            circle.radius() * covered};
}

}  // namespace

BoundarySamples boundarySamples(const BallBoundary& boundary, const std::vector<Moving>& balls,
                                const std::vector<Vec3>& spins, const ArcNetwork& network, const FacePoints& points) {
    const double radius = boundary.worldRadius();
    const std::size_t arcs = network.arc_start.size(), circles = boundary.circle.size();
    const auto from = [&](std::uint32_t h) { return boundary.triangle[h / 3][h % 3]; };

    const auto all = static_cast<std::uint32_t>(points.directions.position.size());
    const std::uint32_t used = points.directions.coarse >= kDirections ? points.directions.coarse : all;
    const auto counts = [&](std::uint32_t p) {
        return points.direction[p] < used && points.clearance[p].value > kRimWidth;
    };
    std::vector<std::uint32_t> pieces(arcs + balls.size());
    parallelFor(arcs, 4096, [&](std::size_t a) {
        pieces[a] = std::max(1U, static_cast<std::uint32_t>(std::ceil(network.arc_angle[a].value / kLongestPiece)));
    });
    parallelFor(balls.size(), 4096, [&](std::size_t b) {
        for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) pieces[arcs + b] += counts(p);
    });
    const std::vector<std::uint32_t> place = placesOf(pieces);
    const std::size_t first_circle = place.back();
    BoundarySamples samples(first_circle + circles * kPiecesOfCircle);

    parallelFor(arcs, 512, [&](std::size_t a) {
        const std::uint32_t start = network.arc_start[a];
        MovingCircle circle(balls[from(start)], balls[from(boundary.twin[start])], radius);
        circle.beginTowards(network.point[start / 3]);
        const Rate angle = network.arc_angle[a];
        for (std::uint32_t k = 0; k < pieces[a]; ++k)
            samples[place[a] + k] = pieceAt(circle, angle * ((k + 0.5) / pieces[a]), angle / pieces[a]);
    });
    parallelFor(circles, 64, [&](std::size_t c) {
        MovingCircle circle(balls[boundary.circle[c][0]], balls[boundary.circle[c][1]], radius);
        circle.beginAnywhere((spins[boundary.circle[c][0]] + spins[boundary.circle[c][1]]) / 2);
        for (std::uint32_t k = 0; k < kPiecesOfCircle; ++k)
            samples[first_circle + c * kPiecesOfCircle + k] =
                pieceAt(circle, kTurn * k / kPiecesOfCircle, kTurn / kPiecesOfCircle);
    });
    const double whole = kAreaWeight * 2 * kTurn * radius / used;
    parallelFor(balls.size(), 512, [&](std::size_t b) {
        std::uint32_t next = place[arcs + b];
        for (std::uint32_t p = points.begin[b]; p < points.begin[b + 1]; ++p) {
            if (!counts(p)) continue;
            const Moving direction = points.outwards(p, spins[b]);
            const Rate inside = smoothStep(points.clearance[p] / kRimWidth - 1);
            samples[next++] = {balls[b] + direction * radius, direction, inside * whole};
        }
    });
    return samples;
}

}  // namespace betamesh
