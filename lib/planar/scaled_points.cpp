#include "planar/scaled_points.h"

#include "base/octaves.h"

#include <utility>

namespace betamesh {

std::vector<ScaleClass> scaleClasses(std::size_t n, std::span<const double> scale) {
    std::vector<std::vector<std::uint32_t>> octaves = byOctave(allRows(n), scale);
    std::vector<ScaleClass> classes;
    for (std::size_t octave = 0; octave < octaves.size(); ++octave)
        if (scale.empty() || !octaves[octave].empty())
            classes.push_back({largestOfOctave(octave), std::move(octaves[octave])});
    return classes;
}

}  // namespace betamesh
