// The whole method on one screen: the only place where the stages meet.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <functional>
#include <string_view>

namespace betamesh {

struct NearSurface;

/// The stages of a frame, in order. skinFrame() and skinPlane() run `structure` to `velocity`; reading, pictures,
/// measurements and writing belong to jobs.
enum class Stage {
    read,
    structure,   ///< the exact boundary of the union of balls
    tessellate,  ///< its points and triangles, and the samples that smoothing needs
    smooth,      ///< retraction to the skin, smoothing, removal of self-intersections
    velocity,    ///< velocities and attributes of the vertices
    measure,
    picture,
    write,
};
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
};

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
///         than the complete one; what requireSkin() throws; particles beyond the integer range; floating-point
///         predicates that stay inconsistent after all retries
/// source  beta mesh paper, section 3
SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch = {});

/// The same bytes for clouds that do not fit into memory. `near` is the result of a NearSurfaceFinder with these
/// parameters that has seen all particles; `particles` are only those listed in near.row.
SkinnedFrame skinFrame(const Particles& particles, const NearSurface& near, const SkinParams& params,
                       const Watch& watch = {});

}  // namespace betamesh
