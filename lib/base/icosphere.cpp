
#include "base/icosphere.h"

#include "base/simd.h"

#include <cmath>
#include <map>

namespace betamesh {

Icosphere icosphere(std::uint32_t cuts) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    const std::array<Vec3, 12> corner{Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0),
                                      Vec3(0, -1, g), Vec3(0, 1, g), Vec3(0, -1, -g), Vec3(0, 1, -g),
                                      Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)};
    constexpr std::array<std::array<std::uint32_t, 3>, 20> face{
        {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
         {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
         {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

    // Integer barycentric weights with respect to the 12 corners identify a vertex, on either face of an edge.
    using Weights = std::array<std::uint32_t, 12>;
    std::map<Weights, std::uint32_t> vertex_of;
    Icosphere sphere;
    const auto vertexAt = [&](const std::array<std::uint32_t, 3>& corners, std::uint32_t i, std::uint32_t j) {
        Weights weights{};
        weights[corners[0]] += cuts - i - j, weights[corners[1]] += i, weights[corners[2]] += j;
        const auto [at, is_new] = vertex_of.try_emplace(weights, static_cast<std::uint32_t>(sphere.position.size()));
        if (is_new) {
            Vec3 sum(0, 0, 0);
            for (std::size_t k = 0; k < 12; ++k) sum += corner[k] * weights[k];
            sphere.position.push_back(sum.normalized());
        }
        return at->second;
    };
    for (const auto& corners : face) {
        const auto vertex = [&](std::uint32_t i, std::uint32_t j) { return vertexAt(corners, i, j); };
        for (std::uint32_t i = 0; i < cuts; ++i)
            for (std::uint32_t j = 0; i + j < cuts; ++j) {
                sphere.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
                if (i + j + 1 < cuts)
                    sphere.triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
            }
    }
    return sphere;
}

Icosphere icosphereOf(double angle) {
    constexpr double kIcosahedronEdge = 1.1071487177940904;  // angle that an edge subtends, radians
    return icosphere(static_cast<std::uint32_t>(std::ceil(kIcosahedronEdge / angle)));
}

DirectionColumns::DirectionColumns(const std::vector<Vec3>& directions) {
    for (const Vec3& direction : directions) {
        x.push_back(static_cast<float>(direction.x));
        y.push_back(static_cast<float>(direction.y));
        z.push_back(static_cast<float>(direction.z));
    }
    for (std::vector<float>* axis : {&x, &y, &z})
        while (axis->size() % kLanes != 0) axis->push_back(axis->back());
}

}  // namespace betamesh
