// The vector, matrix and box types of the library: those of Imath, under short names.

#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace betamesh {

using Vec3f = Imath::V3f;                 ///< single precision, as in particle files
using Vec3 = Imath::V3d;                  ///< double precision, for computations
using Vec3i = Imath::Vec3<std::int64_t>;  ///< integers, for exact predicates
using Mat33 = Imath::M33d;                ///< multiplied by row vectors from the left
using Box = Imath::Box3d;                 ///< from min to max, both included; default-constructed empty
using Boxf = Imath::Box3f;                ///< the same in single precision

/// The scalar product.
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The vector product.
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Coordinates have to be below 2^31 in magnitude, so that nothing overflows.
inline Vec3i cross(const Vec3i& a, const Vec3i& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The z coordinate of the cross product: positive where b points to the left of a, seen from +z.
template <typename T>
T crossZ(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
    return a.x * b.y - a.y * b.x;
}

/// Is no coordinate infinite or NaN?
template <typename T>
bool isFinite(const Imath::Vec3<T>& v) {
    return std::isfinite(v.x) & std::isfinite(v.y) & std::isfinite(v.z);
}

/// Rounds coordinates beyond 2^53.
inline Vec3 toDouble(const Vec3i& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

/// The length of the longest vector; 0 without any.
inline double largestLength(const std::vector<Vec3>& vectors) {
    double squared = 0;
    for (const Vec3& v : vectors) squared = std::max(squared, v.length2());
    return std::sqrt(squared);
}

}  // namespace betamesh
