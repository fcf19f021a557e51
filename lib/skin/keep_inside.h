// Keeps small particles beside large ones inside the surface.

#pragma once

#include "exact/snapped_particles.h"
#include "skin/beta_mesh.h"

#include <vector>

namespace betamesh {

/// A particle and the depth below the surface that it has to keep, world units.
struct DeepParticle {
    Vec3 position;
    double scale;  ///< its size in those of the largest
    double least_depth;
};

/// Those that the skin beside larger particles might pass: all that no balls alike
/// cover and that are smaller than the largest.
/// None where all are of one size, since kernels as wide as the particles' own spacing keep their distance.
///
/// skin    of the largest particle, world units
std::vector<DeepParticle> smallParticles(const SnappedParticles& snapped, double skin);

/// Moves the surface outwards near particles that are not as deep below it as they have to be, by smooth bumps as high
/// as what is missing. Where large and small particles alternate, the skin is averaged over widths in which the small
/// ones vanish.
///
/// in      spacing: of the largest particles, world units
/// same    bytes for any thread count
/// cost    O(particles); O(triangles log triangles) where some are beside larger ones, and O(log triangles) for each of
///         these; where some are not deep enough, a pass over the mesh and a few over the vertices near these
void keepInside(const std::vector<DeepParticle>& particles, double spacing, BetaMesh& mesh);

}  // namespace betamesh
