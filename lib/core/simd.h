// One binary, several instruction sets: a function marked so is compiled for each and chosen at run time.
// Its results must not depend on the choice; contraction to fused multiply-add is off everywhere.

#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define BETAMESH_EVERY_CPU __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BETAMESH_EVERY_CPU
#endif
