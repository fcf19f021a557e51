// Loops of points on a sphere, and triangles that fill them.

#pragma once

#include "mesh/mesh_edges.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace betamesh {

/// Radius of the sphere on which hulls are computed: coordinates are integers up to this.
inline constexpr double kHullRadius = 0x1p38;

/// A point given in radii, rounded to these integers.
inline Vec3i onHullGrid(const Vec3& p) {
    return {std::llround(p.x * kHullRadius), std::llround(p.y * kHullRadius), std::llround(p.z * kHullRadius)};
}

/// Points on or just inside a sphere of radius kHullRadius round the origin. Loop points come first, loop after loop,
/// each with its inside on the left, seen from outside; loops lie on circles, and no point lies beyond the plane of any
/// circle. Free points come last.
struct LoopsOnSphere {
    std::vector<Vec3i> point;
    std::vector<std::uint32_t> loop_begin{0};           ///< first point of each loop, and one entry past the last
    std::vector<std::array<std::uint32_t, 2>> circles;  ///< of each loop point: the circles before and after it
    std::vector<std::uint8_t> is_hole;  ///< of each loop: 1 if it still surrounds a hole when it shrinks to a point

    /// Triangles of free points above which there is no free point except those of perhaps_above. Where neither these
    /// nor loop points are above a triangle it is a facet of the hull and need not be searched for.
    std::vector<Triangle> likely_facet;
    std::vector<std::uint32_t> perhaps_above;

    void clear() {
        point.clear();
        loop_begin.assign(1, 0);
        circles.clear();
        is_hole.clear();
        likely_facet.clear();
        perhaps_above.clear();
    }
};

/// Triangles of the points, counter-clockwise seen from outside. Corners from point.size() on are new points.
struct LoopFilling {
    std::vector<Triangle> triangles;
    std::vector<Vec3i> new_point;
    /// For a hull, the triangle across each side, from each corner to the next; kInvalidIndex if there is a loop, or
    /// slivers that separate coinciding points.
    std::vector<Triangle> across;
};

}  // namespace betamesh
