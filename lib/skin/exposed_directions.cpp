#include "skin/exposed_directions.h"

#include "base/index.h"
#include "base/simd.h"
#include "skin/constants.h"

#include <cmath>
#include <limits>

namespace betamesh {

namespace {

constexpr float kNegligible = 1e-6F;  // sine of a cap's half-angle below which it counts as covering nothing

// For each cap of half-angle α, in: cosine = cos α, scale = sin² α; out: scale is the factor that turns
// cos α - direction · axis into the rim distance of FacePoints. Negligible caps become farther than kMaxRimDistance;
// one that covers all but a negligible part covers every direction.
BETAMESH_EVERY_CPU
void setScales(std::size_t n, float* cosine, float* scale) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float sine = std::sqrt(scale[i] > 0 ? scale[i] : 0), width = sine / static_cast<float>(kWideCapSine);
        const float none_or_all = cosine[i] > 0 ? static_cast<float>(2 * kMaxRimDistance) : -2;
        cosine[i] = sine < kNegligible ? none_or_all : cosine[i];
        scale[i] = sine < kNegligible ? 1 : 1 / (sine * (width < 1 ? width : 1) + std::numeric_limits<float>::min());
    }
}

// For each direction the least rim distance from all caps, and the index of that cap; -1 without any.
struct FindNearest {
    const DirectionColumns& directions;
    std::size_t count;
    const ExposedRegion::Planes& caps;
    const std::vector<float>&cosine, &scale;
    std::vector<float>&rim_distance, &cap;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Pack = Floats<kWidth>;
        for (std::size_t i = 0; i < count; i += kWidth) {
            Pack dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Pack least = Pack{} + static_cast<float>(kMaxRimDistance), nearest = Pack{} - 1, number{};
            for (std::size_t k = 0; k < scale.size(); ++k, number += 1.0F) {
                const Pack from = (cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k]) * scale[k];
                nearest = from < least ? number : nearest;
                least = from < least ? from : least;
            }
            std::memcpy(&rim_distance[i], &least, sizeof least);
            std::memcpy(&cap[i], &nearest, sizeof nearest);
        }
    }
};

// For each direction the least unscaled rim distance from some of the caps: it is covered if that is not positive.
struct FindCovered {
    const DirectionColumns& directions;
    const ExposedRegion::Planes& caps;
    const std::vector<float>& cosine;
    const std::vector<std::uint32_t>& some;
    std::vector<float>& rim_distance;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Pack = Floats<kWidth>;
        for (std::size_t i = 0; i < directions.size(); i += kWidth) {
            Pack dx, dy, dz;
            std::memcpy(&dx, &directions.x[i], sizeof dx);
            std::memcpy(&dy, &directions.y[i], sizeof dy);
            std::memcpy(&dz, &directions.z[i], sizeof dz);
            Pack least = Pack{} + 1.0F;
            for (const std::uint32_t k : some) {
                const Pack from = cosine[k] - dx * caps.x[k] - dy * caps.y[k] - dz * caps.z[k];
                least = from < least ? from : least;
            }
            std::memcpy(&rim_distance[i], &least, sizeof least);
        }
    }
};

}  // namespace

ExposedDirections::ExposedDirections(const std::vector<Vec3>& directions)
    : all_(directions),
      candidates_(all_),
      rim_distance_(all_.size()),
      nearest_cap_(all_.size()),
      candidate_number_(directions.size()),
      directions_(directions.size()) {}

void ExposedDirections::find(const ExposedRegion& region, const std::vector<Neighbour>& neighbours, std::int64_t radius,
                             std::vector<ExposedDirection>& exposed) {
    const ExposedRegion::Planes& caps = region.planes();
    const std::size_t n = neighbours.size();
    cosine_.assign(caps.distance.begin(), caps.distance.begin() + static_cast<std::ptrdiff_t>(n));
    scale_.resize(n);
    const double per_diameter = 0.5 / static_cast<double>(radius);
    for (std::size_t i = 0; i < n; ++i) {  // in doubles: the digits left by cancellation matter where balls barely meet
        const Neighbour& neighbour = neighbours[i];
        const double squared_cosine = neighbour.power * per_diameter * per_diameter;  // of a ball of the same radius
        scale_[i] = static_cast<float>(1 - (neighbour.radius == radius
                                                ? squared_cosine
                                                : squared_cosine * (neighbour.power / neighbour.squaredDistance())));
    }
    setScales(n, cosine_.data(), scale_.data());

    onThisCpu(FindCovered{all_, caps, cosine_, region.bounding(), rim_distance_});
    std::size_t candidates = 0;
    for (std::uint32_t d = 0; d < directions_; ++d) {
        candidate_number_[candidates] = d;
        candidates_.x[candidates] = all_.x[d], candidates_.y[candidates] = all_.y[d],
        candidates_.z[candidates] = all_.z[d];
        candidates += rim_distance_[d] > 0;
    }
    onThisCpu(FindNearest{candidates_, candidates, caps, cosine_, scale_, rim_distance_, nearest_cap_});
    for (std::size_t i = 0; i < candidates; ++i) {
        if (!(rim_distance_[i] > 0)) continue;
        const std::uint32_t nearest =
            nearest_cap_[i] < 0 ? kInvalidIndex : neighbours[static_cast<std::size_t>(nearest_cap_[i])].particle;
        exposed.push_back({candidate_number_[i], nearest, rim_distance_[i]});
    }
}

}  // namespace betamesh
