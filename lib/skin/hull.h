// Fills loops on a sphere: the part of a convex hull to their left.

#pragma once

#include "skin/sphere_loops.h"

#include <memory>

namespace betamesh {

/// Fills sets of loops in turn, and keeps its memory.
class HullFiller {
public:
    HullFiller();
    ~HullFiller();
    HullFiller(const HullFiller&) = delete;
    HullFiller& operator=(const HullFiller&) = delete;

    /// Fills the loops with facets of the convex hull of all points, found by gift wrapping from the loops inwards.
    /// Points closer than 1e-7 radii count as one; if that leads to no consistent hull, four times that, and so on up
    /// to 1e-3. They are told apart again by slivers: coinciding points stay separate in the combinatorics, and where
    /// loops come that close to each other the surface runs on between them. Every loop edge is used once, every other
    /// edge twice, and the triangles round every point form one fan; if that fails the answer is false and the filling
    /// is invalid.
    ///
    /// in      n points; the loops need not be connected, nested or of one face
    /// same    triangles for any order of the free points, up to their numbers
    /// cost    O(n · triangles), not counting likely facets
    /// source  gift wrapping: Chand & Kapur 1970; exact orientation, ties by lexicographic lifting
    bool fill(const LoopsOnSphere& loops, LoopFilling& filling);

private:
    class Work;
    std::unique_ptr<Work> work_;
};

/// Fills the loops of one face whatever their shape: joins them into one by quads and fills that with a fan round a new
/// point. Always valid combinatorially; of good geometry for small or convex faces.
///
/// in      loops first_loop … last_loop - 1, each with at least three points
LoopFilling fillWithFan(const LoopsOnSphere& loops, std::uint32_t first_loop, std::uint32_t last_loop);

}  // namespace betamesh
