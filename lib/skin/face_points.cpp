#include "skin/face_points.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr std::size_t kBallsPerTask = 64;
constexpr double kIcosahedronAngle = 1.1071487177940904;
constexpr double kWide = 0.28;        // sine of the half-angle from which on a cap is wide
constexpr double kNegligible = 1e-6;  // sine of the half-angle of a cap that hides nothing

// What another ball hides of a sphere.
struct Cap {
    Vec3 axis;
    double cosine, per_clearance;
    std::uint32_t particle;

    double clearance(const Vec3& direction) const { return (cosine - dot(direction, axis)) * per_clearance; }
};

void capsOf(const std::vector<Neighbour>& neighbours, double radius, std::vector<Cap>& caps) {
    caps.clear();
    for (const Neighbour& n : neighbours) {
        const double distance = std::sqrt(n.squared), cosine = distance / (2 * radius);
        const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        if (sine < kNegligible) continue;
        caps.push_back({n.offset / distance, cosine, 1 / (sine * std::min(1.0, sine / kWide)), n.particle});
    }
    // Near neighbours cover most: they end the search soonest.
    std::sort(caps.begin(), caps.end(), [](const Cap& a, const Cap& b) {
        return a.cosine != b.cosine ? a.cosine < b.cosine : a.particle < b.particle;
    });
}

// How the clearance from one cap changes. offset: from the ball to the other one, in radii.
Rate movingClearance(const Moving& direction, const Moving& offset) {
    const Rate distance = length(offset), cosine = distance / 2;
    const Rate sine = squareRoot(1 - cosine * cosine);
    const Rate along = dot(direction, offset) / distance;
    const Rate width = sine.value < kWide ? sine * sine / kWide : sine;
    return (cosine - along) / width;
}

struct Part {
    std::vector<std::uint32_t> count, direction;
    std::vector<Rate> clearance;
};

}  // namespace

FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<Moving>& balls,
                      const std::vector<Vec3>& spins, double angle) {
    FacePoints points;
    points.directions = icosphere(static_cast<std::uint32_t>(std::ceil(kIcosahedronAngle / angle)));
    const double radius = static_cast<double>(boundary.radius);

    std::vector<std::uint32_t> ball_of(particles.size(), ~std::uint32_t{0});  // exposed ones alone move
    for (std::uint32_t b = 0; b < balls.size(); ++b) ball_of[boundary.snapped_row[b]] = b;

    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<Part> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        Part& part = parts[task];
        NeighbourFinder finder(particles);
        std::vector<Neighbour> neighbours;
        std::vector<Cap> caps;
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            finder.find(boundary.snapped_row[b], neighbours);
            capsOf(neighbours, radius, caps);
            const std::size_t before = part.direction.size();
            for (std::uint32_t d = 0; d < points.directions.position.size(); ++d) {
                const Vec3& direction = points.directions.position[d];
                double least = kFullClearance;
                const Cap* nearest = nullptr;
                for (const Cap& cap : caps) {
                    const double clearance = cap.clearance(direction);
                    if (clearance >= least) continue;
                    least = clearance;
                    nearest = &cap;
                    if (least <= 0) break;
                }
                if (least <= 0) continue;
                part.direction.push_back(d);
                Rate clearance{least, 0};
                if (nearest != nullptr && ball_of[nearest->particle] != ~std::uint32_t{0}) {
                    const Moving& other = balls[ball_of[nearest->particle]];
                    clearance = movingClearance({direction, cross(spins[b], direction)},
                                                (other - balls[b]) / boundary.worldRadius());
                }
                part.clearance.push_back(clearance);
            }
            part.count.push_back(static_cast<std::uint32_t>(part.direction.size() - before));
        }
    });

    for (const Part& part : parts) {
        for (const std::uint32_t n : part.count) points.begin.push_back(points.begin.back() + n);
        points.direction.insert(points.direction.end(), part.direction.begin(), part.direction.end());
        points.clearance.insert(points.clearance.end(), part.clearance.begin(), part.clearance.end());
    }
    return points;
}

}  // namespace betamesh
