// Scales sorted by octaves: sums whose reach differs from point to point search for one octave at a time.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace betamesh {

/// The octave k of a scale, which is in (2^-(k+1), 2^-k]; 0 for scales above 1.
inline std::size_t octaveOf(double scale) {
    int exponent = 0;
    const double mantissa = std::frexp(scale, &exponent);  // in [0.5, 1)
    return static_cast<std::size_t>(std::max(0, mantissa == 0.5 ? 1 - exponent : -exponent));
}

/// The largest scale of an octave.
inline double largestOfOctave(std::size_t octave) { return std::ldexp(1.0, -static_cast<int>(octave)); }

/// Rows by the octaves of their scales, in the order given. scale: of all rows that there are, or empty: all are 1.
template <typename Scales>
std::vector<std::vector<std::uint32_t>> byOctave(std::vector<std::uint32_t>&& rows, const Scales& scale) {
    std::vector<std::vector<std::uint32_t>> octaves(1);
    if (scale.empty()) {
        octaves[0] = std::move(rows);
        return octaves;
    }
    for (const std::uint32_t row : rows) {
        const std::size_t octave = octaveOf(static_cast<double>(scale[row]));
        if (octave >= octaves.size()) octaves.resize(octave + 1);
        octaves[octave].push_back(row);
    }
    return octaves;
}

/// 0 to n - 1.
inline std::vector<std::uint32_t> allRows(std::size_t n) {
    std::vector<std::uint32_t> rows(n);
    std::iota(rows.begin(), rows.end(), 0U);
    return rows;
}

}  // namespace betamesh
