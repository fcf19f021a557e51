// Which particles matter to the surface, told from their positions as these pass by: the others need never be in
// memory.

#pragma once

#include "betamesh/skin_params.h"
#include "exact/snapped_particles.h"

#include <memory>

namespace betamesh {

/// Goes through the positions of all particles, some rows after others, and keeps six bytes of each; twelve at the end.
///
/// What matters: cells with a ball that may be exposed, and those round them, as all that is asked of an exposed ball
/// lies within 2R of it. Where droplets are to be told apart so many cells m more that none of them reaches a cell
/// beside one that was left out: no exposed ball is within m - 1 cells of a particle there, so the ball of (2m - 3) R
/// round it is full, which takes (2m - 3)³ particles at least, all of its component. Particles anywhere that might be
/// duplicates stay, too, so that those left out are all distinct. Floating-point predicates move particles, and
/// tendrils that leave uncover others: there all particles matter.
///
/// same    result for any thread count and any division into rows
/// cost    O(n), some 90 ns a particle; 64 bytes a cell
/// errors  as snapParticles; 2^32 particles
class NearSurfaceFinder {
public:
    explicit NearSurfaceFinder(const SkinParams& params);
    ~NearSurfaceFinder();
    NearSurfaceFinder(const NearSurfaceFinder&) = delete;
    NearSurfaceFinder& operator=(const NearSurfaceFinder&) = delete;

    void add(std::span<const Vec3f> positions);
    /// To be called once.
    NearSurface find();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace betamesh
