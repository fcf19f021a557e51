// Means over space of the scales of samples: the local particle spacing where balls of different sizes meet.

#pragma once

#include "base/sample_groups.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace betamesh {

/// Scales around points, in that of the largest ball. Where parts of a boundary appear or vanish, balls of different
/// scales meet in one point; only scales that are means over space are the same for all that lies there.
class ScaleMeans {
public:
    struct Scales {
        std::vector<float> mean;  ///< Σ w K s / Σ w K over samples with scales s
        std::vector<float> least;  ///< the same of s⁻⁸, to the power -1/8: near the smallest with more than a little w
    };

    /// in      position, weight w and scale s of each sample; width of the kernel K = (1 - |y|²/width²)₊² where the
    ///         scale is 1, world units
    ScaleMeans(const std::vector<Vec3>& position, const std::vector<float>& weight, const std::vector<float>& scale,
               double width);

    /// Replaces the scales of some points, which are first guesses, by those of the samples around, if there are any.
    /// Kernels are as wide as the mean says, which is therefore computed several times.
    ///
    /// cost    O(rows · samples within reach)
    void average(const std::vector<std::uint32_t>& rows, const std::function<Vec3(std::uint32_t)>& positionOf,
                 Scales& scales) const;

private:
    enum Field { kX, kY, kZ, kWeight, kScale, kInversePower, kFields };

    std::vector<SampleCloud<kFields>> clouds_;  // for points of each octave
};

}  // namespace betamesh
