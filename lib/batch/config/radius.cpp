#include "batch/config/radius.h"

#include "betamesh/error.h"
#include "io/particle_file.h"

#include <algorithm>
#include <utility>

namespace betamesh {
namespace {

/// Measures the spacing in the first, the last and a middle one of the frames on disk that allow it.
class SequenceMeasurement {
public:
    SequenceMeasurement(const Config& config, const std::map<int, std::string>& frames_on_disk,
                        const WorkerEvents& events)
        : config_(config),
          estimator_(config.surface.dimension),
          events_(events),
          frames_(frames_on_disk.begin(), frames_on_disk.end()) {
        std::size_t first = 0, end = frames_.size();
        while (first < end && !measure(first)) ++first;
        while (end > first + 1 && !measure(end - 1)) --end;
        std::size_t middle = first + (end - first) / 2;
        while (end > first + 2 && middle + 1 < end && !measure(middle)) ++middle;
    }

    SequenceSpacing result(int dimension) && {
        const auto estimate = estimator_.estimate();
        return {{estimate, most_particles_, estimate ? where() : ""}, config_.input, dimension, std::move(warnings_)};
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
            visitPositions(file, inputOf(config_, frame), [&](std::span<const Vec3f> block) {
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

    const Config& config_;
    SpacingEstimator estimator_;
    const WorkerEvents& events_;
    std::vector<std::pair<int, std::string>> frames_;
    std::vector<std::size_t> measured_;  ///< indices of frames_
    std::size_t most_particles_ = 0;
    std::vector<std::string> warnings_;
};

/// The measurement for the particles that a configuration selects, which is made unless `measured` has it.
const SequenceSpacing& sequenceSpacing(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                       const WorkerEvents& events, std::vector<SequenceSpacing>& measured) {
    const int dimension = config.surface.dimension;
    for (const SequenceSpacing& known : measured)
        if (known.input == config.input && known.dimension == dimension) return known;
    return measured.emplace_back(SequenceMeasurement(config, frames_on_disk, events).result(dimension));
}

}  // namespace

std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& events, std::vector<SequenceSpacing>& measured) {
    if (config.surface.spacing > 0) return givenRadius(config);
    const SequenceSpacing& measurement = sequenceSpacing(config, frames_on_disk, events, measured);
    if (auto result = measuredRadius(config, measurement)) {
        if (!givenRadius(config)) result->warnings = measurement.warnings;
        return result;
    }
    if (measurement.most_particles == 0) return std::nullopt;
    throw Error("the particle spacing of '" + config.input.path +
                "' cannot be measured because no frame has seven distinct particles. Give it with --spacing "
                "(surface.spacing), or give a radius in world units, as in --radius 0.02.");
}

}  // namespace betamesh
