#include "skin/paper_mesh.h"

#include "base/parallel.h"

#include <algorithm>

namespace betamesh {

namespace {

// Does the arc of a half-edge lead from a triangle to its own reverse side, round the rim of a sheet?
bool goesRoundRim(const BallBoundary& boundary, std::uint32_t half_edge) {
    const std::uint32_t v = half_edge / 3, across = boundary.twin[half_edge] / 3;
    return across != v && across == reverseSide(boundary, v);
}

// Where fans of a ball meet at a rim, the fan before and the fan after it, indexed by half-edges towards the fans'
// ball. The twin of a half-edge from i to j leads from j to i: the two are the sides of one arc.
struct Rims {
    std::vector<std::uint32_t> fan_before, fan_after;
};

// Cuts every cycle into fans where it goes round a rim.
Rims cutIntoFans(const BallBoundary& boundary, PaperMesh& beta) {
    Rims rims;
    rims.fan_before.assign(boundary.twin.size(), 0);
    rims.fan_after.assign(boundary.twin.size(), 0);
    const auto closeFan = [&](std::uint32_t ball, bool open) {
        beta.fan.begin.push_back(static_cast<std::uint32_t>(beta.fan.item.size()));
        beta.fan_open.push_back(open ? 1 : 0);
        beta.fan_ball.push_back(ball);
    };
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        const auto cycle = boundary.cycle[c];
        const std::uint32_t ball = boundary.triangle[cycle[0] / 3][cycle[0] % 3];
        std::size_t first = 0;  // start after a rim, if there is one
        while (first < cycle.size() &&
               !goesRoundRim(boundary, previousInTriangle(cycle[(first + cycle.size() - 1) % cycle.size()])))
            ++first;
        if (first == cycle.size()) {
            beta.fan.item.reserve(beta.fan.item.size() + cycle.size());
            for (const std::uint32_t h : cycle) beta.fan.item.push_back(h / 3);
            closeFan(ball, false);
            continue;
        }
        const auto first_fan = static_cast<std::uint32_t>(beta.fan.size());
        for (std::size_t e = 0; e < cycle.size(); ++e) {
            const std::uint32_t h = cycle[(first + e) % cycle.size()], leaving = previousInTriangle(h);
            beta.fan.item.push_back(h / 3);
            if (!goesRoundRim(boundary, leaving)) continue;
            rims.fan_before[leaving] = static_cast<std::uint32_t>(beta.fan.size());
            closeFan(ball, true);
            rims.fan_after[leaving] = e + 1 == cycle.size() ? first_fan : static_cast<std::uint32_t>(beta.fan.size());
        }
    }
    return rims;
}

// Position and motion of the alphabeta vertex of fan f.
DualVec3 alphabetaVertex(const BallBoundary& boundary, const PaperMesh& beta, std::size_t f,
                         const std::vector<DualVec3>& balls) {
    const auto ring = beta.fan[f];
    DualVec3 sum;
    Dual weight;
    for (std::size_t e = 0; e < beta.fanEdges(f); ++e) {
        const DualVec3 &a = beta.vertex[ring[e]], &b = beta.vertex[ring[(e + 1) % ring.size()]];
        const Dual w = length(b - a);
        sum = sum + (a + b) * 0.5 * w;
        weight = weight + w;
    }
    const DualVec3 mean = weight.value > 0 ? sum / weight : beta.vertex[ring[0]];
    if (!beta.fan_open[f]) return mean;
    DualVec3 normal;
    for (const std::uint32_t v : ring) {
        const Triangle& t = boundary.triangle[v];
        normal = normal + cross(balls[t[1]] - balls[t[0]], balls[t[2]] - balls[t[0]]);
    }
    const Dual squared = dot(normal, normal);
    if (!(squared.value > 0)) return mean;
    const DualVec3& particle = balls[beta.fan_ball[f]];
    return particle + normal * (dot(mean - particle, normal) / squared);
}

// Joins the fans on both sides of every rim by a quad. Round one ball the quads leave a polygon of its fans.
void closeRims(const BallBoundary& boundary, const Rims& rims, PaperMesh& beta) {
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a != b && b != c && c != a) beta.triangles.push_back({a, b, c});
    };
    for (std::uint32_t h = 0; h < boundary.twin.size(); ++h) {
        // each rim once: h goes from i to j in triangle v, its twin from j to i in the reverse side of v
        const std::uint32_t twin = boundary.twin[h];
        if (h > twin || !goesRoundRim(boundary, h)) continue;
        // at j the cycle leaves v along h, at i it leaves the reverse side along the twin
        const std::uint32_t j_here = beta.alphabeta(rims.fan_before[h]), j_there = beta.alphabeta(rims.fan_after[h]);
        const std::uint32_t i_there = beta.alphabeta(rims.fan_before[twin]),
                            i_here = beta.alphabeta(rims.fan_after[twin]);
        beta.rim[h / 3] = beta.rim[twin / 3] = 1;
        add(i_here, j_here, h / 3);
        add(j_there, i_there, twin / 3);
        add(j_here, i_here, j_there);
        add(i_here, i_there, j_there);
    }
}

// Fills the polygon of fans that quads leave open where a cycle goes round more than two rims.
void closePolygonsBetweenRims(const BallBoundary& boundary, const Rims& rims, PaperMesh& beta) {
    for (std::size_t c = 0; c < boundary.cycle.size(); ++c) {
        std::vector<std::uint32_t> polygon;
        for (const std::uint32_t h : boundary.cycle[c])
            if (goesRoundRim(boundary, previousInTriangle(h)))
                polygon.push_back(beta.alphabeta(rims.fan_after[previousInTriangle(h)]));
        for (std::size_t k = 2; k < polygon.size(); ++k)
            beta.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }
}

}  // namespace

PaperMesh paperTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls,
                            const std::vector<DualVec3>& vertices) {
    PaperMesh beta;
    beta.pure = vertices.size();
    beta.vertex = vertices;
    beta.rim.assign(beta.pure, 0);
    const Rims rims = cutIntoFans(boundary, beta);
    beta.vertex.resize(beta.pure + beta.fan.size());
    parallelFor(beta.fan.size(), 1024,
                [&](std::size_t f) { beta.vertex[beta.alphabeta(f)] = alphabetaVertex(boundary, beta, f, balls); });
    for (std::size_t f = 0; f < beta.fan.size(); ++f) {
        const auto ring = beta.fan[f];
        for (std::size_t e = 0; e < beta.fanEdges(f); ++e)
            if (const std::uint32_t a = ring[e], b = ring[(e + 1) % ring.size()]; a != b)
                beta.triangles.push_back({beta.alphabeta(f), a, b});
    }
    closeRims(boundary, rims, beta);
    closePolygonsBetweenRims(boundary, rims, beta);
    return beta;
}

Spheres externalSpheres(const BallBoundary& boundary, const Particles& particles) {
    std::vector<std::uint32_t> balls = boundary.isolated;
    for (const auto& circle : boundary.circle) balls.insert(balls.end(), circle.begin(), circle.end());
    std::sort(balls.begin(), balls.end());
    balls.erase(std::unique(balls.begin(), balls.end()), balls.end());

    Spheres spheres;
    for (const std::uint32_t ball : balls) {
        const std::uint32_t row = boundary.row[ball];
        spheres.particle.push_back(row);
        spheres.position.emplace_back(particles.position[row]);
        if (!particles.velocity.empty()) spheres.velocity.emplace_back(particles.velocity[row]);
        if (!particles.id.empty()) spheres.id.push_back(particles.id[row]);
        spheres.radius.push_back(static_cast<float>(boundary.worldRadius()));
    }
    return spheres;
}

}  // namespace betamesh
