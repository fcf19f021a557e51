// Sample positions for each pixel: within the pixel, in time, on the key light and over the sky.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace betamesh {

/// The samples of eight pixels: for every use, a pair of numbers per sample and pixel.
///
/// Each use has one Owen-scrambled Sobol sequence for the whole picture. Pixels take consecutive parts of it in the
/// order of a Z curve that is shuffled at every level. So the samples of a pixel are well distributed, and so are those
/// of every block of 2^n × 2^n pixels together: the remaining error is blue noise, without a repeating pattern.
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

    /// x, y: coordinates of the pixels, 0 to 65535. count: samples per pixel, 1 to 2^20.
    PixelSamples(const std::array<int, kPixels>& x, const std::array<int, kPixels>& y, int count);

    /// One pair per pixel in the unit square [0, 1) × [0, 1).
    Pairs inSquare(Use use, int sample) const;
    /// One pair per pixel in the unit disc.
    Pairs inDisc(Use use, int sample) const;

private:
    // Index of each pixel's first sample in the unshuffled sequence.
    alignas(32) std::array<std::uint32_t, kPixels> first_;
};

}  // namespace betamesh
