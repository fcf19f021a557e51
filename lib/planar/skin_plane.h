// The whole method in a plane on one screen: the only place where its stages meet.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/skin_params.h"
#include "skin/pipeline.h"

namespace betamesh {

/// What was found on the way.
struct PlaneReport {
    std::size_t particles = 0;
    std::size_t distinct_particles = 0;     ///< after exact duplicates collapsed
    std::size_t alpha_segments = 0;         ///< oriented: a double-sided one counts twice
    std::size_t double_sided_segments = 0;  ///< each side counts
    std::size_t isolated_particles = 0;
    std::size_t alpha_vertices = 0;     ///< particles that some alpha segment uses
    std::size_t droplets = 0;           ///< that left the mesh, as the parameters ask for
    std::size_t droplet_particles = 0;  ///< theirs, distinct
    std::size_t bubbles_filled = 0;
};

struct SkinnedPlane {
    Curves curves;                   ///< have velocity exactly when the particles have, and the attributes asked for
    Curves before;                   ///< the same on the discs, before anything moves it, without velocity; none of the
                                     ///< alpha mesh
    std::vector<std::uint8_t> pure;  ///< of each vertex of both: 1 where two circles meet; none of the alpha mesh
    Curves alpha;                    ///< the alpha mesh, without velocity
    Spheres spheres;                 ///< what is no part of the curves: droplets where asked for; with the paper's
                                     ///< tessellation isolated particles
    PlaneReport report;
};

/// Skins one frame of particles that lie in one plane of constant z, as skinFrame() does in space: discs for balls,
/// closed curves for the mesh. Arcs are cut in fixed directions from their centre: 8 for each arc_subdivisions, 24 for
/// 0. Discs say which particles belong together; then the curve moves inwards to the skin, skinDepth(params, 2) outside
/// the outermost particles, but no less than a twentieth of the radius. Features::bubble_gap is the diameter of a disc
/// here, bubble_volume an area in world units squared.
///
/// in      n >= 0 valid particles
/// out     closed curves, the liquid on their left: counter-clockwise round it seen from +z, clockwise round holes
/// same    bytes for any thread count and particle order
/// cost    O(n) for a bounded number of neighbours within two radii
/// errors  a particle with another z than the first; what requirePlanar() and requireSkin() throw; an attribute that
///         the particles have not; particles beyond the integer range
/// source  beta mesh paper, section 3 and Figure 8
SkinnedPlane skinPlane(const Particles& particles, const SkinParams& params,
                       const Watch& watch = {});

/// errors  parameters that only three dimensions know; the paper's smoothing of another tessellation than the paper's
void requirePlanar(const SkinParams& params);

/// Do two particles or more share one z, all of them?
bool isPlanar(const Particles& particles);

}  // namespace betamesh
