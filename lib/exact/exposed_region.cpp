#include "exact/exposed_region.h"

#include "core/icosphere.h"
#include "core/simd.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr float kSlack = 1e-5f;  // far above the rounding of the dot products it guards
constexpr std::uint32_t kCuts = 4;
constexpr int kFinestLevel = 6;
constexpr std::size_t kFewNeighbours = 16;
constexpr std::size_t kPackEvery = 16;  // caps

// Marks the midpoints m with offset·m >= least; true when none is left without a mark.
BETAMESH_EVERY_CPU
bool markAlong(const float* x, const float* y, const float* z, std::size_t n, float dx, float dy, float dz, float least,
               std::int32_t* marked) {
    std::int32_t all = -1;
    for (std::size_t p = 0; p < n; ++p) {
        const float along = dx * x[p] + dy * y[p] + dz * z[p];
        marked[p] |= along >= least ? -1 : 0;
        all &= marked[p];
    }
    return all == -1;
}

// Is there a midpoint m with offset·m >= least?
BETAMESH_EVERY_CPU
bool anyAlong(const float* x, const float* y, const float* z, std::size_t n, float dx, float dy, float dz,
              float least) {
    std::int32_t any = 0;
    for (std::size_t p = 0; p < n; ++p) any |= dx * x[p] + dy * y[p] + dz * z[p] >= least ? -1 : 0;
    return any != 0;
}

}  // namespace

void ExposedRegion::Patches::add(const std::array<Vec3, 3>& triangle) {
    const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]).normalized();
    for (const Vec3& corner : triangle) cos_angle = std::min(cos_angle, static_cast<float>(dot(middle, corner)));
    sin_angle = std::sqrt(1 - cos_angle * cos_angle);
    x.push_back(static_cast<float>(middle.x));
    y.push_back(static_cast<float>(middle.y));
    z.push_back(static_cast<float>(middle.z));
    covered.push_back(0);
    corners.push_back(triangle);
}

void ExposedRegion::Patches::leaveCoveredOut() {
    std::size_t left = 0;
    for (std::size_t p = 0; p < size(); ++p) {
        if (covered[p]) continue;
        x[left] = x[p], y[left] = y[p], z[left] = z[p], corners[left] = corners[p], covered[left++] = 0;
    }
    x.resize(left), y.resize(left), z.resize(left), covered.resize(left), corners.resize(left);
}

const ExposedRegion::Patches& ExposedRegion::wholeSphere() {
    static const Patches whole = [] {
        const Icosphere sphere = icosphere(kCuts);
        Patches patches;
        for (const Triangle& t : sphere.triangles)
            patches.add({sphere.position[t[0]], sphere.position[t[1]], sphere.position[t[2]]});
        return patches;
    }();
    return whole;
}

// With room for rounding, as everywhere here: what is neither covered nor met lies surely outside the cap.
bool ExposedRegion::cover(const Cap& cap) {
    if (cap.cos_angle >= patches_.cos_angle - kSlack) return false;
    const float least =
        cap.distance * (cap.cos_angle * patches_.cos_angle + cap.sin_angle * patches_.sin_angle + kSlack);
    return markAlong(patches_.x.data(), patches_.y.data(), patches_.z.data(), patches_.size(), cap.x, cap.y, cap.z,
                     least, patches_.covered.data());
}

bool ExposedRegion::meets(const Cap& cap) const {
    const float least =
        cap.distance * (cap.cos_angle * patches_.cos_angle - cap.sin_angle * patches_.sin_angle - kSlack);
    return anyAlong(patches_.x.data(), patches_.y.data(), patches_.z.data(), patches_.size(), cap.x, cap.y, cap.z,
                    least);
}

bool ExposedRegion::mayHold(const Vec3& direction) const {
    const Vec3f d(direction.normalized());
    return anyAlong(patches_.x.data(), patches_.y.data(), patches_.z.data(), patches_.size(), d.x, d.y, d.z,
                    patches_.cos_angle - kSlack);
}

void ExposedRegion::enclose(const std::vector<Neighbour>& neighbours) {
    caps_.clear();
    neighbours_.clear();
    for (std::uint32_t n = 0; n < neighbours.size(); ++n) {
        const Vec3f offset(neighbours[n].offset);
        const float distance = std::sqrt(static_cast<float>(neighbours[n].squared));
        const float cosine = std::min(1.0F, distance / diameter_);
        caps_.push_back({offset.x, offset.y, offset.z, distance, cosine, std::sqrt(1 - cosine * cosine), n});
    }
    patches_ = wholeSphere();
    const auto coverBy = [&](bool near) {
        std::size_t used = 0;
        for (const Cap& cap : caps_) {
            if ((cap.cos_angle < 0.5F) != near) continue;
            if (cover(cap)) break;
            if (++used % kPackEvery == 0) patches_.leaveCoveredOut();
        }
        patches_.leaveCoveredOut();
    };
    coverBy(true);
    if (!empty()) coverBy(false);
    std::erase_if(caps_, [&](const Cap& cap) { return !meets(cap); });
    // Finer patches, until few neighbours are left or no fewer become.
    for (int level = 0; level < kFinestLevel && caps_.size() > kFewNeighbours && !empty(); ++level)
        if (!refine()) break;
    for (const Cap& cap : caps_) neighbours_.push_back(neighbours[cap.neighbour]);
}

bool ExposedRegion::refine() {
    finer_ = {};
    for (const auto& [a, b, c] : patches_.corners) {
        const Vec3 ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
        for (const auto& corners : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) finer_.add(corners);
    }
    std::swap(patches_, finer_);
    for (const Cap& cap : caps_)
        if (cover(cap)) break;
    patches_.leaveCoveredOut();
    return std::erase_if(caps_, [&](const Cap& cap) { return !meets(cap); }) > 0;
}

}  // namespace betamesh
