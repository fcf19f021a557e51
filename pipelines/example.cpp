// Makes particles, computes their surface and prints what it encloses. Build it against the installed library:
//
//   find_package(betamesh 0.2 REQUIRED)
//   add_executable(example example.cpp)
//   target_link_libraries(example PRIVATE betamesh::betamesh)

#include <betamesh/betamesh.h>

#include <iostream>

int main() try {
    const double dx = 0.1;  // particle spacing, world units
    betamesh::Particles particles;
    for (float x = -10; x <= 10; ++x)
        for (float y = -10; y <= 10; ++y)
            for (float z = -10; z <= 10; ++z)
                if (x * x + y * y + z * z < 100)  // a ball with a radius of 10 dx
                    particles.position.push_back(betamesh::Vec3f(x, y, z) * static_cast<float>(dx));
    betamesh::validate(particles);

    betamesh::SkinParams params;
    params.radius = 1.5 * dx;
    const betamesh::Mesh mesh = betamesh::skinFrame(particles, params).mesh;

    const betamesh::MeshCheck check = betamesh::checkMesh(mesh);
    std::cout << particles.size() << " particles, " << mesh.triangles.size() << " triangles, volume " << check.volume
              << " (dx cubed times particles: " << dx * dx * dx * static_cast<double>(particles.size()) << ")\n";
    for (const std::string_view fault : betamesh::faultsOf(check)) std::cout << "fault: " << fault << '\n';
    return betamesh::faultsOf(check).empty() ? 0 : 1;
} catch (const betamesh::Error& error) {
    std::cerr << "example: " << error.what() << '\n';
    return 1;
}
