// The vector type of the whole library: Imath's, under two short names.

#pragma once

#include <Imath/ImathVec.h>

namespace betamesh {

using Vec3f = Imath::V3f;  ///< single precision: what particle files hold
using Vec3 = Imath::V3d;   ///< double precision: what is computed with

inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace betamesh
