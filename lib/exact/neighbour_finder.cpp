
#include "exact/neighbour_finder.h"

#include "base/box.h"
#include "base/icosphere.h"
#include "base/simd.h"

#include <algorithm>
#include <limits>

namespace betamesh {

namespace {

constexpr std::size_t kSampledCandidates = 1024;  // candidates of an octant from which on a sample replaces them
constexpr std::size_t kSampleSize = 512;          // evenly chosen candidates of a sample

// The balls of one cell of a size class.
std::span<const SizeClass::Ball> ballsIn(const SizeClass& size_class, std::size_t cell) {
    const auto c = static_cast<std::uint32_t>(cell);
    const std::uint32_t begin = size_class.cells.begin(c), end = size_class.cells.begin(c + 1);
    return std::span(size_class.ball).subspan(begin, end - begin);
}

// Turns squared distances of balls into numbers that are positive where a ball neither touches one of the largest
// radius nor contains one of the smallest.
BETAMESH_EVERY_CPU
void compareWithRadii(const double* radius, std::size_t n, double smallest, double largest, double* squared) {
    for (std::size_t k = 0; k < n; ++k) {
        const double sum = largest + radius[k], margin = smallest - radius[k], inner = margin > 0 ? margin : 0;
        const double beyond = squared[k] - sum * sum, within = inner * inner - squared[k];
        squared[k] = beyond > within ? beyond : within;
    }
}

}  // namespace

void NeighbourFinder::gatherCandidates() {
    corner_ = particles_.cell[cell_.cell] * (2 * particles_.radius);
    edge_ = static_cast<double>(2 * particles_.radius);
    crowd_ = particles_.cell_begin[cell_.cell + 1] - particles_.cell_begin[cell_.cell];
    std::size_t n = 0;
    around_.forEach(cell_.cell, [&](const Vec3i&, std::size_t other) {
        const std::uint32_t begin = particles_.cell_begin[other], end = particles_.cell_begin[other + 1];
        const std::size_t all = n + (end - begin);
        auto& [particle, x, y, z, radius] = of_cell_;
        particle.resize(all), x.resize(all), y.resize(all), z.resize(all);
        for (std::uint32_t k = begin; k < end; ++k, ++n) {
            const Vec3 position = positionInCell(k);
            particle[n] = k, x[n] = position.x, y[n] = position.y, z[n] = position.z;
        }
    });
}

// Gathers the balls of the cell's size class, and of those of larger balls, that can touch one in the cell.
void NeighbourFinder::gatherFromSizeClasses() {
    const std::span<const SizeClass> classes = *particles_.size_classes;
    const SizeClass& own = classes[cell_.size_class];
    const Vec3 low = own.cells.lowestCorner(static_cast<std::uint32_t>(cell_.cell));
    corner_ =
        Vec3i(static_cast<std::int64_t>(low.x), static_cast<std::int64_t>(low.y), static_cast<std::int64_t>(low.z));
    edge_ = own.cells.edge();
    const std::span<const SizeClass::Ball> balls = ballsIn(own, cell_.cell);
    crowd_ = balls.size();
    largest_ = 0;
    Box box;
    for (const SizeClass::Ball& ball : balls) {
        box.extendBy(toDouble(ball.position));
        largest_ = std::max(largest_, static_cast<double>(ball.radius));
    }
    std::vector<std::span<const SizeClass::Ball>> cells;
    for (const SizeClass& size_class : classes.first(cell_.size_class + 1)) {
        const Vec3 reach(largest_ + static_cast<double>(size_class.largest));
        size_class.cells.forCellsIn(box.min - reach, box.max + reach,
                                    [&](std::uint32_t other) { cells.push_back(ballsIn(size_class, other)); });
    }
    std::ranges::sort(cells, {}, [](const auto& in_cell) { return in_cell.front().particle; });
    auto& [particle, x, y, z, radius] = of_cell_;
    particle.clear(), x.clear(), y.clear(), z.clear(), radius.clear();
    for (const auto& in_cell : cells)
        for (const SizeClass::Ball& ball : in_cell) {
            const double reach = largest_ + ball.radius;
            if (squaredDistance(box, toDouble(ball.position)) > reach * reach) continue;
            const Vec3 position = toDouble(ball.position - corner_);
            particle.push_back(ball.particle), radius.push_back(ball.radius);
            x.push_back(position.x), y.push_back(position.y), z.push_back(position.z);
        }
}

void NeighbourFinder::enterCellOf(std::uint32_t particle) {
    CellOfClass cell{0, cell_.cell};
    if (particles_.size_classes) {
        const std::vector<SizeClass>& classes = *particles_.size_classes;
        while (cell.size_class + 1 < classes.size() &&
               particles_.radius_of[particle] <= classes[cell.size_class + 1].largest)
            ++cell.size_class;
        const Vec3 position = toDouble(particles_.position[particle]);
        classes[cell.size_class].cells.forCellsIn(position, position, [&](std::uint32_t c) { cell.cell = c; });
        if (cell == cell_) return;
        cell_ = cell;
        gatherFromSizeClasses();
    } else {
        const std::vector<std::uint32_t>& begin = particles_.cell_begin;
        if (cell.cell != ~std::size_t{0} && particle >= begin[cell.cell] && particle < begin[cell.cell + 1]) return;
        const auto next = std::upper_bound(begin.begin(), begin.end(), particle);
        cell_.cell = static_cast<std::size_t>(next - begin.begin()) - 1;
        gatherCandidates();
    }
    measure_.resize(of_cell_.particle.size());
    found_.resize(of_cell_.particle.size() + 1);
    for (auto& octants : of_octant_)
        for (Candidates& octant : octants) octant.particle.clear();
}

// Indices of the candidates within reach of balls with centres in a box.
std::span<const std::uint32_t> NeighbourFinder::within(Reach reach, const Candidates& candidates, const Box& box,
                                                       const RadiusRange& radii) {
    const auto& [particle, x, y, z, radius] = candidates;
    squaredDistances(box, x.data(), y.data(), z.data(), particle.size(), measure_.data());  // integers, hence exact
    double most = 0;
    if (radius.empty()) {
        const std::int64_t farthest = (reach == within_diameter ? 2 : 1) * particles_.radius;
        most = static_cast<double>(farthest * farthest);
    } else {
        compareWithRadii(radius.data(), particle.size(), radii.smallest, radii.largest, measure_.data());
    }
    std::size_t found = 0;
    for (std::uint32_t k = 0; k < particle.size(); ++k) {
        found_[found] = k;
        found += measure_[k] <= most;
    }
    return std::span(found_).first(found);
}

// Indices of evenly chosen candidates and of the extreme ones in fixed directions; balls of these cover most others.
std::span<const std::uint32_t> NeighbourFinder::sampleOf(const Candidates& candidates) {
    static const std::vector<Vec3> directions = icosphere(1).position;
    const std::size_t n = candidates.particle.size();
    std::size_t found = 0;
    while (found < kSampleSize) {
        found_[found] = static_cast<std::uint32_t>(found * n / kSampleSize);
        ++found;
    }
    for (const Vec3& direction : directions) {
        double farthest = -std::numeric_limits<double>::infinity();
        for (std::uint32_t k = 0; k < n; ++k)
            if (const double extent = dot(candidates.at(k), direction); extent > farthest)
                farthest = extent, found_[found] = k;
        ++found;
    }
    return std::span(found_).first(found);
}

// In a dense cell the candidates are narrowed to those within reach of one octant: two in five, or one in eight. The
// many particles of the octant share the list.
const NeighbourFinder::Candidates& NeighbourFinder::candidatesFor(const Vec3& position, Reach reach) {
    if (!isInDenseCell()) return of_cell_;
    const double middle = edge_ / 2;
    const bool upper_x = position.x >= middle, upper_y = position.y >= middle, upper_z = position.z >= middle;
    Candidates& selected = of_octant_[reach][(upper_x ? 1 : 0) + (upper_y ? 2 : 0) + (upper_z ? 4 : 0)];
    if (!selected.particle.empty()) return selected;
    const auto select = [&](const Candidates& from, std::span<const std::uint32_t> indices) {
        const auto copySelected = [&](const auto& all, auto& to) {
            to.resize(all.empty() ? 0 : indices.size());
            for (std::size_t k = 0; k < to.size(); ++k) to[k] = all[indices[k]];
        };
        copySelected(from.particle, selected.particle);
        copySelected(from.x, selected.x);
        copySelected(from.y, selected.y);
        copySelected(from.z, selected.z);
        copySelected(from.radius, selected.radius);
    };
    if (reach == some_within_radius) {
        const Candidates& all = candidatesFor(position, within_radius);
        select(all, sampleOf(all));
    } else {
        const Vec3 low(upper_x ? middle : 0, upper_y ? middle : 0, upper_z ? middle : 0);
        select(of_cell_, within(reach, of_cell_, {low, low + Vec3(middle + 1)}, {0, largest_}));
    }
    return selected;
}

void NeighbourFinder::find(std::uint32_t particle, Reach reach, std::vector<Neighbour>& neighbours) {
    const Vec3 position = positionInCell(particle);
    const Candidates& candidates = candidatesFor(position, reach);
    const auto own = static_cast<double>(particles_.radiusOf(particle));
    const auto near = within(reach, candidates, Box(position), {own, own});
    neighbours.resize(near.size());
    std::size_t found = 0;
    for (const std::uint32_t k : near) {
        const Vec3 offset = candidates.at(k) - position;
        const double radius = candidates.radius.empty() ? own : candidates.radius[k];
        neighbours[found] = {offset, dot(offset, offset) + (own + radius) * (own - radius), candidates.particle[k],
                             static_cast<std::int32_t>(radius)};
        found += candidates.particle[k] != particle;
    }
    neighbours.resize(found);
}

// Adds the balls of smaller size classes that touch the particle's.
void NeighbourFinder::addSmaller(std::uint32_t particle, std::vector<Neighbour>& neighbours) const {
    const std::span<const SizeClass> classes = *particles_.size_classes;
    const Vec3i here = particles_.position[particle];
    const auto own = static_cast<double>(particles_.radius_of[particle]);
    const std::size_t larger = neighbours.size();
    for (const SizeClass& smaller : classes.subspan(cell_.size_class + 1)) {
        const Vec3 position = toDouble(here), reach(own + static_cast<double>(smaller.largest));
        smaller.cells.forCellsIn(position - reach, position + reach, [&](std::uint32_t cell) {
            for (const SizeClass::Ball& ball : ballsIn(smaller, cell)) {
                const Vec3 offset = toDouble(ball.position - here);
                const double squared = dot(offset, offset), sum = own + ball.radius, difference = own - ball.radius;
                if (squared <= sum * sum && squared >= difference * difference)
                    neighbours.push_back({offset, squared + sum * difference, ball.particle, ball.radius});
            }
        });
    }
    if (neighbours.size() > larger) std::ranges::sort(neighbours, {}, &Neighbour::particle);
}

void NeighbourFinder::find(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    enterCellOf(particle);
    find(particle, within_diameter, neighbours);
    if (particles_.size_classes) addSmaller(particle, neighbours);
}

bool NeighbourFinder::findInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (particles_.size_classes) return false;
    enterCellOf(particle);
    if (!isInDenseCell()) return false;
    find(particle, within_radius, neighbours);
    return true;
}

bool NeighbourFinder::findSomeInDenseCell(std::uint32_t particle, std::vector<Neighbour>& neighbours) {
    if (particles_.size_classes) return false;
    enterCellOf(particle);
    if (!isInDenseCell()) return false;
    if (candidatesFor(positionInCell(particle), within_radius).particle.size() < kSampledCandidates) return false;
    find(particle, some_within_radius, neighbours);
    return true;
}

}  // namespace betamesh
