// What the benches skin.

#pragma once

#include "betamesh/particles.h"

namespace betamesh {

/// About n particles at spacing 1: nine in ten in a block jittered by a quarter of the spacing, the others
/// in a one-particle sheet above it and in drops of one to eight.
Particles splash(std::size_t n);

/// Likewise, but 98 in a hundred in the block.
Particles calm(std::size_t n);

/// About n particles as FLIP leaves them: a block of cells of two spacings, with eight particles each inside and 32 to
/// 64 in those along its surface, half of these in clumps a hundredth of a spacing wide.
Particles clumped(std::size_t n);

/// At a radius of 1.5: n particles apart, three in four of which meet no other.
Particles spray(std::size_t n);

/// n particles on a sphere, each with 560 others within 3: a closed sheet without thickness.
Particles denseSheet(std::size_t n);

/// n particles on a line, each with 600 others within 3.
Particles denseThread(std::size_t n);

}  // namespace betamesh
