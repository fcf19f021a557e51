// The parameters that shape the surface, in three dimensions and in two.

#pragma once

#include "betamesh/vec3.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// Which surface is computed.
enum class SurfaceKind {
    beta,   ///< the beta mesh
    alpha,  ///< the alpha mesh: particles joined by triangles
    union_  ///< the tessellated union of balls, for comparison
};
/// How the boundary of the union of balls is divided into triangles.
enum class Tessellation {
    complete,  ///< every exposed part of every ball: closed and manifold, including drops and tendrils
    paper,     ///< the paper's fans; isolated particles and degenerate edges become separate spheres
};
/// How the signs are computed that decide the topology.
enum class PredicateKind {
    exact,     ///< exact signs with symbolic tie-breaking: never fails
    floating,  ///< the paper's test in double precision, validated, and repeated with perturbed particles
};
/// How the surface is smoothed.
enum class SmoothingMethod {
    none,      ///< not at all
    coherent,  ///< kernel fits without connectivity: continuous in time
    paper,     ///< the paper's averages over adjacent faces; only with the paper's tessellation
};

/// What happens to droplets, the connected components of the union of balls with few particles.
enum class Droplets {
    mesh,    ///< they are meshed
    points,  ///< they are not meshed; their particles are written as spheres
    drop,    ///< they are removed
};
/// What happens to tendrils, the particles in no alpha triangle but in a degenerate edge.
enum class Tendrils { mesh, points };
/// What happens to small enclosed voids.
enum class Bubbles {
    mesh,
    fill,  ///< they are removed from the mesh; only with the complete tessellation
};

/// Small features and what to do with them. Whole droplets are removed first, then tendrils until none is left; parts
/// that become separate by that are not examined for droplets again.
struct Features {
    Droplets droplets = Droplets::mesh;
    int droplet_particles = 8;  ///< components with fewer particles are droplets, >= 1; duplicates count once
    Tendrils tendrils = Tendrils::mesh;
    Bubbles bubbles = Bubbles::mesh;
    double bubble_gap = 0;     ///< fill voids in which no empty ball of this diameter fits between the particles; world
                               ///< units, >= 0; 0: use bubble_volume instead
    double bubble_volume = 0;  ///< if bubble_gap is 0: fill voids of a smaller volume; world units cubed, >= 0

    /// Are all members equal?
    bool operator==(const Features&) const = default;
};

/// Attributes of the vertices that are measured on the finished surface. All are real numbers and continuous in time.
struct SurfaceAttributes {
    bool normals = false;    ///< `N`: unit normals, outwards, from a linear fit of the vertex normals near by
    bool thickness = false;  ///< `thickness`: distance through the liquid, world units, at most 4 particle spacings
    bool curvature = false;  ///< `curvature`: mean curvature, 1 / world units, positive on drops
    bool shape = false;      ///< `drop`, `thread`, `sheet`, `bulk`: weights of these shapes, 0 to 1, with sum 1

    /// Are all members equal?
    bool operator==(const SurfaceAttributes&) const = default;
};

/// A plane wall. The liquid lies where dot(normal, position) <= offset.
struct Wall {
    Vec3 normal{0, 1, 0};  ///< out of the liquid, of unit length
    double offset = 0;     ///< world units

    /// Are all members equal?
    bool operator==(const Wall&) const = default;
};

/// All parameters of one frame's surface.
struct SkinParams {
    double radius = 0;             ///< ball radius, world units, > 0; the paper uses 1.5 particle spacings
    double spacing = 0;            ///< particle spacing dx, world units, >= 0; 0: radius / 1.5
    std::string radius_attribute;  ///< particle attribute that, times radius_scale, is each particle's own spacing, to
                                   ///< which its radius and skin are as those above to `spacing`; empty: all are alike
    double radius_scale = 1;       ///< > 0
    std::string radius_rate_attribute;  ///< particle attribute with the change of radius_attribute; empty: 0
    double radius_rate_scale = 1;       ///< times radius_scale: from that to the change of a spacing per second
    SurfaceKind surface = SurfaceKind::beta;
    Tessellation tessellation = Tessellation::complete;
    int arc_subdivisions = 0;  ///< segments per arc, >= 0, and more on arcs over 2 radians; 0: automatic. Without a
                               ///< skin that is a sagitta below 0.01 radii, 0.02 in flat parts; with one it is more,
                               ///< because long edges are split after the retraction
    PredicateKind predicates = PredicateKind::exact;
    int retries = 3;          ///< floating predicates: perturbations before an error is reported, >= 0
    double tolerance = 1e-5;  ///< floating predicates: size of the perturbation in radii, (0, 0.1]
    SmoothingMethod smoothing = SmoothingMethod::coherent;
    double smoothing_width = 0;           ///< coherent smoothing: kernel width, world units, >= 0; 0: automatic
    int passes = 1;                       ///< smoothing passes, >= 0
    std::optional<double> skin;           ///< distance of the surface from the outermost particles, world units, >= 0;
                                          ///< none: volume-true; 0: the boundary of the union of balls itself
    std::vector<std::string> attributes;  ///< names of particle attributes to interpolate to the vertices
    SurfaceAttributes surface_attributes;
    std::vector<Wall> walls;             ///< the surface is laid flat against them; complete tessellation only
    std::optional<Box> box;              ///< cut the mesh off at this box, whose coordinates are rounded to floats, and
                                         ///< close it with plane polygons; complete tessellation only
    bool resolve_intersections = false;  ///< paper's tessellation: move vertices so that no particle is outside
    Features features;
    bool components = false;  ///< number the connected components of the mesh, the largest first

    /// Are all members equal?
    bool operator==(const SkinParams&) const = default;
};

/// The particle spacing dx, world units.
double particleSpacing(const SkinParams& params);
/// Radius of the neighbourhood whose motion limits vertex velocities, world units.
double motionReach(const SkinParams& params);

/// Distance of the surface from the outermost particles, world units. 0 if the surface is the boundary of the union of
/// balls, the paper's beta mesh or the alpha mesh. Without smoothing it is 0 unless a skin is given.
double skinDepth(const SkinParams& params, int dimension = 3);

/// The same in three dimensions, raised to at least a seventh of the radius unless it is 0. The depth of a thinner skin
/// would have to be measured from balls that reach beyond the neighbourhood of the surface.
double effectiveSkinDepth(const SkinParams& params);

/// The skin of an isolated particle in two dimensions, world units. Unless a skin is given, its circle has the area of
/// one particle, dx².
double isolatedSkinDepth(const SkinParams& params);

/// Checks radius and spacing against each other.
///
/// errors  a radius of less than 0.01 or more than 100 spacings, with which no surface could be computed in a sensible
///         time and precision
void requireScale(const SkinParams& params);

/// Checks a given skin.
///
/// errors  a skin that is negative or not below the radius; a skin without the complete tessellation
void requireSkin(const SkinParams& params);

}  // namespace betamesh
