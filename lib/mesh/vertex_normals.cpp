
#include "mesh/vertex_normals.h"

#include "base/simd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace betamesh {

namespace {

// Angle of (x, y) from the x axis for y >= 0, radians; 0 at the origin. Branch-free; error below 3e-8.
// source  Abramowitz & Stegun 1964, 4.4.49
__attribute__((always_inline)) inline double angleInUpperHalfPlane(double y, double x) {
    const double ax = std::abs(x), larger = ax > y ? ax : y, smaller = ax > y ? y : ax;
    const double t = smaller / (larger + std::numeric_limits<double>::min()), s = t * t;
    const double first =
        t *
        (1 + s * (-0.3333314528 +
                  s * (0.1999355085 +
                       s * (-0.1420889944 +
                            s * (0.1065626393 +
                                 s * (-0.0752896400 + s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257))))))));
    const double right = y > ax ? std::numbers::pi / 2 - first : first;
    return x < 0 ? std::numbers::pi - right : right;
}

// Height over longest side below which a triangle counts less: its normal is that of rounding and of tiny steps.
constexpr double kSliver = 0.2;

}  // namespace

BETAMESH_EVERY_CPU
void cornerNormals(const TriangleCorners& at, std::size_t count, CornerNormals* normals) {
    std::array<float, kTrianglesAtOnce> out[6];
    const auto& [a, b, c] = at;
    for (std::size_t i = 0; i < kTrianglesAtOnce; ++i) {
        const double ux = b[0][i] - a[0][i], uy = b[1][i] - a[1][i], uz = b[2][i] - a[2][i];
        const double vx = c[0][i] - b[0][i], vy = c[1][i] - b[1][i], vz = c[2][i] - b[2][i];
        const double wx = a[0][i] - c[0][i], wy = a[1][i] - c[1][i], wz = a[2][i] - c[2][i];
        const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
        const double doubled_area = std::sqrt(x * x + y * y + z * z);
        const double scale = doubled_area > 0 ? 1 / (doubled_area + std::numeric_limits<double>::min()) : 0;
        const double longest =
            std::max({ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz});
        const double width = std::min(1.0, doubled_area / (kSliver * longest + std::numeric_limits<double>::min()));
        const double weight = width * width;
        const double at_a = angleInUpperHalfPlane(doubled_area, -(wx * ux + wy * uy + wz * uz)),
                     at_b = angleInUpperHalfPlane(doubled_area, -(ux * vx + uy * vy + uz * vz));
        out[0][i] = static_cast<float>(x * scale);
        out[1][i] = static_cast<float>(y * scale);
        out[2][i] = static_cast<float>(z * scale);
        out[3][i] = static_cast<float>(at_a * weight);
        out[4][i] = static_cast<float>(at_b * weight);
        out[5][i] = static_cast<float>((std::numbers::pi - at_a - at_b) * weight);
    }
    for (std::size_t i = 0; i < count; ++i)
        normals[i] = {{out[0][i], out[1][i], out[2][i]}, {out[3][i], out[4][i], out[5][i]}};
}

}  // namespace betamesh
