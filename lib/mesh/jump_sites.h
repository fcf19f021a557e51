// Where a surface jumps, and what happens to it there.

#pragma once

#include "mesh/coherence.h"

#include <string_view>

namespace betamesh {

/// How a surface changes its topology. A piece is a closed surface round liquid, a void one with liquid round it.
enum class SurfaceEvent {
    void_appeared,  ///< in the midst of liquid
    void_vanished,
    void_opened,      ///< into the open, or into another void
    void_closed_off,  ///< from the open, or from another void
    hole_opened,      ///< through a sheet, or any other way through liquid
    hole_closed,
    neck_formed,  ///< between parts of one piece
    neck_broke,
    pieces_joined,
    pieces_parted,
    piece_appeared,
    piece_vanished,
    several,  ///< of several kinds that cannot be told apart
    unclear   ///< a mesh is not closed there, or what is round the place differs, too
};

/// In words, as reports have it.
std::string_view nameOf(SurfaceEvent event);

/// Where surfaces are farthest from each other: has liquid covered the one before, or left the one after?
enum class LiquidChange { gained, lost, both };

std::string_view nameOf(LiquidChange change);

/// Points far from the other surface that are near each other. World units.
struct Place {
    Vec3 position{0, 0, 0};  ///< of the one that is farthest
    double jump = 0;         ///< its distance
    std::size_t points = 0;
    double vanished = 0, appeared = 0;  ///< areas that they stand for, of the surface before and of that after
    LiquidChange liquid = LiquidChange::both;
    /// With how often each has happened; none where the surface moves, however fast, and nothing opens, closes, meets
    /// or parts.
    std::vector<std::pair<SurfaceEvent, std::size_t>> events;
};

/// Gathers what surfaceDistance(before, after) has listed, and names what happened.
///
/// Points no farther apart than `reach`, world units, > 0, are one place. What surrounds a place is cut out of both
/// surfaces, at distances from its jump on to twice that or a reach more. Where the cuts have the same number of rims,
/// the differences of their Euler characteristics, parts, pieces and voids, and whether liquid has come or gone, tell
/// what opened, closed, met or parted; what most cuts tell counts. It is the sum of what happens there: in tangled
/// liquid, or over long times, `several` or `unclear`.
///
/// out     the largest jump first
/// same    result for any thread count
/// cost    O(triangles log triangles), and as much again for what surrounds each place
std::vector<Place> placesOf(const Mesh& before, const Mesh& after, const std::vector<FarPoint>& far, double reach);

}  // namespace betamesh
