// One binary, several instruction sets: a function marked so is compiled for each and chosen at run time.
// Its results must not depend on the choice; contraction to fused multiply-add is off everywhere.

#pragma once

#include <cstddef>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define BETAMESH_EVERY_CPU __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BETAMESH_EVERY_CPU
#endif

namespace betamesh {

/// As many floats as the widest registers hold. Narrower ones take a few for it; all of them work lane by lane.
inline constexpr std::size_t kLanes = 16;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
/// As many as every processor has registers for.
using Quad = float __attribute__((vector_size(4 * sizeof(float))));

}  // namespace betamesh
