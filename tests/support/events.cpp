#include "support/events.h"

#include "base/random.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "skin/particle_sizes.h"

#include <algorithm>

namespace betamesh {

namespace {

void findEventsBetween(double begin, const Combinatorics& before, double end, const Combinatorics& after,
                       const SkinParams& params, const std::function<Particles(double)>& particlesAt,
                       const std::function<void(double, const std::string&)>& found) {
    if (before == after) return;
    const double middle = (begin + end) / 2;
    const Particles particles = particlesAt(middle);
    if (end - begin < 1e-9) {
        found(middle, kindOf(before, after, particles));
        return;
    }
    const Combinatorics between = combinatoricsOf(particles, params);
    findEventsBetween(begin, before, middle, between, params, particlesAt, found);
    findEventsBetween(middle, between, end, after, params, particlesAt, found);
}

}  // namespace

Combinatorics combinatoricsOf(const Particles& particles, const SkinParams& params) {
    const std::vector<double> radius = particleSizes(particles, params).radius;
    const SnappedParticles snapped =
        radius.empty() ? snapParticles(particles, params.radius) : snapParticles(particles, radius);
    const BallBoundary boundary = ballBoundary(snapped, exposureCandidates(snapped));
    std::vector<Triangle> triangles = boundary.triangle;
    for (Triangle& t : triangles)
        for (std::uint32_t& ball : t) ball = boundary.row[ball];
    Combinatorics found{canonical(triangles), {}};
    for (const auto& [a, b] : boundary.circle)
        found.circles.insert({std::min(boundary.row[a], boundary.row[b]), std::max(boundary.row[a], boundary.row[b])});
    return found;
}

std::string kindOf(const Combinatorics& before, const Combinatorics& after, const Particles& at) {
    std::vector<Triangle> gone, come;
    std::set_difference(before.triangles.begin(), before.triangles.end(), after.triangles.begin(),
                        after.triangles.end(), std::back_inserter(gone));
    std::set_difference(after.triangles.begin(), after.triangles.end(), before.triangles.begin(),
                        before.triangles.end(), std::back_inserter(come));
    std::set<std::uint32_t> of;
    for (const auto* list : {&gone, &come})
        for (const Triangle& t : *list) of.insert(t.begin(), t.end());
    const std::size_t less = std::min(gone.size(), come.size()), more = std::max(gone.size(), come.size());
    if (more == 0) return "contact";
    if (less == 2 && more == 2 && of.size() == 4) return "flip";
    if (less == 1 && more == 3 && of.size() == 4) return "birth";
    if (less == 0 && more == 4 && of.size() == 4) return "void";
    if (less == 0 && more == 2 && of.size() == 3) {
        const Triangle& t = (gone.empty() ? come : gone)[0];
        const Vec3 a(at.position[t[0]]), b(at.position[t[1]]), c(at.position[t[2]]);
        const bool acute = dot(b - a, c - a) > 0 && dot(a - b, c - b) > 0 && dot(a - c, b - c) > 0;
        return acute ? "hole" : "graze";
    }
    return "several";
}

void findEvents(double begin, double end, const SkinParams& params, const std::function<Particles(double)>& particlesAt,
                const std::function<void(double, const std::string&)>& found) {
    findEventsBetween(begin, combinatoricsOf(particlesAt(begin), params), end,
                      combinatoricsOf(particlesAt(end), params), params, particlesAt, found);
}

Particles movingCloud(std::uint64_t seed, std::array<int, 3> size, double jitter, double keep) {
    Random random(seed);
    Particles particles;
    for (int z = 0; z < size[2]; ++z)
        for (int y = 0; y < size[1]; ++y)
            for (int x = 0; x < size[0]; ++x) {
                const Vec3 middle = Vec3(size[0] - 1, size[1] - 1, size[2] - 1) / 2;
                const Vec3 position = Vec3(x, y, z) - middle + random.cube() * jitter, velocity = random.ball();
                if (random.unit() > keep) continue;
                particles.position.emplace_back(position);
                particles.velocity.emplace_back(velocity);
                particles.id.push_back(particles.id.size());
            }
    return particles;
}

}  // namespace betamesh
