// Temporal coherence: how far a surface, and the particles inside, move from one frame to the next.

#pragma once

#include "betamesh/mesh.h"

#include <limits>
#include <optional>

namespace betamesh {

/// Parameters of surfaceDistance().
struct DistanceSampling {
    /// Of sample points inside triangles, world units, >= 0. 0: twice the mean longest side of the triangles, which
    /// gives one point in most of them.
    double spacing = 0;
    double beyond = std::numeric_limits<double>::infinity();  ///< world units: points farther than this are listed
    double thinner = 0;  ///< world units, >= 0: points where the liquid is thinner than this are excluded
};

/// A point of one of two surfaces that is far from the other surface.
struct FarPoint {
    Vec3 position;
    double distance;  ///< to the other surface, world units
    double area;      ///< surface area that the point represents, world units squared
    bool after;       ///< the point is on the second surface
};

/// Distances between two surfaces in both directions, from sample points of either to the nearest point of the other.
/// World units.
struct SurfaceDistance {
    double max = 0;          ///< Hausdorff distance; infinite if only one surface has triangles, 0 if none has
    double quantile999 = 0;  ///< 99.9 % of the two areas are nearer than this
    double rms = 0;          ///< root mean square over the two areas
    Vec3 worst{0, 0, 0};     ///< the point of either surface that is farthest from the other
    std::size_t samples = 0;
    std::vector<FarPoint> far;  ///< points beyond DistanceSampling::beyond; empty if only one surface has triangles
    double area = 0;            ///< of both surfaces, where it was measured; world units squared
};

/// Measures at all corners of triangles and at one or more points inside each. A quarter of a triangle's area is
/// assigned to its corners, the rest to the points inside. Distances below 1e-15 of the largest coordinate count as 0.
///
/// The liquid is thinner than a length at a surface point if no ball of 0.8 times that diameter fits inside the surface
/// and touches it there.
///
/// in      any meshes; triangles with missing vertices or non-finite positions are ignored. sampling.thinner requires
///         normals that point out of the liquid
/// same    bytes for any thread count
/// cost    O(samples log triangles), about 1 µs per sample where the surfaces are close; 24 bytes of memory per sample,
///         48 more per far point
SurfaceDistance surfaceDistance(const Mesh& from, const Mesh& to, const DistanceSampling& sampling = {});

/// How far particles moved between two frames. World units.
struct ParticleMotion {
    std::size_t matched = 0;
    double max = 0;                            ///< largest displacement; 0 if no particle was matched
    Vec3 farthest{0, 0, 0};                    ///< earlier position of the particle with the largest displacement
    std::optional<std::uint64_t> repeated_id;  ///< one that several particles of a frame have, if ids match
};

/// Matches particles by id if both frames have ids (the k-th particle of an id with the k-th one), else by row.
///
/// out     nothing if particles cannot be matched: no ids and different numbers of particles
std::optional<ParticleMotion> particleMotion(const Particles& from, const Particles& to);

/// The particles advected by their own velocities.
///
/// in      particles with velocity
Particles advected(const Particles& particles, double seconds);

}  // namespace betamesh
