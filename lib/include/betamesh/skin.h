// The method: the surface of one frame of particles, in space and in a plane.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <functional>
#include <string_view>

namespace betamesh {

/// The stages of a frame, in order. skinFrame() and skinPlane() run `structure` to `velocity`; all others
/// belong to jobs.
enum class Stage {
    read,
    structure,   ///< the exact boundary of the union of balls
    tessellate,  ///< its points and triangles, and the samples that smoothing needs
    smooth,      ///< retraction to the skin, smoothing, removal of self-intersections
    velocity,    ///< velocities and attributes of the vertices
    simplify,    ///< fewer triangles
    measure,
    picture,
    write,
};
inline constexpr std::size_t kStages = static_cast<std::size_t>(Stage::write) + 1;  ///< how many there are
/// The name of a stage in reports.
std::string_view nameOf(Stage stage);

/// Called as each stage ends, once a frame and in order.
using Watch = std::function<void(Stage)>;

/// Counts of one frame for its report. Those of the alpha mesh exclude what was left out as a feature.
struct SkinReport {
    std::size_t particles = 0;
    std::size_t distinct_particles = 0;  ///< after exact duplicates were merged
    std::size_t alpha_triangles = 0;     ///< oriented: a double-sided one counts twice
    std::size_t double_sided_triangles = 0;
    std::size_t degenerate_edges = 0;
    std::size_t isolated_particles = 0;
    std::size_t alpha_vertices = 0;  ///< particles used by at least one alpha triangle
    int perturbation_retries = 0;
    // What the features in the parameters removed from the mesh:
    std::size_t droplets = 0;
    std::size_t droplet_particles = 0;  ///< distinct
    std::size_t tendril_particles = 0;  ///< distinct
    std::size_t bubbles_filled = 0;
    /// Pairs of triangles that cross although the surface is meant to be free of crossings: 0, but where so many balls
    /// meet so near each other that single precision cannot tell them apart. Not counted with the paper's tessellation.
    std::size_t crossings = 0;
};

/// Result of skinFrame().
struct SkinnedFrame {
    Mesh mesh;        ///< has velocities exactly when the particles have
    Spheres spheres;  ///< what is not part of the mesh: droplets and tendrils that are kept as points; with the paper's
                      ///< tessellation isolated particles and the ends of degenerate edges
    SkinReport report;
};

/// Computes the surface of one frame.
///
/// in      n >= 0 valid particles
/// out     a closed mesh; no particles give an empty mesh
/// same    bytes for any thread count and particle order
/// cost    O(n) if the number of neighbours within two radii is bounded
/// errors  the paper's smoothing with another tessellation than the paper's; filled bubbles with another tessellation
///         than the complete one; what requireScale() and requireSkin() throw; walls or a box with another tessellation
///         than the complete one; walls whose normals are not of unit length; a box without inside; an attribute that
///         the particles do not have, or that has the name of one measured on the surface; particles beyond the
///         integer range; floating-point predicates that stay inconsistent after all retries
/// source  beta mesh paper, section 3
SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch = {});

/// Counts of one frame in a plane for its report. Those of the alpha mesh exclude removed droplets.
struct PlaneReport {
    std::size_t particles = 0;
    std::size_t distinct_particles = 0;     ///< without exact duplicates
    std::size_t alpha_segments = 0;         ///< oriented: a double-sided one counts twice
    std::size_t double_sided_segments = 0;  ///< each side counts
    std::size_t isolated_particles = 0;
    std::size_t alpha_vertices = 0;     ///< particles that some alpha segment uses
    std::size_t droplets = 0;           ///< removed droplets
    std::size_t droplet_particles = 0;  ///< distinct particles of removed droplets
    std::size_t bubbles_filled = 0;
};

/// Result of skinPlane().
struct SkinnedPlane {
    Curves curves;                   ///< with velocity if the particles have it, and with the requested attributes
    Curves before;                   ///< the curves on the boundary of discs, before retraction and smoothing, without
                                     ///< velocity; empty for the alpha mesh
    std::vector<std::uint8_t> pure;  ///< of each vertex: 1 where two circles intersect; empty for the alpha mesh
    Curves alpha;                    ///< the alpha mesh, without velocity
    Spheres spheres;                 ///< droplets that are output as points; with the paper's tessellation isolated
                                     ///< particles
    PlaneReport report;
};

/// Skins one frame of particles in a plane of constant z, as skinFrame() does in three dimensions, with discs for balls
/// and closed curves for the mesh. Arcs are divided at fixed directions from their centre: 8 per arc_subdivisions, 24
/// for 0. Discs determine which particles are connected; then the curve moves inwards to the skin, skinDepth(params, 2)
/// outside the outermost particles, but at least a twentieth of the radius. Features::bubble_gap is the diameter of a
/// disc, bubble_volume an area in world units squared. With SkinParams::radius_attribute every particle has a disc and
/// a skin of its own size; a bubble is then filled if no disc fits between the discs that is as large as the gap leaves
/// between two of SkinParams::radius.
///
/// in      n >= 0 valid particles
/// out     closed curves with the liquid on their left: seen from +z counter-clockwise around liquid, clockwise around
///         holes
/// same    bytes for any thread count and particle order
/// cost    O(n) for a bounded number of neighbours within two radii
/// errors  a particle with a different z than the first; those of requirePlanar(), requireScale() and requireSkin();
///         an attribute that the particles do not have; a size that is not positive, or less than a thousandth of the
///         largest; particles beyond the integer range
/// source  beta mesh paper, section 3 and Figure 8
SkinnedPlane skinPlane(const Particles& particles, const SkinParams& params, const Watch& watch = {});

/// Checks that the parameters are supported in two dimensions.
///
/// errors  parameters that work in three dimensions only; the paper's smoothing without the paper's tessellation,
///         particles of different sizes with it
void requirePlanar(const SkinParams& params);

}  // namespace betamesh
