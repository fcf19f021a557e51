// What a surface can be asked to be, in space and in a plane.

#pragma once

#include <optional>
#include <string>
#include <vector>

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

/// What becomes of droplets: connected components of the union of balls with few particles.
enum class Droplets {
    mesh,    ///< surfaces like any other
    points,  ///< they leave the mesh; their particles become external spheres
    drop,    ///< they leave altogether
};
/// What becomes of tendrils: particles in no alpha triangle, but in a degenerate edge.
enum class Tendrils { mesh, points };
/// What becomes of small enclosed voids.
enum class Bubbles {
    mesh,
    fill,  ///< they are no part of the mesh; for the complete tessellation alone
};

/// Droplets leave first, whole; then tendrils, until none is left, and where they held things together these are not
/// judged again.
struct Features {
    Droplets droplets = Droplets::mesh;
    int droplet_particles = 8;  ///< what has fewer particles is a droplet, >= 1; all particles count, duplicates once
    Tendrils tendrils = Tendrils::mesh;
    Bubbles bubbles = Bubbles::mesh;
    double bubble_gap = 0;     ///< voids in which no empty ball of this diameter fits between the particles are filled;
                               ///< world units, >= 0; 0: bubble_volume says which
    double bubble_volume = 0;  ///< without a bubble_gap: voids that enclose less are filled; world units cubed, >= 0
};

/// Everything that shapes the surface of one frame.
struct SkinParams {
    double radius = 0;   ///< of the balls, world units, > 0; the paper uses 1.5 particle spacings
    double spacing = 0;  ///< of the particles (dx), world units, >= 0; 0: radius / 1.5
    SurfaceKind surface = SurfaceKind::beta;
    Tessellation tessellation = Tessellation::complete;
    int arc_subdivisions = 0;  ///< segments of every arc, >= 0; 0: sagitta below 0.01 radii; 0.02 where smoothed flat
    PredicateKind predicates = PredicateKind::exact;
    int retries = 3;          ///< floating predicates: how often particles are jittered before giving up, >= 0
    double tolerance = 1e-5;  ///< floating predicates: size of the jitter in radii, (0, 0.1]
    SmoothingMethod smoothing = SmoothingMethod::coherent;
    double smoothing_width = 0;           ///< coherent: its reach, world units, >= 0; 0: 2.8 radii
    int passes = 1;                       ///< of smoothing, >= 0
    std::optional<double> skin;           ///< how far the surface lies from the outermost particles, world units, >= 0;
                                          ///< none: volume-true; 0: the boundary of the union of balls itself
    double inset = 0;                     ///< inwards where the liquid is thick, world units, >= 0; not with paper
    std::vector<std::string> attributes;  ///< of the particles, carried to the mesh's vertices
    bool resolve_intersections = false;   ///< the paper's tessellation: push vertices out to particles that lie outside
    Features features;
    bool components = false;  ///< number the connected pieces of the mesh, the largest first
};

/// The particle spacing dx, world units.
double particleSpacing(const SkinParams& params);
/// Radius of the neighbourhood from which limitVelocities() estimates the liquid's motion, world units.
double liquidReach(const SkinParams& params);

/// How far the surface lies from the outermost particles, world units. 0 where it is the boundary of the union of
/// balls, or what the paper or the alpha mesh make of that. A surface that is not smoothed stays there unless a skin is
/// given.
double skinDepth(const SkinParams& params, int dimension = 3);

/// The same in three dimensions, but at least a seventh of the radius, or 0: thinner skins would need balls too large to
/// look for, and are drawn so.
double leastSkin(const SkinParams& params);

/// The skin of a particle alone in two dimensions, world units: a circle of the area that a particle stands for, where
/// no skin is given.
double loneSkinDepth(const SkinParams& params);

/// errors  a given skin that is negative or at or above the radius; one of a surface other than the complete
/// tessellation
void requireSkin(const SkinParams& params);

}  // namespace betamesh
