
#include "skin/triangle_run.h"

#include "base/icosphere.h"
#include "base/simd.h"
#include "exact/orientation.h"

#include <limits>

namespace betamesh {

namespace {

constexpr double kFacingCosine = 0.35;  // least cosine between a normal and a direction that the triangle faces

bool isFlat(const std::vector<Vec3>& position, const Triangle& triangle) {
    const auto& [a, b, c] = triangle;
    return onOneLine(position[a], position[b], position[c]);
}

// Corners of consecutive triangles, [corner][axis][triangle], before the displacement and now.
using Corners = std::array<std::array<std::array<double, kRun>, 3>, 3>;
struct Run {
    Corners before{}, now{};
};
struct RunShape {
    std::array<std::array<double, kRun>, 3> normal;    // by axis; of unit length, zero without area
    std::array<double, kRun> movement;                 // 0 if no corner moves, > 0 otherwise
    std::array<double, kRun> turned;                   // <= 0 if the normal has turned by 90 degrees or more
    std::array<std::array<float, kRun>, 3> low, high;  // boxes that contain the triangles
};

BETAMESH_EVERY_CPU
void shapeOf(const Run& run, RunShape& shape) {
    const auto& [a, b, c] = run.now;
    const auto& [d, e, f] = run.before;
    for (std::size_t i = 0; i < kRun; ++i) {
        const double ux = b[0][i] - a[0][i], uy = b[1][i] - a[1][i], uz = b[2][i] - a[2][i];
        const double vx = c[0][i] - a[0][i], vy = c[1][i] - a[1][i], vz = c[2][i] - a[2][i];
        const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
        const double qx = e[0][i] - d[0][i], qy = e[1][i] - d[1][i], qz = e[2][i] - d[2][i];
        const double rx = f[0][i] - d[0][i], ry = f[1][i] - d[1][i], rz = f[2][i] - d[2][i];
        shape.turned[i] = x * (qy * rz - qz * ry) + y * (qz * rx - qx * rz) + z * (qx * ry - qy * rx);
        const double length = std::sqrt(x * x + y * y + z * z);
        const double scale = length > 0 ? 1 / (length + std::numeric_limits<double>::min()) : 0;
        shape.normal[0][i] = x * scale;
        shape.normal[1][i] = y * scale;
        shape.normal[2][i] = z * scale;
    }
    shape.movement = {};
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t m = 0; m < 3; ++m)
            for (std::size_t i = 0; i < kRun; ++i)
                shape.movement[i] += std::abs(run.now[m][k][i] - run.before[m][k][i]);
        for (std::size_t i = 0; i < kRun; ++i) {
            const double p = a[k][i], q = b[k][i], r = c[k][i];
            const double lower = p < q ? p : q, higher = p < q ? q : p;
            const auto least = static_cast<float>(lower < r ? lower : r),
                       most = static_cast<float>(higher > r ? higher : r);
            shape.low[k][i] = justBelow(least);
            shape.high[k][i] = justAbove(most);
        }
    }
}

// The facing mask of each triangle; all bits of one without area.
BETAMESH_EVERY_CPU
void facingOf(const RunShape& shape, const std::vector<Vec3>& directions, std::array<std::uint64_t, kRun>& facing) {
    const auto& [x, y, z] = shape.normal;
    for (std::size_t i = 0; i < kRun; ++i) {
        const bool any = (x[i] != 0) | (y[i] != 0) | (z[i] != 0);
        facing[i] = any ? std::uint64_t{0} : ~std::uint64_t{0};
    }
    for (std::size_t d = 0; d < directions.size(); ++d) {
        const Vec3 direction = directions[d];
        const std::uint64_t bit = std::uint64_t{1} << d;
        for (std::size_t i = 0; i < kRun; ++i) {
            const double cosine = x[i] * direction.x + y[i] * direction.y + z[i] * direction.z;
            facing[i] |= cosine >= kFacingCosine ? bit : 0;
        }
    }
}

}  // namespace

bool isFlat(const std::vector<DualVec3>& vertex, const Triangle& triangle) {
    const auto& [a, b, c] = triangle;
    return onOneLine(vertex[a].position, vertex[b].position, vertex[c].position);
}

TriangleRun::TriangleRun(const BetaMesh& mesh, const std::vector<Vec3>& before, std::uint32_t begin,
                         std::uint32_t size) {
    static const std::vector<Vec3> directions = icosphere(2).position;
    Run run;
    for (std::uint32_t i = 0; i < size; ++i)
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t v = mesh.triangles[begin + i][m];
            const Vec3 &from = before[v], &to = mesh.vertex[v].position;
            for (std::size_t k = 0; k < 3; ++k) {
                run.before[m][k][i] = from[static_cast<int>(k)];
                run.now[m][k][i] = to[static_cast<int>(k)];
            }
        }
    RunShape shape;
    shapeOf(run, shape);
    facingOf(shape, directions, facing);
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < kRun; ++i) normal[k][i] = static_cast<float>(shape.normal[k][i]);
    low = shape.low;
    high = shape.high;
    for (std::uint32_t i = 0; i < size; ++i) {
        const Triangle& triangle = mesh.triangles[begin + i];
        const bool flat = shape.turned[i] <= 0 && isFlat(mesh.vertex, triangle) && isFlat(before, triangle);
        if (flat) facing[i] = ~std::uint64_t{0};
        moved[i] = shape.movement[i] > 0;
        turned[i] = moved[i] && shape.turned[i] <= 0 && !flat;
        octant[i] = static_cast<std::uint8_t>((shape.normal[0][i] > 0) + 2 * (shape.normal[1][i] > 0) +
                                              4 * (shape.normal[2][i] > 0));
    }
}

}  // namespace betamesh
