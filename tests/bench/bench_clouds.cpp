#include "bench_clouds.h"

#include <cmath>
#include <random>

namespace betamesh {

namespace {

// loose: fraction of the particles in the sheet and in drops
Particles blockAndSpray(std::size_t n, double loose) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> jitter(-0.25f, 0.25f), uniform(0, 1);
    std::normal_distribution<float> speed(0, 1);
    Particles particles;
    const auto add = [&](float x, float y, float z) {
        particles.position.emplace_back(x + jitter(random), y + jitter(random), z + jitter(random));
        particles.velocity.emplace_back(speed(random), speed(random), speed(random));
    };
    const auto total = static_cast<double>(n);
    const int block = static_cast<int>((1 - loose) * total);
    const int side = std::max(1, static_cast<int>(std::lround(std::cbrt(block))));
    const int sheet = static_cast<int>(std::lround(std::sqrt(loose / 2 * total)));
    for (int i = 0; i < block; ++i)  // the top layer is incomplete
        add(static_cast<float>(i % side), static_cast<float>(i / side % side), static_cast<float>(i / side / side));
    const auto top = static_cast<float>(block / side / side) + 4;
    for (int y = 0; y < sheet; ++y)
        for (int x = 0; x < sheet; ++x) add(static_cast<float>(x), static_cast<float>(y), top);
    const float width = static_cast<float>(side) * 2;
    while (particles.size() < n) {
        const float x = uniform(random) * width, y = uniform(random) * width, z = top + 4 + uniform(random) * width;
        for (int k = 0; k < 1 + static_cast<int>(uniform(random) * 8); ++k)
            add(x + uniform(random), y + uniform(random), z + uniform(random));
    }
    return particles;
}

}  // namespace

Particles splash(std::size_t n) { return blockAndSpray(n, 0.1); }
Particles calm(std::size_t n) { return blockAndSpray(n, 0.02); }

Particles clumped(std::size_t n) {
    constexpr float kCell = 2, kClump = 0.01F;
    constexpr int kPerInnerCell = 8, kMin = 32, kMax = 64;
    int side = 1;
    const auto particlesIn = [](double cells) {
        const double inside = std::pow(std::max(0.0, cells - 2), 3);
        return kPerInnerCell * inside + (kMin + kMax) / 2.0 * (cells * cells * cells - inside);
    };
    while (particlesIn(side + 0.5) < static_cast<double>(n)) ++side;

    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> speed(0, 1);
    Particles particles;
    const auto add = [&](const Vec3f& position) {
        particles.position.push_back(position);
        particles.velocity.emplace_back(speed(random), speed(random), speed(random));
    };
    const auto inUnitCube = [&] { return Vec3f(uniform(random), uniform(random), uniform(random)); };
    const auto isOutside = [&](int c) { return c == 0 || c == side - 1; };
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const Vec3f corner = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) * kCell;
                if (!isOutside(x) && !isOutside(y) && !isOutside(z)) {
                    for (int k = 0; k < kPerInnerCell; ++k) {
                        const Vec3f octant(static_cast<float>(k & 1), static_cast<float>(k >> 1 & 1),
                                           static_cast<float>(k >> 2));
                        add(corner + (octant + inUnitCube()) * (kCell / 2));
                    }
                    continue;
                }
                const int count = std::uniform_int_distribution(kMin, kMax)(random);
                Vec3f clump(0);
                for (int k = 0; k < count; ++k) {
                    const Vec3f place = corner + inUnitCube() * kCell;
                    if (k % 8 == 0) clump = place;
                    add(k % 2 == 0 ? clump + (inUnitCube() - Vec3f(0.5F)) * kClump : place);
                }
            }
    return particles;
}

Particles spray(std::size_t n) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> along(0, 7.5F * std::cbrt(static_cast<float>(n)));
    Particles particles;
    for (std::size_t i = 0; i < n; ++i) particles.position.emplace_back(along(random), along(random), along(random));
    return particles;
}

Particles denseSheet(std::size_t n) {
    constexpr double kNeighbours = 560, kReach = 3;
    const double radius = kReach / 2 * std::sqrt(static_cast<double>(n) / kNeighbours);
    std::mt19937 random(1);
    std::normal_distribution<double> axis(0, 1);
    Particles particles;
    while (particles.size() < n) {
        const Vec3 direction(axis(random), axis(random), axis(random));
        particles.position.emplace_back(direction.normalized() * radius);
    }
    return particles;
}

Particles denseThread(std::size_t n) {
    Particles particles;
    for (std::size_t i = 0; i < n; ++i) particles.position.emplace_back(0.01F * static_cast<float>(i), 0.0F, 0.0F);
    return particles;
}

}  // namespace betamesh
