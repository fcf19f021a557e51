// Wrapper of Embree: where rays first hit a mesh and its spheres.

#pragma once

#include "betamesh/mesh.h"

#include <array>
#include <memory>
#include <optional>

namespace betamesh {

/// Coordinates that the ray tracer computes in: the origin is near the visible surface and the unit is about the size
/// of the scene. Single precision is then accurate for scenes of any size, at any distance from the world's origin.
struct SceneSpace {
    Vec3 origin{0, 0, 0};  ///< world units
    double scale = 1;      ///< scene units per world unit; a power of two, so that scaling is exact

    Vec3 fromWorld(const Vec3& p) const { return (p - origin) * scale; }
    Vec3 toWorld(const Vec3f& p) const { return Vec3(p) / scale + origin; }
};

/// A packet of eight rays. Packets of similar rays are traced fastest.
struct Rays {
    static constexpr std::size_t kCount = 8;
    template <typename T>
    using Row = std::array<T, kCount>;

    alignas(32) Row<int> active{};  ///< -1: traced; 0: skipped
    alignas(32) std::array<Row<float>, 3> origin{}, direction{};
    alignas(32) Row<float> t_min{}, t_max{};  ///< interval of the ray that is traced, in lengths of its direction
    alignas(32) Row<float> time{};            ///< fraction of the exposure time, 0 to 1
};

/// Hides the points p of the scene with normal · p > offset. normal is a unit vector.
struct ClipPlane {
    Vec3f normal{1, 0, 0};
    float offset = 0;
};

/// First hits of a packet of rays. kSection: the ray enters the liquid through the clip plane.
struct Hits {
    enum What : std::uint8_t { kNothing, kTriangle, kSphere, kSection };

    Rays::Row<What> what{};
    Rays::Row<std::uint32_t> row{};            ///< index of the triangle or the sphere
    Rays::Row<float> distance{};               ///< in lengths of the direction
    Rays::Row<float> u{}, v{};                 ///< barycentric weights of a triangle's second and third corner
    std::array<Rays::Row<float>, 3> normal{};  ///< outwards, any length; of the triangle itself, not interpolated
};

/// Rays, clip plane and hits are in scene space.
class RayTracer {
public:
    /// shutter_seconds: exposure time, centred on the frame, during which everything but the clip plane moves with its
    /// velocity. The mesh and its spheres must outlive the tracer.
    ///
    /// same    hits for any thread count
    /// errors  Embree cannot run on this processor or hold this scene
    RayTracer(const Mesh& mesh, const Spheres& spheres, const SceneSpace& space, double shutter_seconds,
              const std::optional<ClipPlane>& clip);
    ~RayTracer();
    RayTracer(const RayTracer&) = delete;
    RayTracer& operator=(const RayTracer&) = delete;

    Hits nearest(const Rays& rays) const;
    /// 1 for rays that hit anything.
    Rays::Row<std::uint8_t> blocked(const Rays& rays) const;

private:
    struct Embree;

    Hits trace(const Rays& rays) const;    // ignores the clip plane
    Rays clipped(const Rays& rays) const;  // intervals on the visible side of the clip plane

    std::unique_ptr<Embree> embree_;
    std::optional<ClipPlane> clip_;
    float largest_sphere_ = 0;  // radius, scene units
};

}  // namespace betamesh
