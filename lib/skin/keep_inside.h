// Keeps particles inside the surface: small ones beside large ones, and all where the skin is thin.

#pragma once

#include "exact/snapped_particles.h"
#include "mesh/triangle_tree.h"
#include "skin/beta_mesh.h"

#include <optional>
#include <vector>

namespace betamesh {

/// A particle and the depth below the surface that it has to keep, world units.
struct ParticleAtRisk {
    Vec3 position;
    double scale;  ///< its size in those of the largest
    double least_depth;
};

/// Particles that the surface might pass: all of these, or those of them beside larger ones.
struct ParticlesAtRisk {
    std::vector<ParticleAtRisk> particle;
    bool all_are_at_risk = false;
};

/// If all are at risk, those that may be exposed. Else all that no balls alike cover and that are smaller than the
/// largest; none where all are of one size, since kernels as wide as the particles' own spacing keep their distance.
///
/// skin    of the largest particle, world units
ParticlesAtRisk particlesAtRisk(const SnappedParticles& snapped, double skin, bool all_are_at_risk);

/// Keeps particles inside a surface that moves. Where large and small particles alternate, the skin is averaged over
/// widths in which the small ones vanish; if it is thin, facets that are long for its depth cut off particles.
///
/// same    bytes for any thread count
class InsideKeeper {
public:
    /// spacing: of the largest particles, world units. The mesh is referred to; afterwards only the positions of its
    /// vertices may change.
    ///
    /// cost    O(particles); O(triangles log triangles) if any are at risk
    InsideKeeper(const ParticlesAtRisk& at_risk, double spacing, BetaMesh& mesh);
    InsideKeeper(const InsideKeeper&) = delete;
    InsideKeeper& operator=(const InsideKeeper&) = delete;

    /// Moves the surface outwards near particles that are not as deep below it as they have to be, by smooth bumps as
    /// high as what is missing. To be called first.
    ///
    /// cost    O(triangles), and O(log triangles) for each particle at risk; where some are not deep enough, a
    ///         few passes over the vertices near these
    void raise();
    /// Takes back displacements near particles that are outside, which happens where bumps hinder each other, or where
    /// removing self-intersections takes some back: those nearby in full, in a neighbourhood that doubles with every
    /// call. Not continuous in time.
    ///
    /// in      from: positions of the vertices before the displacement, where all particles are inside
    /// out     was any outside?
    /// cost    O(triangles), and O(log triangles) for each particle that the surface may have passed
    bool restore(const DualPoints& from);

private:
    std::vector<ParticleAtRisk> particles_;  // at risk
    bool mayHavePassed(const Vec3& point) const;

    BetaMesh& mesh_;
    std::vector<Vec3> position_;             // of the mesh; none without particles
    std::vector<Vec3> tested_;               // positions when raise() was called
    std::vector<std::uint8_t> is_enclosed_;  // whether each particle was inside then
    double margin_;                          // of the boxes in the tree
    std::optional<TriangleTree> tree_;
    double restored_reach_ = 2;  // around particles that are outside, in distances to where they ought to be
};

}  // namespace betamesh
