
#include "planar/lone_particles.h"

#include "base/parallel.h"

namespace betamesh {

namespace {

constexpr double kReach = 1.5;  // of at(), in radii: a point of the curve is within one of its particle

Dual kernel(const DualVec3& offset, double reach) {
    const Dual t = 1 - dot(offset, offset) / (reach * reach);
    return t.value > 0 ? t * t : Dual(0);
}

}  // namespace

LoneParticles::LoneParticles(const std::vector<DualVec3>& particles, double radius, double wide_radius)
    : particles_(particles),
      reach_(kReach * radius),
      cells_(particles.size(), radius, [&](std::size_t i) { return particles[i].position; }),
      alone_(particles.size()) {
    const double touching = 2 * radius, far = 2 * wide_radius;
    parallelFor(particles_.size(), 256, [&](std::size_t i) {
        const Vec3& p = particles_[i].position;
        Dual alone = 1;
        cells_.forRowsIn(p - Vec3(far, far, 0), p + Vec3(far, far, 0), [&](std::uint32_t j) {
            if (j == i || alone.value == 0) return;
            alone = alone * smoothStep((length(particles_[j] - particles_[i]) - touching) / (far - touching));
        });
        alone_[i] = alone;
    });
}

Dual LoneParticles::at(const DualVec3& x) const {
    Dual sum = 0, total = 0;
    cells_.forRowsIn(x.position - Vec3(reach_, reach_, 0), x.position + Vec3(reach_, reach_, 0), [&](std::uint32_t i) {
        const Dual weight = kernel(particles_[i] - x, reach_);
        sum = sum + alone_[i] * weight;
        total = total + weight;
    });
    return total.value > 0 ? sum / total : Dual(0);
}

}  // namespace betamesh
