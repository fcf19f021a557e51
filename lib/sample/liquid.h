// A small liquid solver, good enough to splash. Incompressible, no viscosity, a crude surface tension.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <cstdint>
#include <vector>

namespace betamesh {

/// A box of whole cells: low <= cell < high.
struct CellBox {
    Vec3i low{0, 0, 0}, high{0, 0, 0};
    bool contains(const Vec3i& cell) const {
        return cell.x >= low.x && cell.y >= low.y && cell.z >= low.z && cell.x < high.x && cell.y < high.y &&
               cell.z < high.z;
    }
};

/// What the liquid lives in. Lengths in cells, time in seconds.
struct Surroundings {
    Vec3 gravity{0, 0, 0};  ///< cells per second squared
    double cohesion = 0;    ///< cells per second squared, of one particle on another, >= 0
    bool tank = false;      ///< solid beyond tank_box, which has no lid (y is up); otherwise free flight
    CellBox tank_box;
    CellBox obstacle;  ///< solid; empty if there is none
    double crowd = 8;  ///< particles in a full cell

    bool solid(const Vec3i& cell) const;
};

/// Row i of every array is a particle; step() changes their order, ids tell which is which.
struct Liquid {
    std::vector<Vec3> position;                 ///< cells
    std::vector<Vec3> velocity;                 ///< cells per second, of the liquid at the particle
    std::vector<std::array<Vec3, 3>> gradient;  ///< of each component of the velocity, per second
    std::vector<Vec3> moved;                    ///< cells per second: displacement of the last step over its time
    std::vector<std::uint32_t> id;
};

/// Moves the liquid on, in as many steps as it takes for nothing to cross a whole cell at once.
///
/// same    bytes for any thread count: loops gather, sums are added in a fixed order
/// cost    O(n) a step for n particles; the pressure takes some tens of sweeps over the wet cells
/// source  Harlow & Welch 1965 (staggered grid); Zhu & Bridson 2005 (particles carry the velocity);
///         Jiang et al. 2015 (and its gradient, so that rotation survives)
void advance(Liquid& liquid, const Surroundings& surroundings, double seconds);

}  // namespace betamesh
