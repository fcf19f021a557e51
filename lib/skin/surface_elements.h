// The skin divided into elements with their second moments: what wide kernel sums over it iterate over.

#pragma once

#include "skin/deforming_mesh.h"

#include <algorithm>
#include <vector>

namespace betamesh {

using Normals = std::vector<Vec3f>;

/// A part of the surface that is on one ball and faces roughly one way. Lengths but for the position are in particle
/// spacings.
struct SurfaceElement {
    Vec3 position;         ///< mean, world units
    Vec3f direction;       ///< mean normal, shorter than 1 where the element is curved
    float area, variance;  ///< area, and mean squared distance from the position
    float convexity;       ///< mean of (x - position) · (normal at x): > 0 where the element is convex
    float value;           ///< mean of a value of the vertices
    float scale;           ///< particle spacing at one of the vertices, in spacings of the frame
};

/// Elements in compact groups.
struct GroupedElements {
    std::vector<SurfaceElement> element;
    std::vector<Vec3> position;  ///< of the elements
    PointGroups groups;

    /// The elements of a surface, one per ball or four where its part of the surface is strongly curved. They are exact
    /// integrals, which do not depend on how a plane polygon is triangulated.
    /// value: of each vertex, whose means the elements get; empty: zeros.
    explicit GroupedElements(const DeformingMesh& surface, const std::vector<float>& value = {});
};

/// Fields of an element in sums.
enum ElementField { kPx, kPy, kPz, kDx, kDy, kDz, kElementArea, kVariance, kConvexity, kElementValue, kElementFields };
using ElementSamples = SampleRuns<kElementFields>;

/// Elements that sums visit at most per group of points.
inline constexpr std::size_t kMaxElements = 4096;

/// Positions and normals of a group of points, one per lane.
struct OrientedPoints {
    const Lanes (&position)[3];
    const Lanes (&normal)[3];
};

/// Calls visit(group of points, elements within reach, positions and normals of the group) for every group; reach: of
/// each point, units.
template <typename Visit>
void forElements(const PointGroups& points, const std::vector<Vec3>& point, const GroupedElements& elements,
                 double unit, const std::vector<float>& reach, const Normals& normal, const Visit& visit) {
    const SampleTable<kElementFields> table(
        elements.groups, elements.position, unit, [&](std::uint32_t i, SampleFields<kElementFields>& f) {
            const SurfaceElement& e = elements.element[i];
            f[kDx] = e.direction.x, f[kDy] = e.direction.y, f[kDz] = e.direction.z;
            f[kElementArea] = e.area, f[kVariance] = e.variance, f[kConvexity] = e.convexity;
            f[kElementValue] = e.value;
        });
    forGroups(
        points, point, table, kMaxElements,
        [&](std::size_t group) {
            const auto first = reach.begin() + points.begin(group), last = reach.begin() + points.begin(group + 1);
            return static_cast<double>(*std::max_element(first, last)) * unit;
        },
        [&](const PointGroup& group, ElementSamples samples) {
            const PointGroup::Vectors n = group.gather(normal);
            visit(group, samples, OrientedPoints{group.position, n.lanes});
        });
}

}  // namespace betamesh
