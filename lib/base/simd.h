// Vector code for several instruction sets in one binary. A function marked BETAMESH_EVERY_CPU is compiled for each of
// them, and the best version is chosen at run time. Results must not depend on the choice; contraction to fused
// multiply-add is off everywhere.

#pragma once

#include <cstddef>
#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define BETAMESH_SEVERAL_CPUS
#define BETAMESH_EVERY_CPU __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BETAMESH_EVERY_CPU
#endif

namespace betamesh {

template <typename T, std::size_t kWidth>
struct VectorOf {
    typedef T Type __attribute__((vector_size(kWidth * sizeof(T))));
};
/// Vectors of kWidth numbers, held in one register or a few.
template <std::size_t kWidth>
using Floats = typename VectorOf<float, kWidth>::Type;
template <std::size_t kWidth>
using Doubles = typename VectorOf<double, kWidth>::Type;

/// The number of floats in the widest registers (512 bits). With narrower ones a pack takes several registers.
inline constexpr std::size_t kLanes = 16;
using Lanes = Floats<kLanes>;

/// Copies lanes [first, first + kWidth) of n packs into n narrower vectors.
template <std::size_t kWidth, std::size_t n>
__attribute__((always_inline)) inline void getLanes(const Lanes (&lanes)[n], std::size_t first,
                                                    Floats<kWidth> (&part)[n]) {
    for (std::size_t i = 0; i < n; ++i)
        std::memcpy(&part[i], reinterpret_cast<const float*>(&lanes[i]) + first, sizeof part[i]);
}
template <std::size_t kWidth>
__attribute__((always_inline)) inline void getLanes(const Lanes& lanes, std::size_t first, Floats<kWidth>& part) {
    std::memcpy(&part, reinterpret_cast<const float*>(&lanes) + first, sizeof part);
}
template <std::size_t kWidth, std::size_t n>
__attribute__((always_inline)) inline void setLanes(Lanes (&lanes)[n], std::size_t first,
                                                    const Floats<kWidth> (&part)[n]) {
    for (std::size_t i = 0; i < n; ++i)
        std::memcpy(reinterpret_cast<float*>(&lanes[i]) + first, &part[i], sizeof part[i]);
}

/// Sets lane i to i.
template <std::size_t kWidth>
__attribute__((always_inline)) inline void setLaneNumbers(Floats<kWidth>& numbers) {
    for (std::size_t lane = 0; lane < kWidth; ++lane) numbers[lane] = static_cast<float>(lane);
}

/// The largest lane.
template <std::size_t kWidth>
__attribute__((always_inline)) inline void largestLane(const Floats<kWidth>& values, float& largest) {
    if constexpr (kWidth == 1) {
        largest = values[0];
    } else {
        Floats<kWidth / 2> low, high;
        std::memcpy(&low, &values, sizeof low);
        std::memcpy(&high, reinterpret_cast<const float*>(&values) + kWidth / 2, sizeof high);
        largestLane<kWidth / 2>(high > low ? high : low, largest);
    }
}
/// The smallest of `numbers` among the lanes whose value equals `value`.
template <std::size_t kWidth>
__attribute__((always_inline)) inline void firstLaneEqual(const Floats<kWidth>& values, float value,
                                                          const Floats<kWidth>& numbers, float& first) {
    const Floats<kWidth> never = Floats<kWidth>{} - 1e30F, minus = 0 - numbers;
    largestLane<kWidth>(values < value ? never : minus, first);
    first = -first;
}

#if defined(BETAMESH_SEVERAL_CPUS)
template <typename Kernel>
__attribute__((target("arch=x86-64-v4"))) void onV4(const Kernel& kernel) {
    kernel.template operator()<16>();
}
template <typename Kernel>
__attribute__((target("arch=x86-64-v3"))) void onV3(const Kernel& kernel) {
    kernel.template operator()<8>();
}
#endif

/// Calls kernel.operator()<kWidth>(), compiled for this processor, whose registers hold kWidth floats. The kernel and
/// all that it calls have to be always_inline. Needed by kernels that select by comparing lanes, which g++ does not
/// vectorise for packs wider than a register, and by kernels that keep many values in registers.
template <typename Kernel>
void onThisCpu(const Kernel& kernel) {
#if defined(BETAMESH_SEVERAL_CPUS)
    static const int level = __builtin_cpu_supports("x86-64-v4") ? 4 : __builtin_cpu_supports("x86-64-v3") ? 3 : 2;
    if (level == 4) return onV4(kernel);
    if (level == 3) return onV3(kernel);
#endif
    kernel.template operator()<4>();
}

template <typename Kernel>
struct AllLanes {
    const Kernel& kernel;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        for (std::size_t first = 0; first < kLanes; first += kWidth) kernel.template operator()<kWidth>(first);
    }
};
/// Likewise calls kernel.operator()<kWidth>(first) until all kLanes lanes are done, kWidth of them per call.
template <typename Kernel>
void forLanes(const Kernel& kernel) {
    onThisCpu(AllLanes<Kernel>{kernel});
}

}  // namespace betamesh
