#include "preview/ray_tracer.h"

#include "core/error.h"
#include "core/parallel.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace betamesh {
namespace {

constexpr std::size_t kGrain = 4096;  // rows

[[noreturn]] void fail(RTCError code) {
    if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw Error("Embree: error " + std::to_string(code) +
                "; expected a processor with SSE2 and a mesh below 2^32 rows");
}

bool moves(const std::vector<Vec3>& velocity, double shutter_seconds) {
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

    /// One buffer of positions, or two: where things are as the shutter opens and as it closes. place(i) writes the
    /// floats of row i, given its position.
    template <typename Place>
    void addPositions(RTCGeometry geometry, RTCFormat format, std::size_t row_bytes, const std::vector<Vec3>& position,
                      const std::vector<Vec3>& velocity, const Vec3& origin, double shutter_seconds,
                      const Place& place) const {
        const bool blurred = moves(velocity, shutter_seconds);
        rtcSetGeometryTimeStepCount(geometry, blurred ? 2 : 1);
        for (unsigned step = 0; step < (blurred ? 2u : 1u); ++step) {
            const double later = blurred ? (step == 0 ? -shutter_seconds / 2 : shutter_seconds / 2) : 0;
            auto* rows = static_cast<float*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, format, row_bytes, position.size()));
            check();
            parallelFor(position.size(), kGrain, [&](std::size_t i) {
                Vec3 at = position[i] - origin;
                if (blurred) at += velocity[i] * later;
                float* row = rows + i * (row_bytes / sizeof(float));
                for (int axis = 0; axis < 3; ++axis) row[axis] = static_cast<float>(at[axis]);
                place(i, row);
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

RayTracer::RayTracer(const Mesh& mesh, const Spheres& spheres, const Vec3& origin, double shutter_seconds)
    : embree_(std::make_unique<Embree>()) {
    if (!mesh.triangles.empty()) {
        const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        embree_->addPositions(geometry, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.position, mesh.velocity, origin,
                              shutter_seconds, [](std::size_t, float*) {});
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                   sizeof(Triangle), mesh.triangles.size());
        embree_->triangles = embree_->add(geometry);
    }
    if (spheres.size() > 0) {
        const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        embree_->addPositions(geometry, RTC_FORMAT_FLOAT4, 4 * sizeof(float), spheres.position, spheres.velocity,
                              origin, shutter_seconds, [&](std::size_t i, float* row) { row[3] = spheres.radius[i]; });
        embree_->spheres = embree_->add(geometry);
    }
    rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips between two triangles
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
    copy(ray.tnear, rays.least);
    copy(ray.tfar, rays.most);
    copy(ray.time, rays.time);
    std::fill(std::begin(ray.mask), std::end(ray.mask), ~0u);
    std::fill(std::begin(ray.id), std::end(ray.id), 0u);
    std::fill(std::begin(ray.flags), std::end(ray.flags), 0u);
}

}  // namespace

Hits RayTracer::nearest(const Rays& rays) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    RTCRayHit8 traced;
    fill(traced.ray, rays);
    std::fill(std::begin(traced.hit.geomID), std::end(traced.hit.geomID), RTC_INVALID_GEOMETRY_ID);
    rtcIntersect8(rays.active.data(), embree_->scene, &context, &traced);
    Hits hits;
    for (std::size_t i = 0; i < Rays::kCount; ++i) {
        const unsigned geometry = traced.hit.geomID[i];
        if (rays.active[i] == 0 || geometry == RTC_INVALID_GEOMETRY_ID) continue;
        hits.what[i] = geometry == embree_->triangles ? Hits::kTriangle : Hits::kSphere;
        hits.row[i] = traced.hit.primID[i];
        hits.distance[i] = traced.ray.tfar[i];
        hits.u[i] = traced.hit.u[i];
        hits.v[i] = traced.hit.v[i];
        hits.normal[0][i] = traced.hit.Ng_x[i];
        hits.normal[1][i] = traced.hit.Ng_y[i];
        hits.normal[2][i] = traced.hit.Ng_z[i];
    }
    return hits;
}

Rays::Row<std::uint8_t> RayTracer::blocked(const Rays& rays) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay8 traced;
    fill(traced, rays);
    rtcOccluded8(rays.active.data(), embree_->scene, &context, &traced);
    Rays::Row<std::uint8_t> blocked{};
    for (std::size_t i = 0; i < Rays::kCount; ++i) blocked[i] = rays.active[i] != 0 && traced.tfar[i] < 0;
    return blocked;
}

}  // namespace betamesh
