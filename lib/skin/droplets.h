// Droplets, and how particles leave what is to be meshed.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/skin_params.h"
#include "exact/snapped_particles.h"

namespace betamesh {

/// Connected components of the union of balls, two balls being joined where they meet or touch.
struct SmallComponents {
    std::size_t count = 0;
    std::vector<std::uint32_t> particle;  ///< theirs, as rows of SnappedParticles, ascending
};

/// The components of fewer than so many particles. All particles count, exposed or buried, duplicates once; so do those
/// that were left out beyond the rim, which only large components have.
///
/// same    result for any thread count and particle order
/// cost    O(n log n)
SmallComponents smallComponents(const SnappedParticles& particles, std::size_t least);

/// All but some rows, which are ascending.
SnappedParticles without(const SnappedParticles& particles, const std::vector<std::uint32_t>& rows);

/// Adds some rows, in their order, as spheres of the balls' radius.
void addSpheres(const Particles& particles, const SnappedParticles& snapped, const std::vector<std::uint32_t>& rows,
                Spheres& spheres);

/// What left as droplets.
struct LeftOut {
    std::size_t droplets = 0, particles = 0;  ///< distinct ones
};

/// Takes droplets out of the particles, as features ask for; those that are to be kept become spheres.
LeftOut leaveOutDroplets(const Particles& particles, const Features& features, SnappedParticles& snapped,
                         Spheres& apart);

}  // namespace betamesh
