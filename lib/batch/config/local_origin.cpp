#include "batch/config/local_origin.h"

#include "betamesh/error.h"
#include "io/particle_file.h"

namespace betamesh {

Vec3 resolvedLocalOrigin(const Config& config, const std::map<int, std::string>& frames_on_disk,
                         const WorkerEvents& events) {
    if (const auto& given = config.input.given_origin) return {(*given)[0], (*given)[1], (*given)[2]};
    for (const auto& [frame, file] : frames_on_disk) {
        const WorkerEvents::FrameInProgress at_work(events, frame, WorkerEvents::Doing::measuring);
        try {
            if (const auto origin = localOriginOf(file, inputOf(config, frame).frame)) return *origin;
        } catch (const Error&) {  // reported when this frame is meshed
        }
    }
    return {0, 0, 0};
}

}  // namespace betamesh
