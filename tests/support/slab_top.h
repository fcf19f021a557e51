// Measures of the top face of a slab of particles with spacing 1: flatness, and the remaining height of waves.

#pragma once

#include "betamesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

/// Calls visit(centroid, normal) for each triangle of the top face with centroid x and y in [low, high]. The length of
/// the normal is twice the area.
template <typename Visit>
void forTopOf(const Mesh& mesh, double low, double high, const Visit& visit) {
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        const Vec3 middle = (a + b + c) / 3, normal = cross(b - a, c - a);
        if (std::min(middle.x, middle.y) < low || std::max(middle.x, middle.y) > high || middle.z < 3) continue;
        if (normal.z > 0.2 * normal.length()) visit(middle, normal);
    }
}

/// The remaining amplitude of a wave of amplitude 1 along x: a least-squares fit with a constant term. [low, high] has
/// to span whole wavelengths.
inline double waveKept(const Mesh& mesh, double wavelength, double low, double high) {
    double w = 0, s = 0, ss = 0, z = 0, zs = 0;
    forTopOf(mesh, low, high, [&](const Vec3& middle, const Vec3& normal) {
        const double wave = std::sin(2 * std::numbers::pi * middle.x / wavelength), size = normal.z;
        w += size, s += size * wave, ss += size * wave * wave, z += size * middle.z, zs += size * middle.z * wave;
    });
    return (zs - z * s / w) / (ss - s * s / w);
}

}  // namespace betamesh
