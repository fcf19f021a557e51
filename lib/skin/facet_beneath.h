// The facet beneath a point of a hull: the one that would be there without it, among the points round it.
//
// Heights are relative to the point's distance from the origin. A ring lists the neighbours of a point on the hull, as
// rows of an array of points.

#pragma once

#include "base/dual.h"
#include "betamesh/mesh.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace betamesh {

/// Longest ring that facetBeneath() accepts.
inline constexpr std::size_t kLongestRing = 10;

/// Is p surely higher than `height` over every facet of the ring's points beneath it? Looks for a plane that separates
/// p from them by that much, by turning it away from whichever point is highest.
bool isFarAbove(const Vec3& p, double height, std::span<const std::uint32_t> ring, const std::vector<Vec3>& point);

/// The facet of the hull of the ring's points that the ray from the origin through p leaves last, if p is above it. For
/// rings of at most kLongestRing points.
std::optional<Triangle> facetBeneath(const Vec3& p, std::span<const std::uint32_t> ring,
                                     const std::vector<Vec3>& point);

/// The third corner of the facet beyond the edge a, b of a facet a, b, c of the ring's points; c if there is none.
std::uint32_t facetBeyond(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::span<const std::uint32_t> ring,
                          const std::vector<Vec3>& point);

/// A point over a facet: where the ray from the origin through the point leaves the facet, and how high the point is.
struct PointOverFacet {
    std::array<Dual, 3> weight;  ///< barycentric weights of the corners where the ray leaves; they sum to 1
    Dual height;                 ///< of the point over that, relative to its distance from the origin

    PointOverFacet(const DualVec3& p, const std::array<DualVec3, 3>& corner) {
        Dual sum;
        for (std::size_t k = 0; k < 3; ++k) {
            weight[k] = dot(p, cross(corner[(k + 1) % 3], corner[(k + 2) % 3]));
            sum = sum + weight[k];
        }
        for (Dual& w : weight) w = w / sum;
        height = 1 - dot(corner[0], cross(corner[1], corner[2])) / sum;
    }
};

}  // namespace betamesh
