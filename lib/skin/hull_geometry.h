// Geometry of convex hulls of points on a sphere: exact signs, and the same quickly where rounding cannot matter.
// Internal to the hull.

#pragma once

#include "base/simd.h"
#include "exact/predicates.h"
#include "skin/sphere_loops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace betamesh {

using Int128 = __int128;

/// Sign of (b - a) × (c - a) · (p - a), exactly: +1 if p lies above the triangle, on the side from which it is seen
/// counter-clockwise. Differences of coordinates are below 2^40, so everything fits in 128 bits.
inline int orient(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    const Vec3i iu = b - a, iv = c - a, iw = p - a;
    const Vec3 u = toDouble(iu), v = toDouble(iv), w = toDouble(iw);
    const double xy = u.x * v.y, yx = u.y * v.x, yz = u.y * v.z, zy = u.z * v.y, zx = u.z * v.x, xz = u.x * v.z;
    const double determinant = (yz - zy) * w.x + (zx - xz) * w.y + (xy - yx) * w.z;
    const double size = (std::abs(yz) + std::abs(zy)) * std::abs(w.x) + (std::abs(zx) + std::abs(xz)) * std::abs(w.y) +
                        (std::abs(xy) + std::abs(yx)) * std::abs(w.z);
    const double bound = 16 * 0x1p-53 * size;  // seven roundings along any path, twice over
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
    const Int128 exact = (Int128{iu.y} * iv.z - Int128{iu.z} * iv.y) * iw.x +
                         (Int128{iu.z} * iv.x - Int128{iu.x} * iv.z) * iw.y +
                         (Int128{iu.x} * iv.y - Int128{iu.y} * iv.x) * iw.z;
    return (exact > 0) - (exact < 0);
}

/// Are the normals of two coplanar triangles equal (+1) or opposite (-1)?
inline int sameTurn(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& d, const Vec3i& e, const Vec3i& f) {
    const auto component = [](const Vec3i& u, const Vec3i& v, int k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        return Int128{u[i]} * v[j] - Int128{u[j]} * v[i];
    };
    for (int k = 0; k < 3; ++k) {
        const Int128 first = component(b - a, c - a, k), second = component(e - d, f - d, k);
        if (first != 0 && second != 0) return (first > 0) == (second > 0) ? 1 : -1;
    }
    return 0;
}

/// orient() of points that are each lifted outwards by an infinitesimal amount, the lexicographically first by most:
/// never 0 for four distinct points of a sphere round the origin, whichever way the triangle faces.
inline int liftedOrient(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& p) {
    if (const int sign = orient(a, b, c, p)) return sign;
    const int facing = orient(a, b, c, Vec3i(0)) > 0 ? -1 : 1;
    const Vec3i& first = std::min({a, b, c, p}, before);
    if (first == p) return facing;
    if (first == a) return -facing * sameTurn(a, b, c, p, b, c);
    if (first == b) return -facing * sameTurn(a, b, c, a, p, c);
    return -facing * sameTurn(a, b, c, a, b, p);
}

/// The plane through three points, and on which side of it a fourth lies unless rounding may decide.
struct HullPlane {
    Vec3 origin, normal;
    double bound;  // of the rounding error of heights

    HullPlane(const Vec3& a, const Vec3& b, const Vec3& c) : origin(a) {
        const Vec3 u = b - a, v = c - a;
        normal = cross(u, v);
        // Products of the differences, below 2^40, carry a rounding each, and so do the sums.
        const double largest_u = std::max({std::abs(u.x), std::abs(u.y), std::abs(u.z)}),
                     largest_v = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        bound = 0x1p-48 * largest_u * largest_v * 0x1p40;
    }
    enum Side { above, below, unsure };
    Side sideOf(const Vec3& p) const {
        const double height = dot(normal, p - origin);
        return height > bound ? above : height < -bound ? below : unsure;
    }
};

/// Points in arrays of coordinates.
struct PointColumns {
    std::vector<double> x, y, z;

    std::size_t size() const { return x.size(); }
    Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
    void clear() { x.clear(), y.clear(), z.clear(); }
    void add(const Vec3& p) { x.push_back(p.x), y.push_back(p.y), z.push_back(p.z); }
};

/// The same in floats and in radii, padded to whole registers with the origin.
struct FloatColumns {
    std::vector<float> x, y, z;

    void assign(const PointColumns& points) {
        const auto round = [](const std::vector<double>& from, std::vector<float>& to) {
            to.assign((from.size() + kLanes - 1) / kLanes * kLanes, 0);
            for (std::size_t k = 0; k < from.size(); ++k) to[k] = static_cast<float>(from[k] / kHullRadius);
        };
        round(points.x, x);
        round(points.y, y);
        round(points.z, z);
    }
};

/// The number in the lane of the largest value, or of any of several largest.
template <std::size_t kWidth>
__attribute__((always_inline)) inline void takeNumberOfLargest(const Floats<kWidth>& value,
                                                               const Floats<kWidth>& number, float& taken) {
    if constexpr (kWidth == 1) {
        taken = number[0];
    } else {
        constexpr std::size_t kHalf = kWidth / 2;
        Floats<kHalf> low, high, low_number, high_number;
        std::memcpy(&low, &value, sizeof low);
        std::memcpy(&high, reinterpret_cast<const float*>(&value) + kHalf, sizeof high);
        std::memcpy(&low_number, &number, sizeof low);
        std::memcpy(&high_number, reinterpret_cast<const float*>(&number) + kHalf, sizeof high);
        takeNumberOfLargest<kHalf>(high > low ? high : low, high > low ? high_number : low_number, taken);
    }
}

/// Gift wrapping in floats: the number of the first point that a plane meets when it turns about the line through
/// `origin`, starting where it faces along `normal`. away: in that plane, across the line, away from the points.
/// left_out: the numbers of the two points on the line. Because of rounding, a point close to the first may be found
/// instead.
struct FirstPointTurnedTo {
    const FloatColumns& points;
    Vec3f origin, normal, away;
    std::array<float, 2> left_out;
    float& found;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Pack = Floats<kWidth>;
        const Pack zero{}, least = zero + 1e-12F, never = zero - 1e30F;
        Pack most = never, most_at{}, at;
        setNumbers<kWidth>(at);
        for (std::size_t i = 0; i < points.x.size(); i += kWidth, at += static_cast<float>(kWidth)) {
            Pack x, y, z;
            std::memcpy(&x, &points.x[i], sizeof x);
            std::memcpy(&y, &points.y[i], sizeof y);
            std::memcpy(&z, &points.z[i], sizeof z);
            x -= origin.x, y -= origin.y, z -= origin.z;
            Pack depth = zero - (x * normal.x + y * normal.y + z * normal.z);
            depth = depth > least ? depth : least;
            const Pack from_first = at - left_out[0], from_second = at - left_out[1];
            Pack is_first = 1.0F - from_first * from_first, is_second = 1.0F - from_second * from_second;
            is_first = is_first > 0 ? is_first : zero;
            is_second = is_second > 0 ? is_second : zero;
            const Pack cotangent = (x * away.x + y * away.y + z * away.z) / depth + (is_first + is_second) * never;
            most_at = cotangent > most ? at : most_at;
            most = cotangent > most ? cotangent : most;
        }
        takeNumberOfLargest<kWidth>(most, most_at, found);
    }
};

}  // namespace betamesh
