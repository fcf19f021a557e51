// Particle clouds for benchmarks.

#pragma once

#include "betamesh/particles.h"

namespace betamesh {

/// About n particles at a spacing of 1: nine in ten in a block jittered by a quarter of the spacing, the others in a
/// sheet one particle thick above it and in drops of one to eight particles.
Particles splash(std::size_t n);

/// Like splash(), but with 98 particles in a hundred in the block.
Particles calm(std::size_t n);

/// About n particles as FLIP solvers leave them: a block of cells two spacings wide, with eight particles per inner
/// cell and 32 to 64 per cell at the surface, half of these in clumps a hundredth of a spacing wide.
Particles clumped(std::size_t n);

/// n scattered particles; for a radius of 1.5, three balls in four touch no other.
Particles spray(std::size_t n);

/// n particles on a sphere, each with 560 others within a distance of 3.
Particles denseSheet(std::size_t n);

/// n particles on a line, each with 600 others within a distance of 3.
Particles denseThread(std::size_t n);

}  // namespace betamesh
