// Which particles can influence the surface, decided from a stream of positions: the others need never be in memory.

#pragma once

#include "betamesh/skin_params.h"
#include "exact/snapped_particles.h"

#include <memory>

namespace betamesh {

/// Reads the positions of all particles in batches. Keeps six bytes per particle, at the end twelve.
///
/// Kept are all particles of cells with an exposure candidate and of the cells round those, since everything that
/// decides about an exposed ball lies within 2R of it. Where droplets are treated apart, the margin is m cells, so wide
/// that no droplet reaches a cell beside one left out: no exposed ball is within m - 1 cells of a particle there, so
/// the ball of radius (2m - 3) R round it is full, which takes at least (2m - 3)³ particles of its component.
/// Particles elsewhere that might be duplicates are kept as well, so that those left out are distinct. All particles
/// are kept where coverage is not final: floating-point predicates move particles, and tendrils that are removed
/// uncover others.
///
/// Of balls of different radii, R is the largest, which only the end of the stream tells: until then positions and
/// radii are kept, 20 bytes per particle, at the end about 50. Balls are found covered among those of nearly the same
/// radius; all others are exposure candidates. All that is said above holds, since no ball reaches farther than R.
///
/// same    result for any thread count and any division into batches
/// cost    O(n), about 90 ns per particle, of different radii 300 to 900 ns; 64 bytes per cell
/// errors  as snapParticles; 2^32 particles
class NearSurfaceFinder {
public:
    /// params: those for the radius of all balls, or as the caller has them if add() gets radii.
    explicit NearSurfaceFinder(const SkinParams& params);
    ~NearSurfaceFinder();
    NearSurfaceFinder(const NearSurfaceFinder&) = delete;
    NearSurfaceFinder& operator=(const NearSurfaceFinder&) = delete;

    /// Adds the next batch of positions.
    void add(std::span<const Vec3f> positions);
    /// The same with the radius of each ball, > 0, world units. Either all batches have radii or none, except for those
    /// without particles.
    void add(std::span<const Vec3f> positions, std::span<const double> radii);
    /// May be called only once.
    NearSurface find();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace betamesh
