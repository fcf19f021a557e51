// A small particle-in-cell solver for sample scenes: incompressible, without viscosity, with simple surface tension.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <cstdint>
#include <vector>

namespace betamesh {

/// A box of grid cells: low <= cell < high.
struct CellBox {
    Vec3i low{0, 0, 0}, high{0, 0, 0};
    bool contains(const Vec3i& cell) const {
        return cell.x >= low.x && cell.y >= low.y && cell.z >= low.z && cell.x < high.x && cell.y < high.y &&
               cell.z < high.z;
    }
};

/// Forces on the liquid and solid obstacles. Lengths in cells, time in seconds.
struct Surroundings {
    Vec3 gravity{0, 0, 0};  ///< cells per second squared
    double cohesion = 0;    ///< strength of the attraction between particles, cells per second squared, >= 0
    bool tank = false;      ///< true: solid outside tank_box, which is open at the top (y is up); false: no solids
    CellBox tank_box;
    CellBox obstacle;               ///< solid; may be empty
    double particles_per_cell = 8;  ///< of liquid at rest density

    bool solid(const Vec3i& cell) const;
};

/// Row i of every array is one particle. advance() changes the order of the rows; ids identify particles.
struct Liquid {
    std::vector<Vec3> position;                 ///< cells
    std::vector<Vec3> velocity;                 ///< cells per second
    std::vector<std::array<Vec3, 3>> gradient;  ///< of each component of the velocity, 1 / seconds
    std::vector<Vec3> moved;  ///< displacement in the last step divided by its duration, cells per second
    std::vector<std::uint32_t> id;
};

/// Advances the liquid in time, in as many steps as needed for no particle to cross a whole cell in one step.
///
/// same    bytes for any thread count: loops gather, and sums are added in a fixed order
/// cost    O(n) per step for n particles; the pressure takes some tens of iterations over the cells with liquid
/// source  Harlow & Welch 1965 (staggered grid); Zhu & Bridson 2005 (velocities on particles);
///         Jiang et al. 2015 (velocity gradients on particles, which preserve rotation)
void advance(Liquid& liquid, const Surroundings& surroundings, double seconds);

}  // namespace betamesh
