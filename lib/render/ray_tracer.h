// The door of Embree: which point of a mesh and its spheres a ray meets first.

#pragma once

#include "betamesh/mesh.h"

#include <array>
#include <memory>
#include <optional>

namespace betamesh {

/// Places of the world as the ray tracer takes them: counted from an origin near what is seen and in units of about the
/// size of everything, so that single precision is as good for nanometres as for light years, and far from the world's
/// origin as near it.
struct SceneSpace {
    Vec3 origin{0, 0, 0};  ///< in the world
    double scale = 1;      ///< scene units to a world unit; a power of two, so that scaling rounds nothing

    Vec3 fromWorld(const Vec3& p) const { return (p - origin) * scale; }
    Vec3 toWorld(const Vec3f& p) const { return Vec3(p) / scale + origin; }
};

/// Eight rays at once, for speed; those that are near each other find their way together.
struct Rays {
    static constexpr std::size_t kCount = 8;
    template <typename T>
    using Row = std::array<T, kCount>;

    alignas(32) Row<int> active{};  ///< -1: traced; 0: left as it is
    alignas(32) std::array<Row<float>, 3> origin{}, direction{};
    alignas(32) Row<float> least{}, most{};  ///< part of the ray that counts, in lengths of its direction
    alignas(32) Row<float> time{};           ///< within the shutter, 0 to 1
};

/// Cuts away the points p of the scene with normal · p > offset. normal is a unit vector.
struct CutPlane {
    Vec3f normal{1, 0, 0};
    float offset = 0;
};

/// Where rays end. IndexRows of rays that meet nothing hold kNothing in `what`, those that come in where the plane of a cut
/// passes through the inside of a mesh or of spheres kSection.
struct Hits {
    enum What : std::uint8_t { kNothing, kTriangle, kSphere, kSection };

    Rays::Row<What> what{};
    Rays::Row<std::uint32_t> row{};            ///< of the triangle or the sphere
    Rays::Row<float> distance{};               ///< in lengths of the direction
    Rays::Row<float> u{}, v{};                 ///< weights of a triangle's second and third corner
    std::array<Rays::Row<float>, 3> normal{};  ///< outwards, of any length; of the triangle itself, not smoothed
};

/// Rays, cuts and hits are in scene space.
class RayTracer {
public:
    /// shutter_seconds: how long everything moves by its velocity, half of it before and half after the moment of
    /// the mesh; the cut stays where it is. The mesh and its spheres must outlive the tracer.
    ///
    /// same    answers for any thread count
    RayTracer(const Mesh& mesh, const Spheres& spheres, const SceneSpace& space, double shutter_seconds,
              const std::optional<CutPlane>& cut);
    ~RayTracer();
    RayTracer(const RayTracer&) = delete;
    RayTracer& operator=(const RayTracer&) = delete;

    Hits nearest(const Rays& rays) const;
    /// 1 for rays that meet anything.
    Rays::Row<std::uint8_t> blocked(const Rays& rays) const;

private:
    struct Embree;

    Hits traced(const Rays& rays) const;
    Rays uncut(const Rays& rays) const;

    std::unique_ptr<Embree> embree_;
    std::optional<CutPlane> cut_;
    float largest_sphere_ = 0;  // radius, scene units
};

}  // namespace betamesh
