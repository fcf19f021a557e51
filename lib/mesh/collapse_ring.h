// The geometry of collapsing an edge: the triangles around a vertex, and those that take their place when it is
// removed.

#pragma once

#include "betamesh/vec3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace betamesh {

inline constexpr std::size_t kMostNeighbours = 16;  ///< of a vertex that is removed, and of any vertex afterwards

/// Twice the area of the triangle of the origin, a and b in the plane, positive counter-clockwise.
inline double across(const Vec3& a, const Vec3& b) { return a.x * b.y - a.y * b.x; }

/// The vertices around one, in order. Positions are relative to the vertex in the middle. Projected: x and y in the
/// plane across the mean normal of the triangles between them, z along it.
///
/// When the middle collapses into a target, one of the vertices of the ring, triangles from the target to the sides of
/// the ring take the place of the old ones. The new edges lead from the target across the ring.
struct OneRing {
    std::size_t size = 0;
    std::array<std::uint32_t, kMostNeighbours> vertex;
    std::array<Vec3, kMostNeighbours> position, projected;
    std::array<Vec3, 3> axes;
    double error = 0;  ///< largest distance of an old triangle from the original surface, in tolerances
    double room = 1;   ///< largest distance that all old triangles may have from it, in tolerances

    std::size_t next(std::size_t i) const { return i + 1 < size ? i + 1 : 0; }
    std::size_t previous(std::size_t i) const { return i > 0 ? i - 1 : size - 1; }
    Vec3 project(const Vec3& p) const { return {dot(p, axes[0]), dot(p, axes[1]), dot(p, axes[2])}; }

    /// Finds the axes; false unless the old triangles are a height field over the plane.
    bool projectAll() {
        Vec3 normal(0, 0, 0);
        for (std::size_t i = 0; i < size; ++i) normal += cross(position[i], position[next(i)]);
        normal.normalize();
        const Vec3 right = cross(std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), normal).normalized();
        axes = {right, cross(normal, right), normal};
        for (std::size_t i = 0; i < size; ++i) projected[i] = project(position[i]);
        bool is_field = true;
        for (std::size_t i = 0; i < size; ++i) is_field &= across(projected[i], projected[next(i)]) > 0;
        return is_field;
    }

    /// The height of a projected point above the new triangles; 0 beside them.
    double heightAbove(std::size_t target, const Vec3& point) const {
        const Vec3 u = projected[target] - point;
        for (std::size_t i = next(target); i != previous(target); i = next(i)) {
            const Vec3 a = projected[i] - point, b = projected[next(i)] - point;
            const double at_u = across(a, b), at_a = across(b, u), at_b = across(u, a);
            if (at_u >= 0 && at_a >= 0 && at_b >= 0)
                return -(u.z * at_u + a.z * at_a + b.z * at_b) / (at_u + at_a + at_b);
        }
        return 0;
    }

    /// The largest height, up or down, between the projected edge p q and the new edges that it crosses.
    double largestHeight(std::size_t target, const Vec3& p, const Vec3& q) const {
        const Vec3 u = projected[target] - p, along = q - p;
        const double side_u = across(along, u);
        double largest = 0;
        for (std::size_t i = next(next(target)); i != previous(target); i = next(i)) {
            const Vec3 a = projected[i] - p;
            const double side_a = across(along, a);
            if ((side_u > 0) == (side_a > 0)) continue;
            const Vec3 point = u + (a - u) * (side_u / (side_u - side_a));
            const double share = (point.x * along.x + point.y * along.y) / (along.x * along.x + along.y * along.y);
            if (share > 0 && share < 1) largest = std::max(largest, std::abs(point.z - share * along.z));
        }
        return largest;
    }

    /// The largest height between the old and the new triangles. Both are linear between the vertices of their overlay:
    /// the middle, and the points where old edges cross new ones.
    double heightBetween(std::size_t target) const {
        const Vec3 middle(0, 0, 0);
        double largest = std::abs(heightAbove(target, middle));
        for (std::size_t k = 0; k < size; ++k) largest = std::max(largest, largestHeight(target, middle, projected[k]));
        return largest;
    }
};

/// The part of the original surface beneath a ring, and some of it beside, projected.
struct OriginalPart {
    bool is_field = false;  ///< it is a height field over the ring's plane, and not too large
    std::vector<Vec3> vertices;
    std::vector<std::array<Vec3, 2>> edges;

    /// The largest height between it and the new triangles, see OneRing::heightBetween().
    double heightBetween(const OneRing& ring, std::size_t target) const {
        if (!is_field) return std::numeric_limits<double>::infinity();
        double largest = 0;
        for (const Vec3& point : vertices) largest = std::max(largest, std::abs(ring.heightAbove(target, point)));
        for (const auto& [p, q] : edges) largest = std::max(largest, ring.largestHeight(target, p, q));
        return largest;
    }
};

}  // namespace betamesh
