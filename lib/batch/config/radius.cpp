
#include "batch/config/radius.h"

#include "betamesh/error.h"
#include "io/particle_file.h"
#include "skin/spacing.h"

#include <utility>

namespace betamesh {
namespace {

ResolvedRadius resolved(const Length& radius, double spacing, std::string origin) {
    return {radius.in_spacings ? radius.value * spacing : radius.value, spacing, std::move(origin), {}};
}

}  // namespace

std::optional<ResolvedRadius> resolveRadius(const Config& config, const std::map<int, std::string>& frames_on_disk,
                                            const WorkerEvents& events) {
    const Length& radius = config.surface.radius;
    if (config.surface.spacing > 0) return resolved(radius, config.surface.spacing, "as given");
    if (!radius.in_spacings) return resolved(radius, radius.value / kDefaultRadiusSpacings, "radius / 1.5");

    std::vector<std::string> warnings;
    bool any_readable = false;
    for (const auto& [frame, file] : frames_on_disk) {
        const WorkerEvents::FrameInProgress at_work(events, frame, WorkerEvents::Doing::measuring);
        try {
            std::vector<Vec3f> positions;
            visitPositions(file, config.input, [&](std::span<const Vec3f> block) {
                positions.insert(positions.end(), block.begin(), block.end());
            });
            any_readable = true;
            if (const auto measured = spacing(std::move(positions))) {
                ResolvedRadius result = resolved(radius, *measured, "measured in " + file);
                result.warnings = std::move(warnings);
                return result;
            }
        } catch (const Error& error) {
            warnings.push_back("this frame could not be used to measure the particle spacing: " +
                               std::string(error.what()));
        }
    }
    if (!any_readable) return std::nullopt;
    throw Error("the particle spacing of '" + config.input.path +
                "' cannot be measured because no frame has seven distinct particles. Give it with --spacing "
                "(surface.spacing), or give a radius in world units, as in --radius 0.02.");
}

}  // namespace betamesh
