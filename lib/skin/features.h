// Features of a liquid that are treated apart: droplets, tendrils, and the components of the mesh.

#pragma once

#include "betamesh/skin_params.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/beta_mesh.h"

namespace betamesh {

/// Small connected components of the union of balls. Two balls are connected if they meet or touch.
struct SmallComponents {
    std::size_t count = 0;
    std::vector<std::uint32_t> particle;  ///< rows of SnappedParticles in these components, ascending
};

/// The components of fewer than `least` particles. All particles count, exposed or covered, duplicates once; components
/// that reach cells beside which particles were left out count as large.
///
/// same    result for any thread count and particle order
/// cost    O(n log n)
SmallComponents smallComponents(const SnappedParticles& particles, std::size_t least);

/// All particles except the given rows, which are ascending.
SnappedParticles withoutRows(const SnappedParticles& particles, const std::vector<std::uint32_t>& rows);

/// Appends the given rows, in their order, as spheres of the balls' radius.
void addSpheres(const Particles& particles, const SnappedParticles& snapped, const std::vector<std::uint32_t>& rows,
                Spheres& spheres);

/// Numbers of droplets removed, and of the distinct particles in them.
struct RemovedDroplets {
    std::size_t droplets = 0, particles = 0;
};

/// Removes droplets from the particles as the features ask; droplets to be kept as points are appended to `apart`.
RemovedDroplets removeDroplets(const Particles& particles, const Features& features, SnappedParticles& snapped,
                               Spheres& apart);

/// Particles of threads that are a single particle thick: those that a degenerate edge uses, but no alpha triangle.
/// Rows of SnappedParticles, ascending.
std::vector<std::uint32_t> tendrilParticles(const BallBoundary& boundary);

/// Sets mesh.component. Components are numbered by enclosed volume, the largest first: 0 is the largest body of liquid,
/// bubbles come last. Ties are broken by the lexicographically first vertex.
///
/// same    numbers for any thread count
/// cost    O(triangles)
void labelComponents(Mesh& mesh);

}  // namespace betamesh
