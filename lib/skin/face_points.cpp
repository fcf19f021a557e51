#include "skin/face_points.h"

#include "core/cell_order.h"
#include "core/parallel.h"
#include "core/simd.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr std::size_t kBallsPerTask = 256;
constexpr double kIcosahedronAngle = 1.1071487177940904;
constexpr double kWide = 0.28;  // sine of the half-angle from which on a cap is wide
constexpr std::uint32_t kBuried = ~std::uint32_t{0};
constexpr double kNearlyTouching = 0.1;  // between spheres, radii
constexpr double kOnePoint = 1e-3;       // between directions, and from rims, for a contact to be a point of its own
constexpr double kNegligible = 1e-6;     // sine of the half-angle of a cap that hides nothing

// What other balls hide of a sphere, each a cap of it: clearance is (cosine - direction · axis) · scale.
struct Caps {
    std::vector<std::uint32_t> particle;
    std::vector<double> offset_x, offset_y, offset_z, squared;
    std::vector<float> x, y, z, cosine, scale;

    void of(const std::vector<Neighbour>& neighbours, double radius);
    std::size_t size() const { return particle.size(); }
};

BETAMESH_EVERY_CPU
void makeCaps(Caps& caps, double radius) {
    const std::size_t n = caps.size();
    const double *const offset_x = caps.offset_x.data(), *const offset_y = caps.offset_y.data(),
                        *const offset_z = caps.offset_z.data(), *const squared = caps.squared.data();
    float *const x = caps.x.data(), *const y = caps.y.data(), *const z = caps.z.data(),
                 *const cosine = caps.cosine.data(), *const scale = caps.scale.data();
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const double distance = std::sqrt(squared[i]), middle = distance / (2 * radius), rest = 1 - middle * middle;
        const double sine = std::sqrt(rest > 0 ? rest : 0), wide = sine / kWide;
        const double inverse = 1 / (sine * (wide < 1 ? wide : 1) + std::numeric_limits<double>::min());
        x[i] = static_cast<float>(offset_x[i] / distance);
        y[i] = static_cast<float>(offset_y[i] / distance);
        z[i] = static_cast<float>(offset_z[i] / distance);
        cosine[i] = static_cast<float>(sine < kNegligible ? 2 * kFullClearance : middle);
        scale[i] = static_cast<float>(sine < kNegligible ? 1 : inverse);
    }
}

void Caps::of(const std::vector<Neighbour>& neighbours, double radius) {
    const std::size_t n = neighbours.size();
    particle.resize(n);
    for (auto* numbers : {&offset_x, &offset_y, &offset_z, &squared}) numbers->resize(n);
    for (auto* numbers : {&x, &y, &z, &cosine, &scale}) numbers->resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Neighbour& other = neighbours[i];
        particle[i] = other.particle;
        offset_x[i] = other.offset.x;
        offset_y[i] = other.offset.y;
        offset_z[i] = other.offset.z;
        squared[i] = other.squared;
    }
    makeCaps(*this, radius);
}

// The least clearance of some directions from every so many of the caps, and whose cap it is from; -1 without any.
struct FindNearest {
    const DirectionColumns& directions;
    std::size_t count;
    const Caps& caps;
    std::size_t every;
    std::vector<float>&clearance, &cap;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        for (std::size_t i = 0; i < count; i += kWidth) {
            Some dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Some least = Some{} + static_cast<float>(kFullClearance), whose = Some{} - 1, number{};
            const auto step = static_cast<float>(every);
            for (std::size_t k = 0; k < caps.size(); k += every, number += step) {
                const Some from = (caps.cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k]) * caps.scale[k];
                whose = from < least ? number : whose;
                least = from < least ? from : least;
            }
            std::memcpy(&clearance[i], &least, sizeof least);
            std::memcpy(&cap[i], &whose, sizeof whose);
        }
    }
};

// Which directions are exposed, with their least clearance: a few caps hide most of the others.
class ExposedDirections {
public:
    explicit ExposedDirections(const std::vector<Vec3>& directions)
        : all_(directions),
          left_(all_),
          clearance_(all_.size()),
          cap_(all_.size()),
          number_(directions.size()),
          directions_(directions.size()) {}

    // Calls visit(direction, clearance, cap).
    template <typename Visit>
    void forAll(const Caps& caps, const Visit& visit) {
        const std::size_t every = std::max<std::size_t>(1, caps.size() / kFewCaps);
        onThisCpu(FindNearest{all_, directions_, caps, every, clearance_, cap_});
        std::size_t left = 0;
        for (std::uint32_t d = 0; d < directions_; ++d) {
            number_[left] = d;
            left_.x[left] = all_.x[d], left_.y[left] = all_.y[d], left_.z[left] = all_.z[d];
            left += clearance_[d] > 0;
        }
        onThisCpu(FindNearest{left_, left, caps, 1, clearance_, cap_});
        for (std::size_t i = 0; i < left; ++i)
            if (clearance_[i] > 0) visit(number_[i], clearance_[i], static_cast<std::int32_t>(cap_[i]));
    }

private:
    static constexpr std::size_t kFewCaps = 16;

    DirectionColumns all_, left_;
    std::vector<float> clearance_, cap_;
    std::vector<std::uint32_t> number_;
    std::size_t directions_;
};

// The same for one direction; or any clearance that is too little.
std::pair<double, std::int32_t> nearestCap(const Caps& caps, const Vec3& direction, double too_little) {
    std::pair<double, std::int32_t> nearest{kFullClearance, -1};
    for (std::size_t k = 0; k < caps.size() && nearest.first > too_little; ++k) {
        const Vec3 axis(caps.x[k], caps.y[k], caps.z[k]);
        const double clearance = (caps.cosine[k] - dot(direction, axis)) * caps.scale[k];
        if (clearance < nearest.first) nearest = {clearance, static_cast<std::int32_t>(k)};
    }
    return nearest;
}

struct Part {
    std::vector<std::uint32_t> count, direction;
    std::vector<Rate> clearance;
    std::vector<FacePoints::Contact> contact;
};

// Is there a point so near already that another one would make no difference?
bool isThere(const Vec3& towards, const std::vector<Vec3>& directions, const Part& part, std::size_t first) {
    for (std::size_t p = first; p < part.direction.size(); ++p) {
        const std::uint32_t d = part.direction[p];
        const Vec3& other =
            d < directions.size() ? directions[d] : part.contact[d - directions.size()].direction.position;
        if ((towards - other).length2() < kOnePoint * kOnePoint) return true;
    }
    return false;
}

// How the clearance from one cap changes. offset: from the ball to the other one, in radii.
Rate movingClearance(const Moving& direction, const Moving& offset) {
    const Rate distance = length(offset), cosine = distance / 2;
    const Rate sine = squareRoot(1 - cosine * cosine);
    const Rate along = dot(direction, offset) / distance;
    const Rate width = sine.value < kWide ? sine * sine / kWide : sine;
    return (cosine - along) / width;
}

// Of each ball, the others that are about to touch it.
std::vector<std::vector<std::uint32_t>> nearlyTouching(const BallBoundary& boundary) {
    const double diameter = 2 * static_cast<double>(boundary.radius), reach = diameter * (1 + kNearlyTouching / 2);
    std::vector<Vec3> position(boundary.position.size());
    parallelFor(position.size(), 4096, [&](std::size_t b) { position[b] = toDouble(boundary.position[b]); });
    const auto positionOf = [&](std::size_t b) -> const Vec3& { return position[b]; };
    const CellOrder order(boundary.position.size(), reach, positionOf);
    std::vector<std::vector<std::uint32_t>> near(boundary.position.size());
    forCellsWithin(reach, order, order, positionOf, [&](std::uint32_t cell, std::span<const std::uint32_t> around) {
        std::vector<Vec3> place;
        for (const std::uint32_t b : around) place.push_back(position[b]);
        std::vector<std::uint32_t> found(around.size() + 1);
        for (const std::uint32_t row : order.rowsOf(cell)) {
            const Vec3 here = position[row];
            std::size_t n = 0;
            for (std::size_t k = 0; k < place.size(); ++k) {
                const double squared = (place[k] - here).length2();
                found[n] = around[k];
                n += (squared > diameter * diameter) & (squared < reach * reach);
            }
            std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n));
            near[row].assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n));
        }
    });
    return near;
}

}  // namespace

FacePoints facePoints(const SnappedParticles& particles, const BallBoundary& boundary, const std::vector<Moving>& balls,
                      const std::vector<Vec3>& spins, double angle) {
    FacePoints points;
    points.directions = icosphere(static_cast<std::uint32_t>(std::ceil(kIcosahedronAngle / angle)));
    const double radius = static_cast<double>(boundary.radius);

    std::vector<std::uint32_t> ball_of(particles.size(), kBuried);  // exposed ones alone move
    for (std::uint32_t b = 0; b < balls.size(); ++b) ball_of[boundary.snapped_row[b]] = b;

    const std::size_t directions = points.directions.position.size();
    const std::vector<std::vector<std::uint32_t>> near = nearlyTouching(boundary);
    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<Part> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        Part& part = parts[task];
        NeighbourFinder finder(particles);
        std::vector<Neighbour> neighbours;
        Caps caps;
        ExposedDirections exposed(points.directions.position);
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            finder.find(boundary.snapped_row[b], neighbours);
            caps.of(neighbours, radius);
            const std::size_t before = part.direction.size();
            // least: of the clearances from all caps; cap: the one whose that is, or -1
            const auto add = [&](std::uint32_t d, const Moving& outwards, double least, std::int32_t cap) {
                part.direction.push_back(d);
                const std::uint32_t other = cap < 0 ? kBuried : ball_of[caps.particle[static_cast<std::size_t>(cap)]];
                part.clearance.push_back(
                    other == kBuried ? Rate(least)
                                     : movingClearance(outwards, (balls[other] - balls[b]) / boundary.worldRadius()));
            };
            exposed.forAll(caps, [&](std::uint32_t d, double least, std::int32_t cap) {
                const Vec3& along = points.directions.position[d];
                add(d, {along, cross(spins[b], along)}, least, cap);
            });
            for (const std::uint32_t other : near[b]) {
                const Moving offset = (balls[other] - balls[b]) / boundary.worldRadius();
                const Rate distance = length(offset);
                const Moving towards = offset / distance;
                const auto [least, cap] = nearestCap(caps, towards.position, kOnePoint);
                if (!(least > kOnePoint) || isThere(towards.position, points.directions.position, part, before))
                    continue;
                add(static_cast<std::uint32_t>(directions + part.contact.size()), towards, least, cap);
                part.contact.push_back({towards, 1 - (distance - 2) / kNearlyTouching});
            }
            part.count.push_back(static_cast<std::uint32_t>(part.direction.size() - before));
        }
    });

    std::vector<std::uint32_t> contacts;  // of each task; those of earlier ones come first
    for (const Part& part : parts) contacts.push_back(static_cast<std::uint32_t>(part.contact.size()));
    contacts = placesOf(contacts);
    parallelFor(tasks, 4, [&](std::size_t task) {
        for (std::uint32_t& d : parts[task].direction) d += d < directions ? 0 : contacts[task];
    });
    points.begin = placesOf(joined(parts, &Part::count));
    points.direction = joined(parts, &Part::direction);
    points.clearance = joined(parts, &Part::clearance);
    points.contact = joined(parts, &Part::contact);
    return points;
}

}  // namespace betamesh
