// Particles of different sizes: the balls that an attribute gives them, and the parameters in those of the largest.

#pragma once

#include "betamesh/particles.h"
#include "betamesh/skin_params.h"

#include <vector>

namespace betamesh {

/// The balls of particles of different sizes. Both are empty where all particles are alike.
struct ParticleSizes {
    std::vector<double> radius;  ///< of each particle's ball, world units
    std::vector<double> rate;    ///< its change, world units per second; empty: 0
};

/// What params.radius_attribute gives each particle: params.radius times its own spacing over particleSpacing().
///
/// errors  an attribute that the particles do not have, or that is not one number per particle; a size that is not
///         positive and finite, a rate that is not finite; the message names the first particle, counted from first_row
ParticleSizes particleSizes(const Particles& particles, const SkinParams& params, std::size_t first_row = 0);

/// The parameters with all lengths that belong to a particle, such as radius, spacing and skin, as they are for one
/// whose ball has the given radius. Lengths of the world, such as bubble_gap and the walls, stay.
SkinParams withRadius(const SkinParams& params, double radius);

}  // namespace betamesh
