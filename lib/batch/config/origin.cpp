#include "batch/config/origin.h"

#include "betamesh/error.h"
#include "io/particle_file.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr double kFloatRounding = 0x1p-24;   // largest relative error of rounding to single precision
constexpr double kTolerableRounding = 1e-3;  // of the spacing: far below what smoothing leaves of the particles' noise
constexpr double kFarAway = 16;              // largest coordinate in sides of the bounding box

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

Vec3 originFor(const Extent& extent) {
    const Vec3 size = extent.box.size();
    const double side = std::max({size.x, size.y, size.z});
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(extent.box.min[axis]), std::abs(extent.box.max[axis])});
    const double spacing = side / std::cbrt(static_cast<double>(extent.particles));
    if (!(largest * kFloatRounding > kTolerableRounding * spacing) || !(largest > kFarAway * side)) return {0, 0, 0};
    const double step = side > 0 ? std::pow(10, std::ceil(std::log10(side))) : 1;
    const Vec3 centre = extent.box.center();
    return {std::round(centre.x / step) * step, std::round(centre.y / step) * step, std::round(centre.z / step) * step};
}

}  // namespace

Vec3 resolveOrigin(const Config& config, const std::map<int, std::string>& frames_on_disk, const WorkerEvents& events) {
    if (const auto& given = config.input.given_origin) return {(*given)[0], (*given)[1], (*given)[2]};
    for (const auto& [frame, file] : frames_on_disk) {
        const WorkerEvents::FrameInProgress at_work(events, frame, WorkerEvents::Doing::measuring);
        try {
            if (!hasDoublePositions(file)) return {0, 0, 0};
            const Extent extent = extentOf(file);
            if (extent.particles > 0) return originFor(extent);
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
