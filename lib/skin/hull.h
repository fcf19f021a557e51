// The part of a sphere that lies to the left of some loops, as triangles of a convex hull.

#pragma once

#include "base/index.h"
#include "mesh/mesh_edges.h"

#include <memory>

namespace betamesh {

/// Points on (or just inside) a sphere round the origin, in integers up to 2^38 per coordinate.
/// Loop points come first, loop after loop, each with its inside on the left, seen from outside; loops
/// lie on circles, and no point lies beyond the plane of any. Free points come last.
struct LoopsOnSphere {
    std::vector<Vec3i> point;
    std::vector<std::uint32_t> loop_begin{0};           ///< first point of each loop, and one entry past the last
    std::vector<std::array<std::uint32_t, 2>> circles;  ///< of each loop point: the circles before and after it
    std::vector<std::uint8_t> is_hole;  ///< of each loop: 1 where it surrounds something, should it shrink to a point

    /// Triangles of free points that no free point lies above but those listed, few or many: those that neither these
    /// nor loop points lie above are facets of the hull, and need not be searched for.
    std::vector<Triangle> likely_facet;
    std::vector<std::uint32_t> perhaps_above;

    void clear();
};

/// Triangles of the points, counter-clockwise seen from outside; numbers from point.size() on are new points.
struct LoopFilling {
    std::vector<Triangle> triangles;
    std::vector<Vec3i> new_point;
    /// Of a hull's triangles, the others beyond their sides, from each corner to the next one; kInvalidIndex beyond a
    /// loop, and where slivers tell points apart that coincide.
    std::vector<Triangle> across;
};

/// Fills loops, one set after another, in memory that it keeps.
class HullFiller {
public:
    HullFiller();
    ~HullFiller();
    HullFiller(const HullFiller&) = delete;
    HullFiller& operator=(const HullFiller&) = delete;

    /// Fills the loops with facets of the convex hull of all points, found by gift wrapping from the loops inwards.
    /// Points closer than 1e-7 radii (where this leads nowhere four times that, and so on up to 1e-3) count as one
    /// and are told apart again afterwards by slivers: whatever coincides stays separate in the combinatorics, and
    /// where loops come so close to each other the surface runs on between them. Every loop edge is used once, every
    /// other edge twice, and the triangles round every point form one fan: otherwise the answer is false, and the
    /// filling worthless.
    ///
    /// in      n points; the loops need not be connected, nested or of one face
    /// same    triangles for any order of the free points, save for the numbers
    /// cost    O(n · triangles), without those of likely facets
    /// source  gift wrapping: Chand & Kapur 1970; exact orientation, ties by lexicographic lifting
    bool fill(const LoopsOnSphere& loops, LoopFilling& filling);

private:
    class Work;
    std::unique_ptr<Work> work_;
};

/// Fills the loops of one face whatever their shape: joins them into one by quads and closes that with a fan
/// round a new point. Combinatorially right always, geometrically good for small or convex faces.
/// Of loops `first_loop` … `last_loop` - 1, with at least three points in each.
LoopFilling fillWithFan(const LoopsOnSphere& loops, std::uint32_t first_loop, std::uint32_t last_loop);

}  // namespace betamesh
