#include "batch/config/radius.h"

#include "batch/config/key_types.h"
#include "betamesh/error.h"
#include "io/particle_file.h"
#include "skin/spacing.h"

#include <algorithm>
#include <utility>

namespace betamesh {
namespace {

constexpr double kMostDrift = 0.25;  // of a frame's spacing before there is a warning, relative
constexpr double kLeastUsualRadius = 0.8, kMostUsualRadius = 3;  // usual ball radii, in spacings

// Spacings; a larger radius is taken for a mistake. It costs hours where a ball has thousands of neighbours.
constexpr double kWrongRadius = 50, kWrongRadiusOfMany = 10;
constexpr std::size_t kMany = 5000;  // particles

ResolvedRadius resolved(const Length& radius, double spacing, std::string origin) {
    return {radius.in_spacings ? radius.value * spacing : radius.value, spacing, std::move(origin), {}};
}

/// Measures the spacing in the first, the last and a middle one of the frames on disk that allow it.
class SequenceMeasurement {
public:
    SequenceMeasurement(const Config& config, const std::map<int, std::string>& frames_on_disk,
                        const WorkerEvents& events)
        : input_(config.input),
          estimator_(config.surface.dimension),
          events_(events),
          frames_(frames_on_disk.begin(), frames_on_disk.end()) {
        std::size_t first = 0, end = frames_.size();
        while (first < end && !measure(first)) ++first;
        while (end > first + 1 && !measure(end - 1)) --end;
        std::size_t middle = first + (end - first) / 2;
        while (end > first + 2 && middle + 1 < end && !measure(middle)) ++middle;
    }

    MeasuredSpacing result(int dimension) && {
        return {input_, dimension, estimator_.estimate(), most_particles_, where(), std::move(warnings_)};
    }

private:
    /// "a.0001.vdb", "frames 1, 50 and 99".
    std::string where() const {
        if (measured_.size() == 1) return frames_[measured_.front()].second;
        std::string text = "frames ";
        for (const std::size_t i : {std::size_t{0}, std::size_t{2}, std::size_t{1}}) {
            if (i >= measured_.size()) continue;
            text += (i == 0 ? "" : i == 1 ? " and " : ", ") + std::to_string(frames_[measured_[i]].first);
        }
        return text;
    }

    bool measure(std::size_t i) {
        const auto& [frame, file] = frames_[i];
        const WorkerEvents::FrameInProgress at_work(events_, frame, WorkerEvents::Doing::measuring);
        try {
            std::vector<Vec3f> positions;
            visitPositions(file, input_, [&](std::span<const Vec3f> block) {
                positions.insert(positions.end(), block.begin(), block.end());
            });
            most_particles_ = std::max(most_particles_, positions.size());
            if (!estimator_.add(std::move(positions))) return false;
            measured_.push_back(i);
            return true;
        } catch (const Error& error) {
            warnings_.push_back("this frame could not be used to measure the particle spacing: " +
                                std::string(error.what()));
            return false;
        }
    }

    const ParticleInput& input_;
    SpacingEstimator estimator_;
    const WorkerEvents& events_;
    std::vector<std::pair<int, std::string>> frames_;
    std::vector<std::size_t> measured_;  ///< indices of frames_
    std::size_t most_particles_ = 0;
    std::vector<std::string> warnings_;
};

/// The measurement for the particles that a configuration selects, which is made unless `measured` has it.
const MeasuredSpacing& measuredSpacing(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                       const WorkerEvents& events, MeasuredSpacings& measured) {
    const int dimension = config.surface.dimension;
    for (const MeasuredSpacing& known : measured)
        if (known.input == config.input && known.dimension == dimension) return known;
    return measured.emplace_back(SequenceMeasurement(config, frames_on_disk, events).result(dimension));
}

}  // namespace

std::optional<ResolvedRadius> givenRadius(const Config& config) {
    const Length& radius = config.surface.radius;
    if (config.surface.spacing > 0) return resolved(radius, config.surface.spacing, "as given");
    if (!radius.in_spacings) return resolved(radius, radius.value / kDefaultRadiusSpacings, "radius / 1.5");
    return std::nullopt;
}

std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& events, MeasuredSpacings& measured) {
    const std::optional<ResolvedRadius> given = givenRadius(config);
    if (config.surface.spacing > 0) return given;

    const MeasuredSpacing& measurement = measuredSpacing(config, frames_on_disk, events, measured);
    const std::optional<SpacingEstimate>& found = measurement.estimate;
    const Length& radius = config.surface.radius;
    const double most = measurement.most_particles > kMany ? kWrongRadiusOfMany : kWrongRadius;
    if (found && radius.value > most * (radius.in_spacings ? 1 : found->spacing))
        throw Error("the radius " + textOf(radius) + " is " +
                    shortNumber(radius.in_spacings ? radius.value : radius.value / found->spacing) +
                    " times the particle spacing " + shortNumber(found->spacing) + ", measured in " +
                    measurement.where + ". " +
                    (radius.in_spacings ? "Did you mean world units?"
                                        : "Did you mean " + textOf(radius) + "dx, that is in spacings?") +
                    " To use this radius nevertheless, give the spacing as well (--spacing, surface.spacing).");
    if (given) return given;
    if (found) {
        ResolvedRadius result = resolved(config.surface.radius, found->spacing,
                                         "measured in " + measurement.where + ", where 90 % of the particles have " +
                                             shortNumber(found->low) + " to " + shortNumber(found->high));
        result.warnings = measurement.warnings;
        return result;
    }
    if (measurement.most_particles == 0) return std::nullopt;
    throw Error("the particle spacing of '" + config.input.path +
                "' cannot be measured because no frame has seven distinct particles. Give it with --spacing "
                "(surface.spacing), or give a radius in world units, as in --radius 0.02.");
}

FrameSpacing compareSpacing(const std::vector<Vec3f>& positions, double radius, double spacing, int dimension) {
    std::vector<double> local = localSpacings(positions, dimension);
    if (local.empty()) return {};
    const double own = typicalSpacing(std::move(local));
    FrameSpacing result{own, {}, {}};
    const bool drifts = own > (1 + kMostDrift) * spacing || own < (1 - kMostDrift) * spacing;
    std::string scale;
    if (radius > kMostUsualRadius * own || radius < kLeastUsualRadius * own)
        scale = "the radius " + shortNumber(radius) + " is " + shortNumber(radius / own) +
                " times the particle spacing of this frame; 0.8 to 3 times gives a liquid surface";
    if (drifts)
        result.drift = "the particle spacing of this frame is " + shortNumber(own) + ", but " + shortNumber(spacing) +
                       " is used for all frames. Give the spacing of the liquid with --spacing (surface.spacing)" +
                       (scale.empty() ? "" : "; " + scale);
    else if (!scale.empty())
        result.scale = scale;
    return result;
}

}  // namespace betamesh
