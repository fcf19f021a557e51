// The whole method on one screen: the only place where the stages meet.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <functional>
#include <string_view>

namespace betamesh {

struct NearSurface;

/// What was found on the way; the numbers of the per-frame report. Those of the alpha mesh are without what left it as
/// a feature.
struct SkinReport {
    std::size_t particles = 0;
    std::size_t distinct_particles = 0;  ///< after exact duplicates collapsed
    std::size_t alpha_triangles = 0;     ///< oriented: a double-sided one counts twice
    std::size_t double_sided_triangles = 0;
    std::size_t degenerate_edges = 0;
    std::size_t isolated_particles = 0;
    std::size_t alpha_vertices = 0;  ///< particles that some alpha triangle uses
    int perturbation_retries = 0;
    // What left the mesh, as the parameters ask for:
    std::size_t droplets = 0;
    std::size_t droplet_particles = 0;  ///< distinct
    std::size_t tendril_particles = 0;  ///< distinct
    std::size_t bubbles_filled = 0;
};

struct SkinnedFrame {
    Mesh mesh;        ///< has velocity exactly when the particles have
    Spheres spheres;  ///< what is no part of the mesh: droplets and tendrils where asked for; with the paper's
                      ///< tessellation isolated particles and ends of degenerate edges
    SkinReport report;
};

/// Called with the name of each stage as it ends: "structure", "tessellate", "smooth", "velocity".
using Watch = std::function<void(std::string_view stage)>;

/// Skins one frame.
///
/// in      n >= 0 valid particles
/// out     a closed mesh; no particles give an empty mesh
/// same    bytes for any thread count and particle order
/// cost    O(n) for a bounded number of neighbours within two radii
/// errors  the paper's smoothing of another tessellation than the paper's; bubbles filled of another than the complete
///         one; what requireSkin() throws; particles beyond the integer range; floating predicates that stay invalid
///         after all retries
/// source  beta mesh paper, section 3
SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch = {});

/// The same bytes where particles are too many for the memory: near is what a NearSurfaceFinder made from these
/// parameters says of all of them, the particles are those in near.row alone.
SkinnedFrame skinFrame(const Particles& particles, const NearSurface& near, const SkinParams& params,
                       const Watch& watch = {});

}  // namespace betamesh
