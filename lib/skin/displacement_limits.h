// How far vertices may move until triangles cross.

#pragma once

#include "base/cell_grid.h"
#include "skin/beta_mesh.h"
#include "skin/patch_tree.h"

#include <optional>
#include <vector>

namespace betamesh {

/// Limits on the displacements of vertices near crossings. A limited vertex keeps the mean displacement of the surface
/// near it, which varies so slowly that it cannot cause crossings, and a fraction of the rest of its own displacement.
class DisplacementLimits {
public:
    /// from: positions of all vertices before the displacement. mesh: after it; referenced, like `from`. radius: of the
    /// largest balls, world units. Lengths are in radii of balls as large as BetaMesh::scale says.
    DisplacementLimits(const DualPoints& from, double radius, const BetaMesh& mesh);

    /// Reduces the fractions of the vertices of crossing triangles, and of their supports, until these
    /// triangles do not cross; where they cross even at the mean displacement, moves that back to the initial position.
    /// Then reduces fractions near them along the edges of active triangles, so that fractions differ by at most the
    /// distance in radii. all_the_way: reduces the fractions of crossing triangles to 0. Returns whether anything was
    /// reduced.
    bool reduce(const std::vector<TrianglePair>& pairs, bool all_the_way, const PatchTree& tree);
    /// The position of a vertex within its limits, as files hold it.
    DualVec3 limitedPosition(std::uint32_t v) const;

private:
    struct VertexLimit {
        std::uint32_t vertex;
        bool has_base = false;  // base is at the mean displacement, or will be after setMeanDisplacements()
        DualVec3 base, to;
        Dual fraction = 1;  // of the displacement from base to `to`
    };
    struct Element {  // of the surface
        DualVec3 middle, displacement;
        double area = 0;
    };

    Dual fractionOf(std::uint32_t v) const { return row_[v] == kInvalidIndex ? Dual(1) : limit_[row_[v]].fraction; }
    double radiusAt(std::uint32_t v) const { return radius_ * mesh_.scaleOf(v); }
    static bool lower(VertexLimit& limit, Dual fraction);
    template <typename Visit>
    void forSupports(std::uint32_t v, const Visit& visit);
    VertexLimit& limitOf(std::uint32_t v);
    void requestBase(std::uint32_t v);
    void gatherElements(const PatchTree& tree);
    void setMeanDisplacements();
    std::vector<std::optional<Dual>> crossingFreeFractions(const std::vector<TrianglePair>& pairs) const;
    void propagate(const PatchTree& tree);

    const DualPoints& from_;
    double radius_;
    const BetaMesh& mesh_;
    std::vector<std::uint32_t> row_;           // of each vertex in limit_
    std::vector<const FadingVertex*> fading_;  // of each vertex, or null
    std::vector<VertexLimit> limit_;
    std::vector<std::uint32_t> without_base_;  // vertices whose base is still to be set
    std::vector<Element> element_;             // of the active triangles
    std::optional<CellGrid> element_cells_;
};

}  // namespace betamesh
