#include "bench_clouds.h"

#include <cmath>
#include <random>

namespace betamesh {

Particles splash(std::size_t n) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> jitter(-0.25f, 0.25f), part(0, 1);
    std::normal_distribution<float> speed(0, 1);
    Particles particles;
    const auto add = [&](float x, float y, float z) {
        particles.position.emplace_back(x + jitter(random), y + jitter(random), z + jitter(random));
        particles.velocity.emplace_back(speed(random), speed(random), speed(random));
    };
    const auto total = static_cast<double>(n);
    const int side = std::max(1, static_cast<int>(std::lround(std::cbrt(0.9 * total))));
    const int sheet = static_cast<int>(std::lround(std::sqrt(0.05 * total)));
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) add(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    const auto top = static_cast<float>(side) + 4;
    for (int y = 0; y < sheet; ++y)
        for (int x = 0; x < sheet; ++x) add(static_cast<float>(x), static_cast<float>(y), top);
    const float room = static_cast<float>(side) * 2;
    while (particles.size() < n) {
        const float x = part(random) * room, y = part(random) * room, z = top + 4 + part(random) * room;
        for (int k = 0; k < 1 + static_cast<int>(part(random) * 8); ++k)
            add(x + part(random), y + part(random), z + part(random));
    }
    return particles;
}

}  // namespace betamesh
