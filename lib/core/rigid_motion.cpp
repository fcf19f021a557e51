#include "core/rigid_motion.h"

#include "core/simd.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <numeric>

namespace betamesh {

namespace {

// Σw, Σw x, Σw of xx, yy, zz, xy, yz, zx, then of what moves: Σw v, Σw x × v, Σw v·v.
constexpr std::size_t kSums = 17;
using Sums = std::array<double, kSums>;

struct SumNear {
    const MovingColumns& points;
    const Moving& centre;
    double reach;
    Sums& sums;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        constexpr std::size_t kAtOnce = kWidth / 2;
        double lanes[kSums][MovingColumns::kAtOnce];
        for (std::size_t first = 0; first < MovingColumns::kAtOnce; first += kAtOnce) {
            Doubles<kAtOnce> sum[kSums] = {};
            if constexpr (kAtOnce == MovingColumns::kAtOnce) {
                add<kAtOnce, true, true>(first, sum);
            } else {  // there are half as many registers
                add<kAtOnce, true, false>(first, sum);
                add<kAtOnce, false, true>(first, sum);
            }
            for (std::size_t k = 0; k < kSums; ++k) std::memcpy(&lanes[k][first], &sum[k], sizeof sum[k]);
        }
        for (std::size_t k = 0; k < kSums; ++k)
            sums[k] = std::accumulate(std::begin(lanes[k]), std::end(lanes[k]), 0.0);
    }

private:
    template <std::size_t kAtOnce, bool kPlaces, bool kMotion>
    __attribute__((always_inline)) void add(std::size_t first, Doubles<kAtOnce> (&sum)[kSums]) const {
        using Some = Doubles<kAtOnce>;
        const double cx = centre.position.x, cy = centre.position.y, cz = centre.position.z;
        const double cu = centre.velocity.x, cv = centre.velocity.y, cw = centre.velocity.z;
        const double inverse_square = 1 / (reach * reach);
        const auto& [px, py, pz, pu, pv, pw] = points;
        for (std::size_t i = first; i < px.size(); i += MovingColumns::kAtOnce) {
            Some x, y, z;
            std::memcpy(&x, &px[i], sizeof x), std::memcpy(&y, &py[i], sizeof y), std::memcpy(&z, &pz[i], sizeof z);
            x -= cx, y -= cy, z -= cz;
            Some near = 1 - (x * x + y * y + z * z) * inverse_square;
            near = near > 0 ? near : Some{};
            const Some weight = near * near, wx = weight * x, wy = weight * y, wz = weight * z;
            if constexpr (kPlaces) {
                sum[0] += weight;
                sum[1] += wx, sum[2] += wy, sum[3] += wz;
                sum[4] += wx * x, sum[5] += wy * y, sum[6] += wz * z;
                sum[7] += wx * y, sum[8] += wy * z, sum[9] += wz * x;
            }
            if constexpr (kMotion) {
                Some u, v, w;
                std::memcpy(&u, &pu[i], sizeof u), std::memcpy(&v, &pv[i], sizeof v), std::memcpy(&w, &pw[i], sizeof w);
                u -= cu, v -= cv, w -= cw;
                sum[10] += weight * u, sum[11] += weight * v, sum[12] += weight * w;
                sum[13] += wy * w - wz * v, sum[14] += wz * u - wx * w, sum[15] += wx * v - wy * u;
                sum[16] += weight * (u * u + v * v + w * w);
            }
        }
    }
};

}  // namespace

RigidMotionFit::RigidMotionFit(const MovingColumns& points, const Moving& centre, double reach) {
    Sums sums;
    onThisCpu(SumNear{points, centre, reach, sums});
    drift_ = centre.velocity;
    weight_ = sums[0];
    position_ = Vec3(sums[1], sums[2], sums[3]);
    std::copy(sums.begin() + 4, sums.begin() + 10, squares_);
    velocity_ = Vec3(sums[10], sums[11], sums[12]);
    moment_ = Vec3(sums[13], sums[14], sums[15]);
    energy_ = sums[16];
}

Vec3 RigidMotionFit::spin() const {
    if (!(weight_ > 0)) return Vec3(0);
    const Vec3 centre = position_ / weight_, moment = moment_ - cross(centre, velocity_);
    const double xx = squares_[0] - weight_ * centre.x * centre.x, yy = squares_[1] - weight_ * centre.y * centre.y,
                 zz = squares_[2] - weight_ * centre.z * centre.z, xy = squares_[3] - weight_ * centre.x * centre.y,
                 yz = squares_[4] - weight_ * centre.y * centre.z, zx = squares_[5] - weight_ * centre.z * centre.x;
    const double trace = xx + yy + zz;
    if (!(trace > 0)) return Vec3(0);
    const double floor = 1e-9 * trace;  // far below what any three points off a line have
    const Mat33 inertia(yy + zz + floor, -xy, -zx, -xy, zz + xx + floor, -yz, -zx, -yz, xx + yy + floor);
    return moment * inertia.inverse();
}

Vec3 RigidMotionFit::velocityAt(const Vec3& position) const {
    if (!(weight_ > 0)) return Vec3(0);
    return drift_ + velocity_ / weight_ + cross(spin(), position - origin_ - position_ / weight_);
}

double RigidMotionFit::rigidity(const Vec3& spin) const {
    const double all = weight_ > 0 ? energy_ - dot(velocity_, velocity_) / weight_ : 0;
    if (!(all > 0)) return 1;
    return std::clamp(dot(spin, moment_ - cross(position_ / weight_, velocity_)) / all, 0.0, 1.0);
}

}  // namespace betamesh
