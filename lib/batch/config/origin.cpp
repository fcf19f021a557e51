#include "batch/config/origin.h"

#include "base/local_origin.h"
#include "betamesh/error.h"
#include "io/particle_file.h"

namespace betamesh {
namespace {

struct Extent {
    Box box;
    std::size_t particles = 0;
};

Extent extentOf(const std::string& file) {
    ParticleInput input;
    input.on_bad_particle = OnBadParticle::drop;
    Extent extent;
    visitPositions(file, input, [&](std::span<const Vec3f> positions) {
        for (const Vec3f& p : positions) extent.box.extendBy(Vec3(p));
        extent.particles += positions.size();
    });
    return extent;
}

}  // namespace

Vec3 resolveOrigin(const Config& config, const std::map<int, std::string>& frames_on_disk, const WorkerEvents& events) {
    if (const auto& given = config.input.given_origin) return {(*given)[0], (*given)[1], (*given)[2]};
    for (const auto& [frame, file] : frames_on_disk) {
        const WorkerEvents::FrameInProgress at_work(events, frame, WorkerEvents::Doing::measuring);
        try {
            if (!hasDoublePositions(file)) return {0, 0, 0};
            const Extent extent = extentOf(file);
            if (extent.particles > 0) return localOrigin(extent.box, extent.particles);
        } catch (const Error&) {  // reported when this frame is meshed
        }
    }
    return {0, 0, 0};
}

Vec3 worldOrigin(const ParticleInput& input, UpAxis up_axis) {
    const Vec3 origin = input.origin * input.scale;
    if (input.up_axis == up_axis) return origin;
    return up_axis == UpAxis::y ? Vec3(origin.x, origin.z, -origin.y) : Vec3(origin.x, -origin.z, origin.y);
}

}  // namespace betamesh
