// Where the samples of pixels fall: in the pixel, in the shutter, on the lights.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace betamesh {

/// The samples of eight pixels: for every use, a pair of numbers for each sample of each pixel.
///
/// The pairs of one use are a stretch of one Owen-scrambled Sobol sequence over the whole picture, in which pixels
/// follow each other along a Z curve that is shuffled at every level. So the samples of a pixel are spread evenly, and
/// so are those of every square of 2^n × 2^n pixels together: what error is left differs from one pixel to the next and
/// averages out over few of them, without any pattern that repeats.
///
/// source  Ahmed & Wonka 2020, "Screen-space blue-noise diffusion of Monte Carlo sampling error via hierarchical
///         ordering of pixels"; Laine & Karras 2011 with the constants of Vegdahl 2021 for the scrambling
class PixelSamples {
public:
    enum class Use : std::uint32_t { pixel, shutter, key_light, sky };
    static constexpr std::size_t kPixels = 8;
    struct Pairs {
        alignas(32) std::array<float, kPixels> x, y;
    };

    /// x, y: of the pixels, 0 to 65535. count: samples of each of them, 1 to 2^20.
    PixelSamples(const std::array<int, kPixels>& x, const std::array<int, kPixels>& y, int count);

    /// In the unit square, [0, 1) × [0, 1).
    Pairs inSquare(Use use, int sample) const;
    /// In the unit disc.
    Pairs inDisc(Use use, int sample) const;

private:
    alignas(32) std::array<std::uint32_t, kPixels> first_;  // sample of each in the sequence, before it is shuffled
};

}  // namespace betamesh
