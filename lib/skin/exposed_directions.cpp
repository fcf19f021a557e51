
#include "skin/exposed_directions.h"

#include "base/index.h"
#include "base/simd.h"
#include "skin/face_points.h"

#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr float kNegligible = 1e-6F;  // sine of the half-angle of a cap that hides nothing

// Squared sines become what (cosine - direction · axis) is to be multiplied with.
BETAMESH_EVERY_CPU
void setScales(std::size_t n, float* cosine, float* scale) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float sine = std::sqrt(scale[i] > 0 ? scale[i] : 0), wide = sine / static_cast<float>(kWideCap);
        cosine[i] = sine < kNegligible ? static_cast<float>(2 * kFullClearance) : cosine[i];
        scale[i] = sine < kNegligible ? 1 : 1 / (sine * (wide < 1 ? wide : 1) + std::numeric_limits<float>::min());
    }
}

// The least rim_distance of some directions from all caps, and whose cap it is from; -1 without any.
struct FindNearest {
    const DirectionColumns& directions;
    std::size_t count;
    const ExposedRegion::Planes& caps;
    const std::vector<float>&cosine, &scale;
    std::vector<float>&rim_distance, &cap;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        for (std::size_t i = 0; i < count; i += kWidth) {
            Some dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Some least = Some{} + static_cast<float>(kFullClearance), whose = Some{} - 1, number{};
            for (std::size_t k = 0; k < scale.size(); ++k, number += 1.0F) {
                const Some from = (cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k]) * scale[k];
                whose = from < least ? number : whose;
                least = from < least ? from : least;
            }
            std::memcpy(&rim_distance[i], &least, sizeof least);
            std::memcpy(&cap[i], &whose, sizeof whose);
        }
    }
};

// The same from some of the caps, not scaled.
struct FindHidden {
    const DirectionColumns& directions;
    const ExposedRegion::Planes& caps;
    const std::vector<float>& cosine;
    const std::vector<std::uint32_t>& some;
    std::vector<float>& rim_distance;

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
                const Some from = cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k];
                least = from < least ? from : least;
            }
            std::memcpy(&rim_distance[i], &least, sizeof least);
        }
    }
};

}  // namespace

ExposedDirections::ExposedDirections(const std::vector<Vec3>& directions, std::int64_t radius)
    : all_(directions),
      left_(all_),
      clearance_(all_.size()),
      cap_(all_.size()),
      number_(directions.size()),
      directions_(directions.size()),
      per_diameter_(0.5 / static_cast<double>(radius)) {}

void ExposedDirections::find(const ExposedRegion& region, const std::vector<Neighbour>& neighbours,
                             std::vector<ExposedDirection>& exposed) {
    const ExposedRegion::Planes& caps = region.planes();
    const std::size_t n = neighbours.size();
    cosine_.assign(caps.distance.begin(), caps.distance.begin() + static_cast<std::ptrdiff_t>(n));
    scale_.resize(n);
    for (std::size_t i = 0; i < n; ++i)  // twice as many digits, as those that are left matter where balls barely meet
        scale_[i] = static_cast<float>(1 - neighbours[i].squared * per_diameter_ * per_diameter_);
    setScales(n, cosine_.data(), scale_.data());

    onThisCpu(FindHidden{all_, caps, cosine_, region.bounding(), clearance_});
    std::size_t left = 0;
    for (std::uint32_t d = 0; d < directions_; ++d) {
        number_[left] = d;
        left_.x[left] = all_.x[d], left_.y[left] = all_.y[d], left_.z[left] = all_.z[d];
        left += clearance_[d] > 0;
    }
    onThisCpu(FindNearest{left_, left, caps, cosine_, scale_, clearance_, cap_});
    for (std::size_t i = 0; i < left; ++i) {
        if (!(clearance_[i] > 0)) continue;
        const std::uint32_t nearest = cap_[i] < 0 ? kInvalidIndex : neighbours[static_cast<std::size_t>(cap_[i])].particle;
        exposed.push_back({number_[i], nearest, clearance_[i]});
    }
}

}  // namespace betamesh
