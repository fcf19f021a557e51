#include "exact/exposed_directions.h"

#include "core/face_points.h"
#include "core/simd.h"

#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr float kNegligible = 1e-6F;  // sine of the half-angle of a cap that hides nothing

// Offsets become axes, squared cosines cosines, squared sines scales.
BETAMESH_EVERY_CPU
void makeCaps(std::size_t n, float per_diameter, float* x, float* y, float* z, float* cosine, float* scale) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float middle = std::sqrt(cosine[i]), sine = std::sqrt(scale[i] > 0 ? scale[i] : 0);
        const float wide = sine / static_cast<float>(kWideCap), to_axis = per_diameter / middle;
        x[i] *= to_axis;
        y[i] *= to_axis;
        z[i] *= to_axis;
        cosine[i] = sine < kNegligible ? static_cast<float>(2 * kFullClearance) : middle;
        scale[i] = sine < kNegligible ? 1 : 1 / (sine * (wide < 1 ? wide : 1) + std::numeric_limits<float>::min());
    }
}

// The least clearance of some directions from all caps, and whose cap it is from; -1 without any.
struct FindNearest {
    const DirectionColumns& directions;
    std::size_t count;
    const Caps& caps;
    std::vector<float>&clearance, &cap;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        for (std::size_t i = 0; i < count; i += kWidth) {
            Some dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Some least = Some{} + static_cast<float>(kFullClearance), whose = Some{} - 1, number{};
            for (std::size_t k = 0; k < caps.x.size(); ++k, number += 1.0F) {
                const Some from = (caps.cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k]) * caps.scale[k];
                whose = from < least ? number : whose;
                least = from < least ? from : least;
            }
            std::memcpy(&clearance[i], &least, sizeof least);
            std::memcpy(&cap[i], &whose, sizeof whose);
        }
    }
};

// How far directions are from some caps, not scaled: hidden by one of them where that is not positive.
struct FindHidden {
    const DirectionColumns& directions;
    const Caps& caps;
    std::span<const std::uint32_t> some;
    std::vector<float>& clearance;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        for (std::size_t i = 0; i < directions.size(); i += kWidth) {
            Some dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Some least = Some{} + 1.0F;
            for (const std::uint32_t k : some) {
                const Some from = caps.cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k];
                least = from < least ? from : least;
            }
            std::memcpy(&clearance[i], &least, sizeof least);
        }
    }
};

}  // namespace

void Caps::set(const std::vector<Neighbour>& neighbours, std::int64_t radius) {
    const std::size_t n = neighbours.size();
    for (auto* numbers : {&x, &y, &z, &cosine, &scale}) numbers->resize(n);
    const double per_diameter = 0.5 / static_cast<double>(radius), per_square = per_diameter * per_diameter;
    for (std::size_t i = 0; i < n; ++i) {
        const Neighbour& other = neighbours[i];
        x[i] = static_cast<float>(other.offset.x);
        y[i] = static_cast<float>(other.offset.y);
        z[i] = static_cast<float>(other.offset.z);
        const double square = other.squared * per_square;
        cosine[i] = static_cast<float>(square);
        scale[i] = static_cast<float>(1 - square);
    }
    makeCaps(n, static_cast<float>(per_diameter), x.data(), y.data(), z.data(), cosine.data(), scale.data());
}

std::pair<double, std::uint32_t> Caps::nearest(const Vec3& direction, double too_little) const {
    std::pair<double, std::uint32_t> nearest{kFullClearance, ~std::uint32_t{0}};
    for (std::uint32_t k = 0; k < x.size() && nearest.first > too_little; ++k) {
        const double clearance = (cosine[k] - dot(direction, Vec3(x[k], y[k], z[k]))) * scale[k];
        if (clearance < nearest.first) nearest = {clearance, k};
    }
    return nearest;
}

ExposedDirections::ExposedDirections(const std::vector<Vec3>& directions)
    : all_(directions),
      left_(all_),
      clearance_(all_.size()),
      cap_(all_.size()),
      number_(directions.size()),
      directions_(directions.size()) {}

void ExposedDirections::find(const std::vector<Neighbour>& neighbours, std::int64_t radius,
                             std::span<const std::uint32_t> bounding, std::vector<ExposedDirection>& exposed) {
    caps_.set(neighbours, radius);
    onThisCpu(FindHidden{all_, caps_, bounding, clearance_});
    std::size_t left = 0;
    for (std::uint32_t d = 0; d < directions_; ++d) {
        number_[left] = d;
        left_.x[left] = all_.x[d], left_.y[left] = all_.y[d], left_.z[left] = all_.z[d];
        left += clearance_[d] > 0;
    }
    onThisCpu(FindNearest{left_, left, caps_, clearance_, cap_});
    for (std::size_t i = 0; i < left; ++i) {
        if (!(clearance_[i] > 0)) continue;
        const std::uint32_t nearest = cap_[i] < 0 ? kHidden : neighbours[static_cast<std::size_t>(cap_[i])].particle;
        exposed.push_back({number_[i], nearest, clearance_[i]});
    }
}

}  // namespace betamesh
