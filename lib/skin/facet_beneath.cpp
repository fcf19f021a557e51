#include "skin/facet_beneath.h"

#include <bit>

namespace betamesh {

namespace {

constexpr double kHeightMargin = 1e-6;  // relative margin of isFarAbove(), far above the rounding of points

}  // namespace

bool isFarAbove(const Vec3& p, double height, std::span<const std::uint32_t> ring, const std::vector<Vec3>& point) {
    constexpr int kMaxTurns = 6;
    const double squared_length = p.length2(), level = 1 - height * (1 + kHeightMargin);
    Vec3 normal = p / squared_length;  // p itself stays at level 1
    for (int turn = 0;; ++turn) {
        Vec3 highest(0);
        double most = level;
        for (const std::uint32_t r : ring) {
            const double here = dot(point[r], normal);
            if (here > most) most = here, highest = point[r];
        }
        if (most == level) return true;
        const Vec3 aside = highest - p * (dot(highest, p) / squared_length);
        const double squared = aside.length2();
        if (turn == kMaxTurns || !(squared > 0)) return false;
        normal -= aside * ((most - level) / squared);
    }
}

std::optional<Triangle> facetBeneath(const Vec3& p, std::span<const std::uint32_t> ring,
                                     const std::vector<Vec3>& point) {
    std::array<Vec3, kLongestRing> at;
    std::array<std::array<double, kLongestRing>, kLongestRing> across;  // p · (i × j)
    std::array<std::uint32_t, kLongestRing> on_left{}, on_right{};      // per i: bits of the j with >= 0, <= 0
    for (std::size_t i = 0; i < ring.size(); ++i) {
        at[i] = point[ring[i]];
        for (std::size_t j = 0; j < i; ++j) {
            const double sine = dot(p, cross(at[j], at[i]));
            across[j][i] = sine;
            across[i][j] = -sine;
            on_left[j] |= std::uint32_t{sine >= 0} << i;
            on_left[i] |= std::uint32_t{sine <= 0} << j;
            on_right[j] |= std::uint32_t{sine <= 0} << i;
            on_right[i] |= std::uint32_t{sine >= 0} << j;
        }
    }
    std::optional<Triangle> highest;
    double least = 1;  // relative height of p over it
    for (std::size_t i = 0; i < ring.size(); ++i)
        for (std::size_t j = i + 1; j < ring.size(); ++j) {
            std::uint32_t third = 0;  // bits of the k with which i and j surround p, in either order
            if (across[i][j] >= 0) third |= on_left[j] & on_right[i];
            if (across[i][j] <= 0) third |= on_right[j] & on_left[i];
            for (third = third >> j >> 1 << j << 1; third != 0; third &= third - 1) {
                const auto k = static_cast<std::size_t>(std::countr_zero(third));
                const double u = across[j][k], v = across[k][i], w = across[i][j], sum = u + v + w;
                if (sum == 0) continue;
                const double determinant = dot(at[i], cross(at[j], at[k]));
                if (!(determinant * sum > 0)) continue;
                const double height = 1 - determinant / sum;
                if (highest && least <= height) continue;
                highest = Triangle{ring[i], ring[j], ring[k]};
                least = height;
            }
        }
    return highest;
}

std::uint32_t facetBeyond(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::span<const std::uint32_t> ring,
                          const std::vector<Vec3>& point) {
    const Vec3 edge = dot(point[a], cross(point[b], point[c])) > 0 ? point[a] - point[b] : point[b] - point[a];
    std::uint32_t beyond = c;
    Vec3 normal(0);
    for (const std::uint32_t d : ring) {
        if (d == a || d == b || d == c || (beyond != c && dot(point[d] - point[a], normal) <= 0)) continue;
        beyond = d;
        normal = cross(edge, point[d] - point[a]);
    }
    return beyond;
}

}  // namespace betamesh
