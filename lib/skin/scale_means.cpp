#include "skin/scale_means.h"

#include "base/octaves.h"
#include "skin/constants.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace betamesh {

ScaleMeans::ScaleMeans(const std::vector<Vec3>& position, const std::vector<float>& weight,
                       const std::vector<float>& scale, double width) {
    if (scale.empty()) return;
    const float least = *std::ranges::min_element(scale);
    for (std::size_t octave = 0; octave <= octaveOf(static_cast<double>(least)); ++octave)
        clouds_.emplace_back(
            position.size(), [&](std::size_t i) { return position[i]; },
            [&](std::size_t i) {
                const float square = scale[i] * scale[i], fourth = square * square;
                return std::array{weight[i], scale[i], 1 / (fourth * fourth)};
            },
            width * largestOfOctave(octave), width);
}

void ScaleMeans::average(const std::vector<std::uint32_t>& rows, const std::function<Vec3(std::uint32_t)>& positionOf,
                         Scales& scales) const {
    if (clouds_.empty()) return;
    for (int round = 0; round < kScaleMeans; ++round) {
        Scales means = scales;
        const auto rows_of = byOctave(std::vector<std::uint32_t>(rows), scales.mean);
        for (std::size_t octave = 0; octave < rows_of.size(); ++octave) {
            const std::vector<std::uint32_t>& points = rows_of[octave];
            clouds_[std::min(octave, clouds_.size() - 1)].forPoints(
                points.size(), [&](std::size_t i) { return positionOf(points[i]); }, Grouping::compact,
                [&](const PointGroup& group, SampleSubset<kFields> samples) {
                    Lanes own;
                    for (std::size_t lane = 0; lane < kLanes; ++lane) own[lane] = scales.mean[points[group.row[lane]]];
                    const Lanes inverse_square = 1 / (own * own), zero{};
                    Lanes weight{}, sum{}, powers{};
                    for (const SampleFields<kFields>& f : samples) {
                        const Lanes x = f[kX] - group.position[0], y = f[kY] - group.position[1],
                                    z = f[kZ] - group.position[2];
                        Lanes t = 1 - (x * x + y * y + z * z) * inverse_square;
                        t = t > 0 ? t : zero;
                        const Lanes k = f[kWeight] * t * t;
                        weight += k;
                        sum += k * f[kScale];
                        powers += k * f[kInversePower];
                    }
                    for (std::size_t lane = 0; lane < group.size; ++lane) {
                        if (!(weight[lane] > 0)) continue;
                        const std::uint32_t point = points[group.row[lane]];
                        means.mean[point] = sum[lane] / weight[lane];
                        means.least[point] = std::sqrt(std::sqrt(std::sqrt(weight[lane] / powers[lane])));
                    }
                });
        }
        scales = std::move(means);
    }
}

}  // namespace betamesh
