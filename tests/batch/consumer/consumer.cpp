// Meshes a cube of particles with the installed libraries and writes it to a file.

#include "io/mesh_file.h"
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
    betamesh::writeMesh("consumer.ply", frame.mesh);
    std::cout << frame.mesh.triangles.size() << " triangles, volume " << volume << '\n';
    return volume > 9 * 9 * 9 && volume < 12 * 12 * 12 ? 0 : 1;
}
