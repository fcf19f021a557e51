// Sites at which a surface jumps between two frames, and the changes of topology there.

#pragma once

#include "betamesh/coherence.h"

#include <string_view>

namespace betamesh {

/// A change of a surface's topology. A piece is a component whose surface encloses liquid, a void one that is enclosed
/// by liquid.
enum class SurfaceEvent {
    void_appeared,  ///< inside liquid
    void_vanished,
    void_opened,      ///< merged with the outside or with another void
    void_closed_off,  ///< separated from the outside or from another void
    hole_opened,      ///< a passage through a sheet or through other liquid
    hole_closed,
    neck_formed,  ///< a bridge between parts of one piece
    neck_broke,
    pieces_joined,
    pieces_parted,
    piece_appeared,
    piece_vanished,
    several,  ///< several events of different kinds, which cannot be told apart
    unclear   ///< a mesh is not closed there, or the surroundings of the site differ, too
};

/// The name used in reports.
std::string_view nameOf(SurfaceEvent event);

/// Whether, where the surfaces are farthest apart, liquid has appeared or disappeared between them.
enum class LiquidChange { gained, lost, both };

std::string_view nameOf(LiquidChange change);

/// A cluster of points that are far from the other surface. World units.
struct JumpSite {
    Vec3 position{0, 0, 0};  ///< the point that is farthest from the other surface
    double jump = 0;         ///< its distance
    std::size_t points = 0;
    double vanished = 0, appeared = 0;  ///< area that the points represent on the earlier and on the later surface
    LiquidChange liquid = LiquidChange::both;
    /// Changes of topology and how often each occurred; none where the surface only moves, however fast.
    std::vector<std::pair<SurfaceEvent, std::size_t>> events;
};

/// Clusters the far points that surfaceDistance(before, after) has listed and classifies what happened at each cluster.
///
/// Points no farther apart than `reach` (world units, > 0) belong to one site. The surroundings of a site are cut out
/// of both surfaces at nine distances, from its jump to twice that, or a reach more if that is farther. For cuts with
/// equally many rims on both surfaces, the differences in Euler characteristic, patches, outer surfaces and voids,
/// together with the appearance or loss of liquid, determine the events; the majority of the cuts decides. Events of
/// one site are summed, so tangled liquid or long time steps give `several` or `unclear`.
///
/// out     sites sorted by jump, the largest first
/// same    result for any thread count
/// cost    O(triangles log triangles), and O(triangles nearby) per site
std::vector<JumpSite> jumpSites(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far, double reach);

}  // namespace betamesh
