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

ExposedRegion::Patches::Patches(const std::vector<Corners>& triangles) {
    for (const Corners& corners : triangles) {
        const Vec3 middle = (corners[0] + corners[1] + corners[2]).normalized();
        for (const Vec3& corner : corners) cos_angle = std::min(cos_angle, static_cast<float>(dot(middle, corner)));
        x.push_back(static_cast<float>(middle.x));
        y.push_back(static_cast<float>(middle.y));
        z.push_back(static_cast<float>(middle.z));
        triangle.push_back(static_cast<std::uint32_t>(triangle.size()));
    }
    covered.resize(size());
    sin_angle = std::sqrt(1 - cos_angle * cos_angle);
}

void ExposedRegion::Patches::leaveCoveredOut() {
    std::size_t left = 0;
    for (std::size_t p = 0; p < size(); ++p) {
        x[left] = x[p], y[left] = y[p], z[left] = z[p], triangle[left] = triangle[p];
        left += covered[p] == 0;
    }
    x.resize(left), y.resize(left), z.resize(left), triangle.resize(left);
    covered.assign(left, 0);
}

const ExposedRegion::WholeSphere& ExposedRegion::wholeSphere() {
    static const WholeSphere whole = [] {
        const Icosphere sphere = icosphere(kCuts);
        std::vector<Corners> triangles;
        for (const Triangle& t : sphere.triangles)
            triangles.push_back({sphere.position[t[0]], sphere.position[t[1]], sphere.position[t[2]]});
        return WholeSphere{triangles, Patches(triangles)};
    }();
    return whole;
}

ExposedRegion::ExposedRegion(std::int64_t radius)
    : diameter_(static_cast<float>(2 * radius)), patches_(wholeSphere().patches) {}

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
    patches_ = wholeSphere().patches;
    finer_.clear();
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
    const std::vector<Corners>& level = finer_.empty() ? wholeSphere().triangles : finer_;
    std::vector<Corners> next;
    for (const std::uint32_t number : patches_.triangle) {
        const auto& [a, b, c] = level[number];
        const Vec3 ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
        next.insert(next.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    finer_ = std::move(next);
    patches_ = Patches(finer_);
    for (const Cap& cap : caps_)
        if (cover(cap)) break;
    patches_.leaveCoveredOut();
    return std::erase_if(caps_, [&](const Cap& cap) { return !meets(cap); }) > 0;
}

}  // namespace betamesh
