// Pseudo-random numbers that are the same on every machine. They are hashes of counters, so row i can be computed
// without row i - 1.

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>

namespace betamesh {

/// The n-th output of the generator with this seed.
///
/// source  splitmix64: Steele, Lea & Flood 2014
constexpr std::uint64_t hash(std::uint64_t seed, std::uint64_t n) {
    std::uint64_t x = seed + (n + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/// A stream of pseudo-random numbers: `Random(seed)` for a test, `Random(seed, row)` for row `row` of an array.
class Random {
public:
    explicit constexpr Random(std::uint64_t seed, std::uint64_t row = 0) : seed_(hash(hash(seed, 0), row)) {}

    constexpr std::uint64_t bits() { return hash(seed_, next_++); }
    /// Uniform in [0, 1).
    constexpr double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    constexpr double between(double low, double high) { return low + (high - low) * unit(); }
    /// Nearly uniform in [0, n), n > 0.
    constexpr std::uint64_t below(std::uint64_t n) { return bits() % n; }
    /// Uniform in the cube [-1, 1)³.
    Vec3 cube() {
        const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        return {x, y, z};
    }
    /// Uniform in the unit ball.
    Vec3 ball() {
        Vec3 p = cube();
        while (p.length2() > 1) p = cube();
        return p;
    }

private:
    std::uint64_t seed_, next_ = 0;
};

}  // namespace betamesh
