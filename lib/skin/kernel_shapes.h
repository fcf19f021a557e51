// The shapes of wide kernels over the skin: wide where it is flat, narrow across its edges, long along them.

#pragma once

#include "skin/surface_elements.h"

#include <vector>

namespace betamesh {

/// Kernels (1 - pᵀGp)², p from a point to a sample; G is a symmetric matrix. A column per point.
struct KernelShapes {
    std::vector<Vec3f> diagonal, mixed;  ///< of G: xx yy zz and yz zx xy, 1 / square spacings of the frame
    std::vector<float> reach;            ///< largest width, spacings of the frame
    std::vector<float> width;  ///< harmonic mean of those across and along edges, particle spacings at the point

    explicit KernelShapes(std::size_t points)
        : diagonal(points, Vec3f(0)), mixed(points, Vec3f(0)), reach(points), width(points) {}
    /// G of a group of points, one per lane: the diagonal, then the mixed elements.
    void gather(const PointGroup& group, Lanes (&matrix)[6]) const;
};

/// The kernels at the elements of the surface. Each is `widest` wide unless the surface turns sideways near the
/// element. Where it turns away, as on rims of sheets, edges, and threads, the kernel is narrow only in the directions
/// in which the surface faces there: what bulges and recedes along an edge is smoothed, and the edge stays. Where the
/// surface turns towards the element, as in creases, it is narrow in all directions.
///
/// in      unit: the particle spacing, world units; widest: particle spacings
/// same    result for any thread count
/// cost    O(elements · elements within reach)
KernelShapes kernelShapes(const GroupedElements& elements, double unit, double widest);

/// The kernels at the vertices: means over the elements near that face the same way. Without the means, the crest of a
/// blunt edge, from which neither side is turned sideways, would have a wider kernel than the sides, and its border a
/// crease.
///
/// in      normal: of the vertices, unit vectors
/// same    result for any thread count
/// cost    O(vertices · elements within kShapeKernel)
KernelShapes kernelShapes(const DeformingMesh& surface, const Normals& normal, const GroupedElements& elements,
                          const KernelShapes& of_elements);

/// Sets 1 - pᵀGp in lanes, or 0 outside the kernel; of an element the mean of pᵀGp, variance: as in SurfaceElement.
/// g: as from KernelShapes::gather(). (A vector that is returned depends on the instruction set.)
template <typename Pack>
__attribute__((always_inline)) inline void setKernelRoot(const Pack (&g)[6], const Pack (&p)[3], float variance,
                                                         Pack& root) {
    const Pack form = g[0] * p[0] * p[0] + g[1] * p[1] * p[1] + g[2] * p[2] * p[2] +
                      (g[3] * p[1] * p[2] + (g[4] * p[2] + g[5] * p[1]) * p[0]) * 2.0F;
    root = 1.0F - form - variance * ((g[0] + g[1] + g[2]) / 3.0F);
    root = root > 0 ? root : Pack{};
}

}  // namespace betamesh
