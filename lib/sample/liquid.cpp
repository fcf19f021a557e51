
#include "sample/liquid.h"

#include "base/index.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace betamesh {

namespace {

constexpr double kCourant = 0.8;       // cells that the fastest particle may cross in one step
constexpr double kApart = 0.4;         // cells; particles closer than this push each other apart
constexpr double kPush = 0.1;          // part of the missing distance that one step makes up
constexpr double kLongestPush = 0.02;  // cells a step
constexpr double kWall = 0.05;         // cells that particles keep from solids

constexpr double kThinning = 0.1;        // part of the crowding above that which one step lets out
constexpr int kSweeps = 300;             // of the pressure, at most
constexpr double kPressureError = 1e-4;  // of the pressure's right-hand side

// Cells are sorted by a key that holds z, y and x, so x neighbours have neighbouring keys.
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


// Cells with particles and all that touch them. Row r = (dy + 1) + 3 (dz + 1) of a cell's neighbourhood is
// up to three cells with neighbouring keys: first[r][c] is where they begin in key[].
struct Grid {
    std::vector<std::int64_t> key;        // ascending
    std::vector<std::uint32_t> particle;  // cell c holds particles particle[c] … particle[c + 1] - 1
    std::vector<std::uint8_t> solid;
    std::array<std::vector<std::uint32_t>, 9> first;
    std::array<std::vector<double>, 3> speed;          // on the lower face of each cell along each axis
    std::array<std::vector<std::uint8_t>, 3> settled;  // does the pressure rule that face?

    std::size_t size() const { return key.size(); }
    bool wet(std::size_t c) const { return particle[c] != particle[c + 1] && !solid[c]; }
    std::int64_t rowKey(std::size_t c, std::size_t r) const {
        return key[c] + (static_cast<std::int64_t>(r % 3) - 1) * kStepY +
               (static_cast<std::int64_t>(r / 3) - 1) * kStepZ;
    }
    // The cell one step away along an axis, or none.
    std::uint32_t beside(std::size_t c, int axis, int step) const {
        static constexpr std::size_t kRows[3][2] = {{4, 4}, {3, 5}, {1, 7}};
        const std::size_t r = kRows[axis][step > 0];
        const std::int64_t wanted = rowKey(c, r) + (axis == 0 ? step : 0);
        for (std::uint32_t n = first[r][c]; n < size() && key[n] <= wanted; ++n)
            if (key[n] == wanted) return n;
        return kInvalidIndex;
    }
    // Calls body(begin, end) for the particles of the 27 cells round c, in at most nine pieces.
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

std::vector<std::int64_t> widened(const std::vector<std::int64_t>& keys, std::int64_t step) {
    std::vector<std::int64_t> up = keys, down = keys, some, all;
    for (std::int64_t& key : up) key += step;
    for (std::int64_t& key : down) key -= step;
    std::set_union(keys.begin(), keys.end(), up.begin(), up.end(), std::back_inserter(some));
    std::set_union(some.begin(), some.end(), down.begin(), down.end(), std::back_inserter(all));
    return all;
}

Grid gridOf(const std::vector<std::int64_t>& particle_keys, const Surroundings& surroundings) {
    Grid grid;
    std::vector<std::int64_t> held;
    std::unique_copy(particle_keys.begin(), particle_keys.end(), std::back_inserter(held));
    grid.key = widened(widened(widened(held, kStepX), kStepY), kStepZ);

    const std::size_t n = grid.size();
    grid.particle.resize(n + 1);
    grid.solid.resize(n);
    for (std::vector<std::uint32_t>& row : grid.first) row.resize(n);
    grid.particle[n] = static_cast<std::uint32_t>(particle_keys.size());
    parallelRanges(n, 2048, [&](std::size_t begin, std::size_t end) {
        // Keys ascend, and so do the places they are looked up at: one search, then steps.
        auto holds = std::lower_bound(particle_keys.begin(), particle_keys.end(), grid.key[begin]);
        for (std::size_t c = begin; c < end; ++c) {
            while (holds != particle_keys.end() && *holds < grid.key[c]) ++holds;
            grid.particle[c] = static_cast<std::uint32_t>(holds - particle_keys.begin());
            grid.solid[c] = surroundings.solid(cellOf(grid.key[c]));
        }
        for (std::size_t r = 0; r < 9; ++r) {
            auto at = std::lower_bound(grid.key.begin(), grid.key.end(), grid.rowKey(begin, r) - 1);
            for (std::size_t c = begin; c < end; ++c) {
                while (at != grid.key.end() && *at < grid.rowKey(c, r) - 1) ++at;
                grid.first[r][c] = static_cast<std::uint32_t>(at - grid.key.begin());
            }
        }
    });
    return grid;
}

// Weight of a face at a particle, both relative to the cell's lower corner; zero one cell away.
double weight(const Vec3& particle, const Vec3& face) {
    const double x = 1 - std::abs(particle.x - face.x);
    const double y = 1 - std::abs(particle.y - face.y);
    const double z = 1 - std::abs(particle.z - face.z);
    return x > 0 && y > 0 && z > 0 ? x * y * z : 0;
}

constexpr double kHalf = 0.5;
Vec3 faceCentre(int axis) { return {axis == 0 ? 0 : kHalf, axis == 1 ? 0 : kHalf, axis == 2 ? 0 : kHalf}; }

// Particles -> speeds on the faces.
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

// Gravity; then stillness where a solid begins; then marks the faces that the pressure rules.
void applyForces(Grid& grid, const Surroundings& surroundings, double dt) {
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double>& speed = grid.speed[static_cast<std::size_t>(axis)];
        std::vector<std::uint8_t>& settled = grid.settled[static_cast<std::size_t>(axis)];
        settled.assign(grid.size(), 0);
        parallelFor(grid.size(), 1024, [&](std::size_t c) {
            speed[c] += surroundings.gravity[axis] * dt;
            const std::uint32_t below = grid.beside(c, axis, -1);
            if (below == kInvalidIndex) return;
            if (grid.solid[c] != grid.solid[below]) speed[c] = 0;
            settled[c] = grid.wet(c) || grid.wet(below);
        });
    }
}

// Makes the flow free of divergence, save that crowded cells let some out. Air has pressure 0.
void project(Grid& grid, double full, double dt) {
    std::vector<std::uint32_t> wet;  // cells
    std::vector<std::uint32_t> row(grid.size(), kInvalidIndex);
    for (std::size_t c = 0; c < grid.size(); ++c) {
        if (!grid.wet(c)) continue;
        row[c] = static_cast<std::uint32_t>(wet.size());
        wet.push_back(static_cast<std::uint32_t>(c));
    }
    const std::size_t n = wet.size();
    std::vector<std::array<std::uint32_t, 6>> neighbour(n);  // rows, none for air and solid
    std::vector<double> diagonal(n, 0), residual(n), pressure(n, 0), search(n), image(n);
    parallelFor(n, 512, [&](std::size_t i) {
        const std::size_t c = wet[i];
        double divergence = 0;
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2, step = side % 2 == 0 ? -1 : 1;
            const std::uint32_t other = grid.beside(c, axis, step);
            neighbour[i][static_cast<std::size_t>(side)] = row[other];
            if (!grid.solid[other]) diagonal[i] += 1;
            divergence += step * grid.speed[static_cast<std::size_t>(axis)][step < 0 ? c : other];
        }
        const double crowd = (grid.particle[c + 1] - grid.particle[c]) / full - 1;
        residual[i] = -divergence + kThinning * std::clamp(crowd, 0.0, 1.0) / dt;
    });

    // Conjugate gradients with the diagonal as preconditioner.
    const auto scaled = [&](std::size_t i) { return diagonal[i] > 0 ? residual[i] / diagonal[i] : 0; };
    const double enough =
        kPressureError * kPressureError * sum(n, [&](std::size_t i) { return residual[i] * scaled(i); });
    double size = sum(n, [&](std::size_t i) { return residual[i] * scaled(i); });
    parallelFor(n, 4096, [&](std::size_t i) { search[i] = scaled(i); });
    for (int sweep = 0; sweep < kSweeps && size > enough; ++sweep) {
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
            if (!grid.settled[a][c]) return;
            const std::uint32_t below = grid.beside(c, axis, -1);
            if (grid.solid[c] || grid.solid[below]) return;
            grid.speed[a][c] -= pressureIn(static_cast<std::uint32_t>(c)) - pressureIn(below);
        });
    }
}

// Faces that the pressure does not rule take the mean of neighbours that it does rule.
void extrapolate(Grid& grid) {
    for (std::size_t a = 0; a < 3; ++a) {
        std::vector<double> speed = grid.speed[a];
        parallelFor(grid.size(), 1024, [&](std::size_t c) {
            if (grid.settled[a][c]) return;
            const std::uint32_t below = grid.beside(c, static_cast<int>(a), -1);
            if (below == kInvalidIndex || grid.solid[c] != grid.solid[below]) return;
            double total = 0;
            int count = 0;
            for (int side = 0; side < 6; ++side) {
                const std::uint32_t other = grid.beside(c, side / 2, side % 2 == 0 ? -1 : 1);
                if (other == kInvalidIndex || !grid.settled[a][other]) continue;
                total += grid.speed[a][other];
                ++count;
            }
            if (count > 0) speed[c] = total / count;
        });
        grid.speed[a] = std::move(speed);
    }
}

// What a particle feels from others nearby: a push (cells) from those that are too close, which keeps them
// from clumping, and a pull (sum of unit vectors, weighted) towards those half a cell to a cell away, which
// cancels inside the liquid and draws its surface, rims and threads together.
struct Touch {
    Vec3 push{0, 0, 0}, pull{0, 0, 0};
};

Touch touch(const Grid& grid, const Liquid& liquid, std::size_t c, std::size_t p) {
    Touch total;
    grid.particlesAround(c, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t other = begin; other < end; ++other) {
            const Vec3 away = liquid.position[p] - liquid.position[other];
            const double squared = away.length2();
            if (squared >= 1 || squared == 0) continue;
            const double distance = std::sqrt(squared);
            if (distance < kApart) total.push += away * (kPush * (kApart - distance) / distance);
            if (distance > 0.5) total.pull -= away * (16 * (distance - 0.5) * (1 - distance) / distance);
        }
    });
    const double length = total.push.length();
    if (length > kLongestPush) total.push *= kLongestPush / length;
    return total;
}

// Out of the tank's walls and the obstacle by the nearest way; speed into a solid is lost.
void keepOut(const Surroundings& surroundings, Vec3& position, Vec3& velocity) {
    if (!surroundings.tank) return;
    const Vec3 low = toDouble(surroundings.tank_box.low), high = toDouble(surroundings.tank_box.high);
    for (int axis = 0; axis < 3; ++axis) {
        if (position[axis] < low[axis] + kWall) {
            position[axis] = low[axis] + kWall;
            velocity[axis] = std::max(velocity[axis], 0.0);
        }
        if (axis != 1 && position[axis] > high[axis] - kWall) {
            position[axis] = high[axis] - kWall;
            velocity[axis] = std::min(velocity[axis], 0.0);
        }
    }
    const Vec3 wall(kWall, kWall, kWall);
    const Vec3 near = toDouble(surroundings.obstacle.low) - wall, far = toDouble(surroundings.obstacle.high) + wall;
    int nearest = -1;
    double shortest = 0, to = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double before = position[axis] - near[axis], after = far[axis] - position[axis];
        if (before <= 0 || after <= 0) return;
        if (axis == 1 ? (nearest < 0 || after < shortest) : (nearest < 0 || std::min(before, after) < shortest)) {
            const bool down = axis != 1 && before < after;  // never through the floor
            nearest = axis;
            shortest = down ? before : after;
            to = down ? near[axis] : far[axis];
        }
    }
    velocity[nearest] = to == far[nearest] ? std::max(velocity[nearest], 0.0) : std::min(velocity[nearest], 0.0);
    position[nearest] = to;
}

// Speeds on the faces -> particles, and on they go.
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
                    // A cell with particles has all 27 cells round it.
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
            const Touch felt = touch(grid, liquid, c, p);
            liquid.velocity[p] += felt.pull * (surroundings.cohesion * dt);
            position[p] = liquid.position[p] + liquid.velocity[p] * dt + felt.push;
            keepOut(surroundings, position[p], liquid.velocity[p]);
        }
    });
    liquid.moved.resize(position.size());
    parallelFor(position.size(), 4096,
                [&](std::size_t p) { liquid.moved[p] = (position[p] - liquid.position[p]) / dt; });
    liquid.position = std::move(position);
}

double fastest(const Liquid& liquid) {
    double squared = 0;
    for (const Vec3& velocity : liquid.velocity) squared = std::max(squared, velocity.length2());
    return std::sqrt(squared);
}

}  // namespace

bool Surroundings::solid(const Vec3i& cell) const {
    if (!tank) return false;
    return cell.x < tank_box.low.x || cell.y < tank_box.low.y || cell.z < tank_box.low.z || cell.x >= tank_box.high.x ||
           cell.z >= tank_box.high.z || obstacle.contains(cell);
}

void advance(Liquid& liquid, const Surroundings& surroundings, double seconds) {
    if (liquid.position.empty()) return;
    const double speed = fastest(liquid) + surroundings.gravity.length() * seconds;
    const int steps = std::max(1, static_cast<int>(std::ceil(speed * seconds / kCourant)));
    const double dt = seconds / steps;
    for (int step = 0; step < steps; ++step) {
        Grid grid = gridOf(sortIntoCells(liquid), surroundings);
        gatherSpeeds(grid, liquid);
        applyForces(grid, surroundings, dt);
        project(grid, surroundings.crowd, dt);
        extrapolate(grid);
        moveParticles(liquid, grid, surroundings, dt);
    }
}

}  // namespace betamesh
