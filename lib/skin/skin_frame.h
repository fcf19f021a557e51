// The whole method on one screen: the only place where the stages meet.

#pragma once

#include "core/mesh.h"
#include "core/particles.h"

#include <functional>
#include <string_view>

namespace betamesh {

enum class SurfaceKind {
    beta,   ///< the beta mesh
    alpha,  ///< the alpha mesh: particles joined by triangles
    union_  ///< the union of balls, tessellated: the ground truth to look at
};
enum class Tessellation {
    complete,  ///< every exposed piece of every ball: closed, manifold, with drops and tendrils
    paper,     ///< the paper's fans; isolated particles and degenerate edges become external spheres
};
enum class PredicateKind {
    exact,     ///< exact signs with symbolic tie-breaking: never fails
    floating,  ///< the paper's test in double precision, validated and repeated on jittered particles
};
enum class SmoothingMethod {
    none,
    coherent,  ///< fits of position and measure: continuous in time
    paper,     ///< the paper's averages over neighbouring faces; for the paper's tessellation alone
};

/// Everything that shapes the surface of one frame.
struct SkinParams {
    double radius = 0;  ///< of the balls, world units, > 0; the paper uses 1.5 particle spacings
    SurfaceKind surface = SurfaceKind::beta;
    Tessellation tessellation = Tessellation::complete;
    int arc_subdivisions = 0;  ///< segments of every arc, >= 0; 0: as many as keep the sagitta below 0.01 radii
    PredicateKind predicates = PredicateKind::exact;
    int retries = 3;          ///< floating predicates: how often particles are jittered before giving up, >= 0
    double tolerance = 1e-5;  ///< floating predicates: size of the jitter in radii, (0, 0.1]
    SmoothingMethod smoothing = SmoothingMethod::coherent;
    double smoothing_width = 0;          ///< coherent: its reach, world units, >= 0; 0: 2.8 radii
    int passes = 1;                      ///< of smoothing, >= 0
    bool resolve_intersections = false;  ///< the paper's tessellation: push vertices out to particles that lie outside
};

/// What was found on the way; the numbers of the per-frame report.
struct SkinReport {
    std::size_t particles = 0;
    std::size_t distinct_particles = 0;  ///< after exact duplicates collapsed
    std::size_t alpha_triangles = 0;     ///< oriented: a double-sided one counts twice
    std::size_t double_sided_triangles = 0;
    std::size_t degenerate_edges = 0;
    std::size_t isolated_particles = 0;
    std::size_t alpha_vertices = 0;  ///< particles that some alpha triangle uses
    int perturbation_retries = 0;
};

struct SkinnedFrame {
    Mesh mesh;        ///< has velocity exactly when the particles have
    Spheres spheres;  ///< what the paper's tessellation leaves out: isolated particles, ends of degenerate edges
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
/// errors  the paper's smoothing of another tessellation than the paper's; particles beyond the integer range; floating
/// predicates that stay invalid after all retries source  beta mesh paper, section 3
SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch = {});

}  // namespace betamesh
