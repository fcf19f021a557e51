// Particles -> the exact boundary of the union of their balls, without droplets and tendrils that are to be left out.

#pragma once

#include "base/icosphere.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/skin_params.h"
#include "exact/snapped_particles.h"
#include "skin/ball_boundary.h"
#include "skin/features.h"
#include "skin/near_surface.h"
#include "skin/particle_sizes.h"

namespace betamesh {

/// The boundary that a frame's surface is made of, and what was left out of it.
struct Structure {
    SnappedParticles snapped;  ///< particles without those left out as droplets or tendrils
    BallBoundary boundary;
    double reference_radius = 0;  ///< of balls that Features::bubble_gap is meant for, world units
    Icosphere directions;  ///< directions in which points inside faces are sought; none where they are not needed
    Spheres spheres;       ///< left-out particles that are kept as spheres
    std::size_t distinct_particles = 0;
    RemovedDroplets left_out;
    std::size_t tendril_particles = 0;
    int retries = 0;  ///< perturbations that floating-point predicates needed
};

/// The structure of a frame, with params.predicates.
///
/// in      near: of the particles, as in skinFrame(); used with exact predicates only. sizes: of the particles, whose
///         largest ball params belong to
/// same    result for any thread count and particle order
/// cost    O(n); with floating-point predicates that times the number of attempts
/// errors  floating-point predicates: an edge that stays without its opposite after params.retries
/// source  beta mesh paper, section 3.2; its perturbation by `tolerance`
Structure exposedStructure(const Particles& particles, const NearSurface& near, const SkinParams& params,
                           const ParticleSizes& sizes, Icosphere&& directions);

}  // namespace betamesh
