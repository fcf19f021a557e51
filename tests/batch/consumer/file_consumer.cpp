// Meshes a cube of particles and writes it to a file with the installed component io.

#include <betamesh/io.h>
#include <betamesh/skin.h>

int main() {
    betamesh::Particles particles;
    for (int i = 0; i < 1000; ++i) {
        particles.position.emplace_back(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10),
                                        static_cast<float>(i / 100));
    }
    betamesh::writeParticles("consumer_particles.bgeo", particles);
    betamesh::SkinParams params;
    params.radius = 1.5;
    const betamesh::Mesh mesh = betamesh::skinFrame(betamesh::readParticles("consumer_particles.bgeo"), params).mesh;
    betamesh::writeMesh("consumer.ply", mesh);
    return betamesh::readMesh("consumer.ply").triangles == mesh.triangles ? 0 : 1;
}
