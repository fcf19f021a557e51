#include "base/parallel.h"
#include "exact/neighbour_finder.h"
#include "peers.h"

namespace betamesh {

Mesh algorithmOne(const Particles& particles, double radius) {
    const SnappedParticles snapped = snapParticles(particles, radius);
    const auto whole_radius = static_cast<double>(snapped.radius);
    constexpr std::size_t kPerTask = 256;
    std::vector<std::vector<Triangle>> found(snapped.size() / kPerTask + 1);
    parallelFor(found.size(), 1, [&](std::size_t task) {
        NeighbourFinder finder(snapped);
        std::vector<Neighbour> neighbours;
        for (auto i = static_cast<std::uint32_t>(task * kPerTask); i < std::min(snapped.size(), (task + 1) * kPerTask);
             ++i) {
            finder.find(i, neighbours);
            const Vec3 origin = toDouble(snapped.position[i]);
            for (const Neighbour& j : neighbours)
                for (const Neighbour& k : neighbours) {
                    if (j.particle < i || k.particle < i || k.particle == j.particle) continue;
                    const FloatBalls balls(origin, j, k, whole_radius, whole_radius);
                    if (!balls.exist()) continue;
                    const Vec3 centre = balls.centre(1);
                    const auto blocks = [&](const Neighbour& n) {
                        return n.particle != j.particle && n.particle != k.particle && balls.contains(centre, 1, n);
                    };
                    if (std::none_of(neighbours.begin(), neighbours.end(), blocks))
                        found[task].push_back({snapped.row[i], snapped.row[j.particle], snapped.row[k.particle]});
                }
        }
    });
    Mesh mesh;
    for (const Vec3f& p : particles.position) mesh.position.emplace_back(p);
    for (const auto& part : found) mesh.triangles.insert(mesh.triangles.end(), part.begin(), part.end());
    return mesh;
}

}  // namespace betamesh
