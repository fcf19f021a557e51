
#include "sample/liquid.h"

#include "base/index.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace betamesh {

namespace {

constexpr double kCourant = 0.8;        // cells that the fastest particle may cross in one step
constexpr double kMinDistance = 0.4;    // cells; particles closer than this repel each other
constexpr double kRepulsion = 0.1;      // fraction of the missing distance that one step restores
constexpr double kMaxRepulsion = 0.02;  // cells per step
constexpr double kSolidGap = 0.05;      // cells that particles keep from solids

constexpr double kDensityCorrection = 0.1;  // fraction of the excess density that one step removes
constexpr int kMaxIterations = 300;         // of the pressure solver
constexpr double kPressureError = 1e-4;     // residual, relative to the right-hand side

// Cells are sorted by a key made of z, y and x, so that neighbours along x have consecutive keys.
constexpr std::int64_t kBias = 1 << 20, kStepX = 1, kStepY = std::int64_t{1} << 21, kStepZ = std::int64_t{1} << 42;

std::int64_t keyOf(const Vec3i& cell) {
    return (cell.x + kBias) * kStepX + (cell.y + kBias) * kStepY + (cell.z + kBias) * kStepZ;
}

Vec3i cellOf(std::int64_t key) {
    const std::int64_t mask = kStepY - 1;
    return {(key & mask) - kBias, ((key >> 21) & mask) - kBias, (key >> 42) - kBias};
}

Vec3i cellAt(const Vec3& p) {
    return {static_cast<std::int64_t>(std::floor(p.x)), static_cast<std::int64_t>(std::floor(p.y)),
            static_cast<std::int64_t>(std::floor(p.z))};
}

// Adds in blocks of fixed size, so that the sum is the same for any number of threads.
template <typename Term>
double sum(std::size_t n, const Term& term) {
    constexpr std::size_t kBlock = 2048;
    std::vector<double> blocks((n + kBlock - 1) / kBlock, 0);
    parallelFor(blocks.size(), 2, [&](std::size_t b) {
        double total = 0;
        for (std::size_t i = b * kBlock; i < std::min(n, (b + 1) * kBlock); ++i) total += term(i);
        blocks[b] = total;
    });
    return std::accumulate(blocks.begin(), blocks.end(), 0.0);
}

// Sparse grid: the cells that contain particles and their 26 neighbours. Row r = (dy + 1) + 3 (dz + 1) of the
// neighbourhood of cell c is up to three cells with consecutive keys, which start at index first[r][c].
struct Grid {
    std::vector<std::int64_t> key;        // ascending
    std::vector<std::uint32_t> particle;  // cell c contains particles particle[c] … particle[c + 1] - 1
    std::vector<std::uint8_t> solid;
    std::array<std::vector<std::uint32_t>, 9> first;
    std::array<std::vector<double>, 3> speed;         // normal to the lower face of each cell along each axis
    std::array<std::vector<std::uint8_t>, 3> active;  // 1 where liquid touches that face: the pressure acts on it

    std::size_t size() const { return key.size(); }
    bool wet(std::size_t c) const { return particle[c] != particle[c + 1] && !solid[c]; }
    std::int64_t rowKey(std::size_t c, std::size_t r) const {
        return key[c] + (static_cast<std::int64_t>(r % 3) - 1) * kStepY +
               (static_cast<std::int64_t>(r / 3) - 1) * kStepZ;
    }
    // The neighbour of cell c along an axis, step -1 or 1; kInvalidIndex if the grid does not contain it.
    std::uint32_t neighbourOf(std::size_t c, int axis, int step) const {
        static constexpr std::size_t kRows[3][2] = {{4, 4}, {3, 5}, {1, 7}};
        const std::size_t r = kRows[axis][step > 0];
        const std::int64_t wanted = rowKey(c, r) + (axis == 0 ? step : 0);
        for (std::uint32_t n = first[r][c]; n < size() && key[n] <= wanted; ++n)
            if (key[n] == wanted) return n;
        return kInvalidIndex;
    }
    // Calls body(begin, end) for up to nine ranges of particles: those in the 27 cells around c.
    template <typename Body>
    void particlesAround(std::size_t c, const Body& body) const {
        for (std::size_t r = 0; r < 9; ++r) {
            std::uint32_t last = first[r][c];
            while (last < size() && key[last] <= rowKey(c, r) + 1) ++last;
            if (particle[first[r][c]] != particle[last]) body(particle[first[r][c]], particle[last]);
        }
    }
};

template <typename T>
void permute(std::vector<T>& column, const std::vector<std::uint32_t>& order) {
    std::vector<T> result(column.size());
    parallelFor(order.size(), 4096, [&](std::size_t i) { result[i] = column[order[i]]; });
    column = std::move(result);
}

// Sorts the particles by cell, then id; returns the key of each one's cell.
std::vector<std::int64_t> sortIntoCells(Liquid& liquid) {
    const std::size_t n = liquid.id.size();
    std::vector<std::int64_t> key(n);
    std::vector<std::uint32_t> order(n);
    parallelFor(n, 4096, [&](std::size_t i) {
        key[i] = keyOf(cellAt(liquid.position[i]));
        order[i] = static_cast<std::uint32_t>(i);
    });
    parallelSort(order, [&](std::uint32_t a, std::uint32_t b) {
        return key[a] != key[b] ? key[a] < key[b] : liquid.id[a] < liquid.id[b];
    });
    permute(liquid.position, order);
    permute(liquid.velocity, order);
    permute(liquid.gradient, order);
    permute(liquid.id, order);
    permute(key, order);
    return key;
}

std::vector<std::int64_t> withNeighbours(const std::vector<std::int64_t>& keys, std::int64_t step) {
    std::vector<std::int64_t> up = keys, down = keys, some, all;
    for (std::int64_t& key : up) key += step;
    for (std::int64_t& key : down) key -= step;
    std::set_union(keys.begin(), keys.end(), up.begin(), up.end(), std::back_inserter(some));
    std::set_union(some.begin(), some.end(), down.begin(), down.end(), std::back_inserter(all));
    return all;
}

Grid gridOf(const std::vector<std::int64_t>& particle_keys, const Surroundings& surroundings) {
    Grid grid;
    std::vector<std::int64_t> occupied;
    std::unique_copy(particle_keys.begin(), particle_keys.end(), std::back_inserter(occupied));
    grid.key = withNeighbours(withNeighbours(withNeighbours(occupied, kStepX), kStepY), kStepZ);

    const std::size_t n = grid.size();
    grid.particle.resize(n + 1);
    grid.solid.resize(n);
    for (std::vector<std::uint32_t>& row : grid.first) row.resize(n);
    grid.particle[n] = static_cast<std::uint32_t>(particle_keys.size());
    parallelRanges(n, 2048, [&](std::size_t begin, std::size_t end) {
        // Keys ascend, and so do the indices found for them: one binary search per range, then a linear scan.
        auto first_particle = std::lower_bound(particle_keys.begin(), particle_keys.end(), grid.key[begin]);
        for (std::size_t c = begin; c < end; ++c) {
            while (first_particle != particle_keys.end() && *first_particle < grid.key[c]) ++first_particle;
            grid.particle[c] = static_cast<std::uint32_t>(first_particle - particle_keys.begin());
            grid.solid[c] = surroundings.solid(cellOf(grid.key[c]));
        }
        for (std::size_t r = 0; r < 9; ++r) {
            auto found = std::lower_bound(grid.key.begin(), grid.key.end(), grid.rowKey(begin, r) - 1);
            for (std::size_t c = begin; c < end; ++c) {
                while (found != grid.key.end() && *found < grid.rowKey(c, r) - 1) ++found;
                grid.first[r][c] = static_cast<std::uint32_t>(found - grid.key.begin());
            }
        }
    });
    return grid;
}

// Trilinear weight of a face at a particle, both relative to the cell's lower corner; zero from a distance of one cell.
double weight(const Vec3& particle, const Vec3& face) {
    const double x = 1 - std::abs(particle.x - face.x);
    const double y = 1 - std::abs(particle.y - face.y);
    const double z = 1 - std::abs(particle.z - face.z);
    return x > 0 && y > 0 && z > 0 ? x * y * z : 0;
}

constexpr double kHalf = 0.5;
Vec3 faceCentre(int axis) { return {axis == 0 ? 0 : kHalf, axis == 1 ? 0 : kHalf, axis == 2 ? 0 : kHalf}; }

// Transfers velocities from particles to cell faces.
void gatherSpeeds(Grid& grid, const Liquid& liquid) {
    for (std::vector<double>& speed : grid.speed) speed.assign(grid.size(), 0);
    parallelFor(grid.size(), 64, [&](std::size_t c) {
        const Vec3 corner = toDouble(cellOf(grid.key[c]));
        std::array<double, 3> total{}, weights{};
        grid.particlesAround(c, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t p = begin; p < end; ++p) {
                const Vec3 at = liquid.position[p] - corner;
                for (int axis = 0; axis < 3; ++axis) {
                    const double w = weight(at, faceCentre(axis));
                    if (w == 0) continue;
                    const auto a = static_cast<std::size_t>(axis);
                    total[a] += w * (liquid.velocity[p][axis] + dot(liquid.gradient[p][a], faceCentre(axis) - at));
                    weights[a] += w;
                }
            }
        });
        for (std::size_t a = 0; a < 3; ++a)
            if (weights[a] > 0) grid.speed[a][c] = total[a] / weights[a];
    });
}

// Applies gravity, stops the flow at the faces of solids and marks the faces on which the pressure acts.
void applyForces(Grid& grid, const Surroundings& surroundings, double dt) {
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double>& speed = grid.speed[static_cast<std::size_t>(axis)];
        std::vector<std::uint8_t>& active = grid.active[static_cast<std::size_t>(axis)];
        active.assign(grid.size(), 0);
        parallelFor(grid.size(), 1024, [&](std::size_t c) {
            speed[c] += surroundings.gravity[axis] * dt;
            const std::uint32_t below = grid.neighbourOf(c, axis, -1);
            if (below == kInvalidIndex) return;
            if (grid.solid[c] != grid.solid[below]) speed[c] = 0;
            active[c] = grid.wet(c) || grid.wet(below);
        });
    }
}

// Makes the velocity field free of divergence; in cells with too many particles it diverges to reduce their density.
// The pressure of air is 0.
void project(Grid& grid, double particles_per_cell, double dt) {
    std::vector<std::uint32_t> wet;  // cells
    std::vector<std::uint32_t> row(grid.size(), kInvalidIndex);
    for (std::size_t c = 0; c < grid.size(); ++c) {
        if (!grid.wet(c)) continue;
        row[c] = static_cast<std::uint32_t>(wet.size());
        wet.push_back(static_cast<std::uint32_t>(c));
    }
    const std::size_t n = wet.size();
    std::vector<std::array<std::uint32_t, 6>> neighbour(n);  // rows; kInvalidIndex for air and solid
    std::vector<double> diagonal(n, 0), residual(n), pressure(n, 0), search(n), image(n);
    parallelFor(n, 512, [&](std::size_t i) {
        const std::size_t c = wet[i];
        double divergence = 0;
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2, step = side % 2 == 0 ? -1 : 1;
            const std::uint32_t other = grid.neighbourOf(c, axis, step);
            neighbour[i][static_cast<std::size_t>(side)] = row[other];
            if (!grid.solid[other]) diagonal[i] += 1;
            divergence += step * grid.speed[static_cast<std::size_t>(axis)][step < 0 ? c : other];
        }
        const double excess = (grid.particle[c + 1] - grid.particle[c]) / particles_per_cell - 1;
        residual[i] = -divergence + kDensityCorrection * std::clamp(excess, 0.0, 1.0) / dt;
    });

    // Conjugate gradients, preconditioned by the diagonal.
    const auto scaled = [&](std::size_t i) { return diagonal[i] > 0 ? residual[i] / diagonal[i] : 0; };
    const double tolerance =
        kPressureError * kPressureError * sum(n, [&](std::size_t i) { return residual[i] * scaled(i); });
    double size = sum(n, [&](std::size_t i) { return residual[i] * scaled(i); });
    parallelFor(n, 4096, [&](std::size_t i) { search[i] = scaled(i); });
    for (int iteration = 0; iteration < kMaxIterations && size > tolerance; ++iteration) {
        parallelFor(n, 1024, [&](std::size_t i) {
            double value = diagonal[i] * search[i];
            for (const std::uint32_t other : neighbour[i])
                if (other != kInvalidIndex) value -= search[other];
            image[i] = value;
        });
        const double step = size / sum(n, [&](std::size_t i) { return search[i] * image[i]; });
        parallelFor(n, 4096, [&](std::size_t i) {
            pressure[i] += step * search[i];
            residual[i] -= step * image[i];
        });
        const double next = sum(n, [&](std::size_t i) { return residual[i] * scaled(i); });
        parallelFor(n, 4096, [&](std::size_t i) { search[i] = scaled(i) + next / size * search[i]; });
        size = next;
    }

    const auto pressureIn = [&](std::uint32_t c) { return row[c] == kInvalidIndex ? 0 : pressure[row[c]]; };
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        parallelFor(grid.size(), 1024, [&](std::size_t c) {
            if (!grid.active[a][c]) return;
            const std::uint32_t below = grid.neighbourOf(c, axis, -1);
            if (grid.solid[c] || grid.solid[below]) return;
            grid.speed[a][c] -= pressureIn(static_cast<std::uint32_t>(c)) - pressureIn(below);
        });
    }
}

// Sets the speed on faces without liquid to the mean of the neighbouring faces with liquid.
void extrapolate(Grid& grid) {
    for (std::size_t a = 0; a < 3; ++a) {
        std::vector<double> speed = grid.speed[a];
        parallelFor(grid.size(), 1024, [&](std::size_t c) {
            if (grid.active[a][c]) return;
            const std::uint32_t below = grid.neighbourOf(c, static_cast<int>(a), -1);
            if (below == kInvalidIndex || grid.solid[c] != grid.solid[below]) return;
            double total = 0;
            int count = 0;
            for (int side = 0; side < 6; ++side) {
                const std::uint32_t other = grid.neighbourOf(c, side / 2, side % 2 == 0 ? -1 : 1);
                if (other == kInvalidIndex || !grid.active[a][other]) continue;
                total += grid.speed[a][other];
                ++count;
            }
            if (count > 0) speed[c] = total / count;
        });
        grid.speed[a] = std::move(speed);
    }
}

// Forces between particles. Repulsion (a displacement in cells) by those that are too close prevents clumps. Attraction
// (a weighted sum of unit vectors) to those half a cell to a cell away cancels out inside the liquid and acts as
// surface tension at its surface, rims and threads.
struct ParticleForces {
    Vec3 repulsion{0, 0, 0}, attraction{0, 0, 0};
};

ParticleForces particleForces(const Grid& grid, const Liquid& liquid, std::size_t c, std::size_t p) {
    ParticleForces total;
    grid.particlesAround(c, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t other = begin; other < end; ++other) {
            const Vec3 away = liquid.position[p] - liquid.position[other];
            const double squared = away.length2();
            if (squared >= 1 || squared == 0) continue;
            const double distance = std::sqrt(squared);
            if (distance < kMinDistance) total.repulsion += away * (kRepulsion * (kMinDistance - distance) / distance);
            if (distance > 0.5) total.attraction -= away * (16 * (distance - 0.5) * (1 - distance) / distance);
        }
    });
    const double length = total.repulsion.length();
    if (length > kMaxRepulsion) total.repulsion *= kMaxRepulsion / length;
    return total;
}

// Moves a particle out of the tank's walls and the obstacle along the shortest path and removes its velocity into them.
void moveOutOfSolids(const Surroundings& surroundings, Vec3& position, Vec3& velocity) {
    if (!surroundings.tank) return;
    const Vec3 low = toDouble(surroundings.tank_box.low), high = toDouble(surroundings.tank_box.high);
    for (int axis = 0; axis < 3; ++axis) {
        if (position[axis] < low[axis] + kSolidGap) {
            position[axis] = low[axis] + kSolidGap;
            velocity[axis] = std::max(velocity[axis], 0.0);
        }
        if (axis != 1 && position[axis] > high[axis] - kSolidGap) {
            position[axis] = high[axis] - kSolidGap;
            velocity[axis] = std::min(velocity[axis], 0.0);
        }
    }
    const Vec3 gap(kSolidGap, kSolidGap, kSolidGap);
    const Vec3 near = toDouble(surroundings.obstacle.low) - gap, far = toDouble(surroundings.obstacle.high) + gap;
    int nearest = -1;
    double shortest = 0, to = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double before = position[axis] - near[axis], after = far[axis] - position[axis];
        if (before <= 0 || after <= 0) return;
        if (axis == 1 ? (nearest < 0 || after < shortest) : (nearest < 0 || std::min(before, after) < shortest)) {
            const bool down = axis != 1 && before < after;  // never down through the floor
            nearest = axis;
            shortest = down ? before : after;
            to = down ? near[axis] : far[axis];
        }
    }
    velocity[nearest] = to == far[nearest] ? std::max(velocity[nearest], 0.0) : std::min(velocity[nearest], 0.0);
    position[nearest] = to;
}

// Transfers velocities from cell faces to particles and moves the particles.
void moveParticles(Liquid& liquid, const Grid& grid, const Surroundings& surroundings, double dt) {
    std::vector<Vec3> position(liquid.position.size());
    parallelFor(grid.size(), 64, [&](std::size_t c) {
        const Vec3 corner = toDouble(cellOf(grid.key[c]));
        for (std::uint32_t p = grid.particle[c]; p < grid.particle[c + 1]; ++p) {
            const Vec3 at = liquid.position[p] - corner;
            for (std::size_t a = 0; a < 3; ++a) {
                double speed = 0;
                Vec3 gradient(0, 0, 0);
                for (int n = 0; n < 27; ++n) {
                    const Vec3 offset(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
                    const Vec3 d = at - offset - faceCentre(static_cast<int>(a));
                    const Vec3 w(1 - std::abs(d.x), 1 - std::abs(d.y), 1 - std::abs(d.z));
                    if (w.x <= 0 || w.y <= 0 || w.z <= 0) continue;
                    // The grid contains all 27 cells around a cell with particles.
                    const std::size_t other =
                        grid.first[static_cast<std::size_t>(n / 3)][c] + static_cast<std::size_t>(n % 3);
                    const double face = grid.speed[a][other];
                    speed += w.x * w.y * w.z * face;
                    gradient += Vec3(d.x > 0 ? -w.y * w.z : w.y * w.z, d.y > 0 ? -w.x * w.z : w.x * w.z,
                                     d.z > 0 ? -w.x * w.y : w.x * w.y) *
                                face;
                }
                liquid.velocity[p][static_cast<int>(a)] = speed;
                liquid.gradient[p][a] = gradient;
            }
            const ParticleForces forces = particleForces(grid, liquid, c, p);
            liquid.velocity[p] += forces.attraction * (surroundings.cohesion * dt);
            position[p] = liquid.position[p] + liquid.velocity[p] * dt + forces.repulsion;
            moveOutOfSolids(surroundings, position[p], liquid.velocity[p]);
        }
    });
    liquid.moved.resize(position.size());
    parallelFor(position.size(), 4096,
                [&](std::size_t p) { liquid.moved[p] = (position[p] - liquid.position[p]) / dt; });
    liquid.position = std::move(position);
}

}  // namespace

bool Surroundings::solid(const Vec3i& cell) const {
    if (!tank) return false;
    return cell.x < tank_box.low.x || cell.y < tank_box.low.y || cell.z < tank_box.low.z || cell.x >= tank_box.high.x ||
           cell.z >= tank_box.high.z || obstacle.contains(cell);
}

void advance(Liquid& liquid, const Surroundings& surroundings, double seconds) {
    if (liquid.position.empty()) return;
    const double speed = largestLength(liquid.velocity) + surroundings.gravity.length() * seconds;
    const int steps = std::max(1, static_cast<int>(std::ceil(speed * seconds / kCourant)));
    const double dt = seconds / steps;
    for (int step = 0; step < steps; ++step) {
        Grid grid = gridOf(sortIntoCells(liquid), surroundings);
        gatherSpeeds(grid, liquid);
        applyForces(grid, surroundings, dt);
        project(grid, surroundings.particles_per_cell, dt);
        extrapolate(grid);
        moveParticles(liquid, grid, surroundings, dt);
    }
}

}  // namespace betamesh
