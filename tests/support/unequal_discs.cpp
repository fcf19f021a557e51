#include "support/unequal_discs.h"

#include <gtest/gtest.h>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>

namespace betamesh {

UnequalDiscs tiedDiscs(std::uint64_t seed) {
    UnequalDiscs cloud;
    cloud.name = "tied discs " + std::to_string(seed);
    Random random(seed);
    constexpr double kRadii[] = {1.0, 0.5, 1.5, 2.0, 2.5, 0.25, 3.0, 0.125};
    const std::uint64_t count = 3 + random.below(10), side = 2 + random.below(4), sizes = 2 + random.below(3),
                        first = random.below(5), line = random.below(4);
    for (std::uint64_t i = 0; i < count; ++i) {
        const double x = static_cast<double>(random.below(2 * side)) / 2,
                     y = line == 0 ? 0 : static_cast<double>(random.below(side));
        cloud.particles.position.emplace_back(Vec3(x, y, 0));
        cloud.radius.push_back(kRadii[first + random.below(std::min<std::uint64_t>(sizes, 8 - first))]);
    }
    return cloud;
}

void forEveryUnequalDiscs(std::uint64_t n, const std::function<void(const UnequalDiscs&)>& check) {
    std::uint64_t seed = 0;
    forEveryPlanarCloud(n / 12, [&](const Cloud& cloud) {
        if (cloud.particles.size() == 0 || cloud.particles.size() > 400) return;
        for (const RadiusPattern pattern : kRadiusPatterns) {
            if (testing::Test::HasFailure()) return;
            SCOPED_TRACE(testing::Message() << "radii " << static_cast<int>(pattern));
            check({cloud.name, cloud.particles, radiiFor(cloud, pattern, ++seed)});
        }
    });
    for (std::uint64_t tied = 0; tied < n && !testing::Test::HasFailure(); ++tied) {
        const UnequalDiscs cloud = tiedDiscs(tied);
        SCOPED_TRACE(cloud.name);
        check(cloud);
    }
}

UnequalDiscs reversed(const UnequalDiscs& cloud) {
    UnequalDiscs other = cloud;
    std::reverse(other.particles.position.begin(), other.particles.position.end());
    std::reverse(other.particles.velocity.begin(), other.particles.velocity.end());
    std::reverse(other.particles.id.begin(), other.particles.id.end());
    std::reverse(other.radius.begin(), other.radius.end());
    return other;
}

SegmentSet perturbedAlphaSegments(const SnappedParticles& snapped) {
    using Real =
        boost::multiprecision::number<boost::multiprecision::cpp_bin_float<3000, boost::multiprecision::digit_base_2>,
                                      boost::multiprecision::et_off>;
    const auto n = static_cast<std::uint32_t>(snapped.size());
    std::vector<Real> squared_radius(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        const auto rank = std::count_if(snapped.position.begin(), snapped.position.end(),
                                        [&](const Vec3i& p) { return before(p, snapped.position[i]); });
        // R² + η + ε_rank with η = 2^-150, ε_k = 2^-(350 + 80 k)
        squared_radius[i] = Real(snapped.radiusOf(i)) * snapped.radiusOf(i) + ldexp(Real(1), -150) +
                            ldexp(Real(1), -350 - 80 * static_cast<int>(rank));
    }
    SegmentSet found;
    for (std::uint32_t a = 0; a < n; ++a)
        for (std::uint32_t b = 0; b < n; ++b) {
            if (a == b) continue;
            const Vec3i u = snapped.position[b] - snapped.position[a];
            const Real squared = u.x * u.x + u.y * u.y, power = squared + squared_radius[a] - squared_radius[b],
                       discriminant = 4 * squared_radius[a] * squared - power * power;
            if (discriminant <= 0) continue;
            const Real root = sqrt(discriminant), x = (power * u.x + root * u.y) / (2 * squared),
                       y = (power * u.y - root * u.x) / (2 * squared);
            bool is_exposed = true;
            for (std::uint32_t p = 0; is_exposed && p < n; ++p) {
                if (p == a || p == b) continue;
                const Vec3i w = snapped.position[p] - snapped.position[a];
                const Real dx = x - w.x, dy = y - w.y;
                is_exposed = dx * dx + dy * dy >= squared_radius[p];
            }
            if (is_exposed) found.insert(std::array{snapped.row[a], snapped.row[b]});
        }
    return found;
}

}  // namespace betamesh
