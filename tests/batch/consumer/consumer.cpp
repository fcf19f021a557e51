// Skins a cube of particles with the installed library.

#include "mesh/mesh_measure.h"
#include "skin/pipeline.h"

#include <iostream>

int main() {
    betamesh::Particles particles;
    for (int i = 0; i < 1000; ++i) {
        particles.position.emplace_back(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10),
                                        static_cast<float>(i / 100));
    }
    betamesh::SkinParams params;
    params.radius = 1.5;
    const betamesh::SkinnedFrame frame = betamesh::skinFrame(particles, params);
    const double volume = betamesh::measureMesh(frame.mesh).volume;
    std::cout << frame.mesh.triangles.size() << " triangles, volume " << volume << '\n';
    return volume > 9 * 9 * 9 && volume < 12 * 12 * 12 ? 0 : 1;
}
