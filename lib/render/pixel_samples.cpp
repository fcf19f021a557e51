
#include "render/pixel_samples.h"

#include "base/random.h"
#include "base/simd.h"

#include <bit>

namespace betamesh {
namespace {

/// Moves bit i to bit 2 i.
[[gnu::always_inline]] inline std::uint32_t spreadBits(std::uint32_t x) {
    x = (x | x << 8) & 0x00ff00ff;
    x = (x | x << 4) & 0x0f0f0f0f;
    x = (x | x << 2) & 0x33333333;
    return (x | x << 1) & 0x55555555;
}

[[gnu::always_inline]] inline std::uint32_t reversed(std::uint32_t x) {
    x = x << 16 | x >> 16;
    x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

/// Flips each bit or not, depending on the seed and the bits below it.
[[gnu::always_inline]] inline std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

/// Second coordinate of a point of the Sobol sequence, with reversed bits; the first coordinate, likewise reversed, is
/// the index itself. Bit j is the parity of the index bits i for which the binomial coefficient (i over j) is odd.
[[gnu::always_inline]] inline std::uint32_t secondReversed(std::uint32_t x) {
    x ^= x >> 1 & 0x55555555;
    x ^= x >> 2 & 0x33333333;
    x ^= x >> 4 & 0x0f0f0f0f;
    x ^= x >> 8 & 0x00ff00ff;
    return x ^ x >> 16;
}

/// A number in [0, 1). Converts a signed integer, for which every processor has an instruction.
[[gnu::always_inline]] inline float unit(std::uint32_t x) {
    return static_cast<float>(static_cast<std::int32_t>(x >> 8)) * 0x1p-24f;
}

[[gnu::always_inline]] inline void setPairs(const std::uint32_t* first, std::uint32_t use, int sample, float* x,
                                            float* y) {
    const auto seed = [&](std::uint32_t i) { return static_cast<std::uint32_t>(hash(use, i)); };
    const std::uint32_t shuffle = seed(0), of_x = seed(1), of_y = seed(2);
    for (std::size_t i = 0; i < PixelSamples::kPixels; ++i) {
        const std::uint32_t index =
            reversed(scrambled(reversed(first[i] | static_cast<std::uint32_t>(sample)), shuffle));
        x[i] = unit(reversed(scrambled(index, of_x)));
        y[i] = unit(reversed(scrambled(secondReversed(index), of_y)));
    }
}

}  // namespace

// If pixels times samples exceed 2^32, the pattern repeats hundreds of pixels away.
PixelSamples::PixelSamples(const std::array<int, kPixels>& x, const std::array<int, kPixels>& y, int count) {
    const int bits = std::bit_width(static_cast<std::uint32_t>(count) - 1);
    for (std::size_t i = 0; i < kPixels; ++i)
        first_[i] = (spreadBits(static_cast<std::uint32_t>(x[i])) | spreadBits(static_cast<std::uint32_t>(y[i])) << 1)
                    << bits;
}

BETAMESH_EVERY_CPU
PixelSamples::Pairs PixelSamples::inSquare(Use use, int sample) const {
    Pairs pairs;
    setPairs(first_.data(), static_cast<std::uint32_t>(use), sample, pairs.x.data(), pairs.y.data());
    return pairs;
}

// Maps concentric squares to circles and preserves relative areas.
// source  Shirley & Chiu 1997, "A low distortion map between disk and square"
BETAMESH_EVERY_CPU
PixelSamples::Pairs PixelSamples::inDisc(Use use, int sample) const {
    Pairs pairs;
    setPairs(first_.data(), static_cast<std::uint32_t>(use), sample, pairs.x.data(), pairs.y.data());
    for (std::size_t i = 0; i < kPixels; ++i) {
        const float a = 2 * pairs.x[i] - 1, b = 2 * pairs.y[i] - 1;
        const bool wide = a * a > b * b;
        const float radius = wide ? a : b, other = wide ? b : a;
        const float angle = other / (radius != 0 ? radius : 1.0f) * 0.78539816f;  // at most pi / 4
        const float t = angle * angle;
        const float cosine = radius * (1 - t * (0.5f - t * (1.0f / 24 - t * (1.0f / 720))));
        const float sine = radius * angle * (1 - t * (1.0f / 6 - t * (1.0f / 120 - t * (1.0f / 5040))));
        pairs.x[i] = wide ? cosine : sine;
        pairs.y[i] = wide ? sine : cosine;
    }
    return pairs;
}

}  // namespace betamesh
