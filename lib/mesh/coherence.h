// How far a surface moves, or jumps, from one moment to the next.

#pragma once

#include "betamesh/mesh.h"

#include <limits>
#include <optional>

namespace betamesh {

struct DistanceSampling {
    double spacing =
        0;  ///< of points inside triangles, world units, >= 0; 0: twice a common side, one in most triangles
    double beyond = std::numeric_limits<double>::infinity();  ///< world units: points farther than this are listed
    double thinner = 0;  ///< world units, >= 0: points where the liquid is thinner are left out
};

/// A point of one of two surfaces that is far from the other.
struct FarPoint {
    Vec3 position;
    double distance;  ///< world units
    double area;      ///< that it stands for, world units squared
    bool after;       ///< on the second surface
};

/// Between two surfaces, both ways: points of each and the way from there to the nearest point of the other.
/// World units.
struct SurfaceDistance {
    double max = 0;          ///< infinite where only one of them has triangles, 0 where none has
    double quantile999 = 0;  ///< 99.9 % of the two areas are nearer than this
    double rms = 0;          ///< over the two areas
    Vec3 worst{0, 0, 0};     ///< the point of either surface that is farthest from the other
    std::size_t samples = 0;
    std::vector<FarPoint> far;  ///< where asked for; none where only one of them has triangles
};

/// The points are all corners of triangles and at least one inside each: a quarter of a triangle's area is at
/// its corners, the rest inside. What is nearer than 1e-15 of the largest coordinate counts as 0.
///
/// Where the liquid is thinner than a length: there is no room in it for a ball of four fifths of this diameter that
/// touches the surface at the point.
///
/// in      any meshes; triangles with missing vertices or positions that are not finite are left out; outward normals
///         where thin liquid is left out
/// same    bytes for any thread count
/// cost    O(samples log triangles), about 1 µs each where the surfaces are close; 24 bytes of memory each, 48 more
/// where
///         far
SurfaceDistance surfaceDistance(const Mesh& from, const Mesh& to, const DistanceSampling& sampling = {});

/// How far particles went. World units.
struct ParticleMotion {
    std::size_t matched = 0;
    double max = 0;          ///< 0 where none were matched
    Vec3 farthest{0, 0, 0};  ///< where the one that went farthest was
};

/// Matches particles by id where both have ids (the k-th of an id with the k-th), else by row.
///
/// out     nothing where neither is possible: no ids and different numbers of particles
std::optional<ParticleMotion> particleMotion(const Particles& from, const Particles& to);

/// The particles where their velocity takes them in a time.
///
/// in      particles with velocity
Particles moved(const Particles& particles, double seconds);

}  // namespace betamesh
