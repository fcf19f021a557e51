// What the benches skin: a block of liquid with what a splash adds to it.

#pragma once

#include "core/particles.h"

namespace betamesh {

/// About n particles at spacing 1: nine in ten in a block jittered by a quarter of the spacing, the others
/// in a one-particle sheet above it and in drops of one to eight.
Particles splash(std::size_t n);

}  // namespace betamesh
