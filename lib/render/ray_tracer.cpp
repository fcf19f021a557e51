
#include "render/ray_tracer.h"

#include "base/parallel.h"
#include "betamesh/error.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace betamesh {
namespace {

constexpr float kPastHit = 1 + 1e-5f;  // the search for the next hit starts at this multiple of the last distance

[[noreturn]] void fail(RTCError code) {
    if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw Error("the ray tracer failed (Embree error " + std::to_string(code) +
                "). It needs a processor with SSE2, and a mesh with fewer than 2^32 vertices and triangles.");
}

bool isBlurred(const std::vector<Vec3>& velocity, double shutter_seconds) {
    return shutter_seconds > 0 &&
           std::any_of(velocity.begin(), velocity.end(), [](const Vec3& v) { return v != Vec3(0, 0, 0); });
}

}  // namespace

struct RayTracer::Embree {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    unsigned triangles = RTC_INVALID_GEOMETRY_ID, spheres = RTC_INVALID_GEOMETRY_ID;

    Embree() {
        device = rtcNewDevice(nullptr);
        if (device == nullptr) fail(rtcGetDeviceError(nullptr));
        scene = rtcNewScene(device);
        check();
    }
    ~Embree() {
        if (scene != nullptr) rtcReleaseScene(scene);
        if (device != nullptr) rtcReleaseDevice(device);
    }
    Embree(const Embree&) = delete;
    Embree& operator=(const Embree&) = delete;

    void check() const {
        const RTCError code = rtcGetDeviceError(device);
        if (code != RTC_ERROR_NONE) fail(code);
    }

    /// Fills one buffer of positions, or two if there is motion blur: at the start and the end of the exposure.
    /// finishRow(i, row) may write what follows the position in a row.
    template <typename FinishRow>
    void addPositions(RTCGeometry geometry, RTCFormat format, std::size_t row_bytes, const std::vector<Vec3>& position,
                      const std::vector<Vec3>& velocity, const SceneSpace& space, double shutter_seconds,
                      const FinishRow& finishRow) const {
        const bool blurred = isBlurred(velocity, shutter_seconds);
        rtcSetGeometryTimeStepCount(geometry, blurred ? 2 : 1);
        for (unsigned step = 0; step < (blurred ? 2u : 1u); ++step) {
            const double later = blurred ? (step == 0 ? -shutter_seconds / 2 : shutter_seconds / 2) : 0;
            auto* rows = static_cast<float*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, format, row_bytes, position.size()));
            check();
            parallelFor(position.size(), 4096, [&](std::size_t i) {
                const Vec3 at = space.fromWorld(blurred ? position[i] + velocity[i] * later : position[i]);
                float* row = rows + i * (row_bytes / sizeof(float));
                for (int axis = 0; axis < 3; ++axis) row[axis] = static_cast<float>(at[axis]);
                finishRow(i, row);
            });
        }
    }

    unsigned add(RTCGeometry geometry) const {
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
        rtcCommitGeometry(geometry);
        const unsigned number = rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        check();
        return number;
    }
};

RayTracer::RayTracer(const Mesh& mesh, const Spheres& spheres, const SceneSpace& space, double shutter_seconds,
                     const std::optional<ClipPlane>& clip)
    : embree_(std::make_unique<Embree>()), clip_(clip) {
    const auto radiusOf = [&](std::size_t i) {
        return static_cast<float>(static_cast<double>(spheres.radius[i]) * space.scale);
    };
    for (std::size_t i = 0; i < spheres.size(); ++i) largest_sphere_ = std::max(largest_sphere_, radiusOf(i));
    if (!mesh.triangles.empty()) {
        const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        embree_->addPositions(geometry, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.position, mesh.velocity, space,
                              shutter_seconds, [](std::size_t, float*) {});
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                   sizeof(Triangle), mesh.triangles.size());
        embree_->triangles = embree_->add(geometry);
    }
    if (spheres.size() > 0) {
        const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        embree_->addPositions(geometry, RTC_FORMAT_FLOAT4, 4 * sizeof(float), spheres.position, spheres.velocity, space,
                              shutter_seconds, [&](std::size_t i, float* row) { row[3] = radiusOf(i); });
        embree_->spheres = embree_->add(geometry);
    }
    rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);  // no ray passes between adjacent triangles
    rtcSetSceneBuildQuality(embree_->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(embree_->scene);
    embree_->check();
}

RayTracer::~RayTracer() = default;

namespace {

void fill(RTCRay8& ray, const Rays& rays) {
    const auto copy = [](float* to, const Rays::Row<float>& from) { std::copy(from.begin(), from.end(), to); };
    copy(ray.org_x, rays.origin[0]);
    copy(ray.org_y, rays.origin[1]);
    copy(ray.org_z, rays.origin[2]);
    copy(ray.dir_x, rays.direction[0]);
    copy(ray.dir_y, rays.direction[1]);
    copy(ray.dir_z, rays.direction[2]);
    copy(ray.tnear, rays.t_min);
    copy(ray.tfar, rays.t_max);
    copy(ray.time, rays.time);
    std::fill(std::begin(ray.mask), std::end(ray.mask), ~0u);
    std::fill(std::begin(ray.id), std::end(ray.id), 0u);
    std::fill(std::begin(ray.flags), std::end(ray.flags), 0u);
}

Vec3f rowOf(const std::array<Rays::Row<float>, 3>& rows, std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

}  // namespace

Rays RayTracer::clipped(const Rays& rays) const {
    Rays visible = rays;
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        const float distance = clip_->offset - rowOf(rays.origin, i).dot(clip_->normal),
                    slope = rowOf(rays.direction, i).dot(clip_->normal);
        if (distance < 0 && slope >= 0) visible.active[i] = 0;
        if (distance < 0 && slope < 0) visible.t_min[i] = std::max(visible.t_min[i], distance / slope);
        if (distance >= 0 && slope > 0) visible.t_max[i] = std::min(visible.t_max[i], distance / slope);
    }
    return visible;
}

// A ray enters a mesh through the clip plane if it leaves the mesh at the first triangle that it hits. It enters a
// sphere through the clip plane if the sphere contains the point where the ray crosses the plane.
Hits RayTracer::nearest(const Rays& rays) const {
    if (!clip_) return trace(rays);
    const Rays visible = clipped(rays);
    Hits hits = trace(visible), next = hits;
    Rays further = visible;
    for (std::size_t i = 0; i < Rays::kCount; ++i)
        if (!(visible.t_min[i] > rays.t_min[i])) further.active[i] = 0;
    const auto anyActive = [&] {
        return std::any_of(further.active.begin(), further.active.end(), [](int active) { return active != 0; });
    };
    for (; anyActive(); next = trace(further))
        for (std::size_t i = 0; i < Rays::kCount; ++i) {
            if (further.active[i] == 0) continue;
            const Vec3f direction = rowOf(rays.direction, i), normal = rowOf(next.normal, i);
            const float depth = (next.distance[i] - visible.t_min[i]) * direction.length();
            const bool sphere = next.what[i] == Hits::kSphere;
            bool inside = next.what[i] != Hits::kNothing && normal.dot(direction) > 0;
            if (sphere)  // the normal is the vector from its centre to the hit
                inside = (normal - direction.normalized() * depth).length2() < normal.length2();
            if (inside) {
                hits.what[i] = Hits::kSection;
                hits.distance[i] = visible.t_min[i];
                for (int axis = 0; axis < 3; ++axis)
                    hits.normal[static_cast<std::size_t>(axis)][i] = clip_->normal[axis];
            }
            further.t_min[i] = next.distance[i] * kPastHit;
            if (inside || !sphere || depth > 2 * largest_sphere_) further.active[i] = 0;
        }
    return hits;
}

Hits RayTracer::trace(const Rays& rays) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    RTCRayHit8 ends;
    fill(ends.ray, rays);
    std::fill(std::begin(ends.hit.geomID), std::end(ends.hit.geomID), RTC_INVALID_GEOMETRY_ID);
    rtcIntersect8(rays.active.data(), embree_->scene, &context, &ends);
    Hits hits;
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        const unsigned geometry = ends.hit.geomID[i];
        if (rays.active[i] == 0 || geometry == RTC_INVALID_GEOMETRY_ID) continue;
        hits.what[i] = geometry == embree_->triangles ? Hits::kTriangle : Hits::kSphere;
        hits.row[i] = ends.hit.primID[i];
        hits.distance[i] = ends.ray.tfar[i];
        hits.u[i] = ends.hit.u[i];
        hits.v[i] = ends.hit.v[i];
        hits.normal[0][i] = ends.hit.Ng_x[i];
        hits.normal[1][i] = ends.hit.Ng_y[i];
        hits.normal[2][i] = ends.hit.Ng_z[i];
    }
    return hits;
}

Rays::Row<std::uint8_t> RayTracer::blocked(const Rays& rays) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const Rays visible = clip_ ? clipped(rays) : rays;
    RTCRay8 ends;
    fill(ends, visible);
    rtcOccluded8(visible.active.data(), embree_->scene, &context, &ends);
    Rays::Row<std::uint8_t> blocked{};
    for (std::size_t i = 0; i < Rays::kCount; ++i) blocked[i] = visible.active[i] != 0 && ends.tfar[i] < 0;
    return blocked;
}

}  // namespace betamesh
