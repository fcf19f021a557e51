// Uses every part of the installed core library: skin in space and in a plane, check, coherence, version, errors.

#include <betamesh/betamesh.h>

#include <iostream>
#include <string>

namespace {

int failures = 0;

void expect(bool holds, const char* what) {
    if (holds) return;
    std::cout << "failed: " << what << '\n';
    ++failures;
}

betamesh::Particles block(int width, int height) {
    betamesh::Particles particles;
    for (int i = 0; i < width * width * height; ++i) {
        particles.position.emplace_back(static_cast<float>(i % width), static_cast<float>(i / width % width),
                                        static_cast<float>(i / (width * width)));
        particles.velocity.emplace_back(1.0f, 0.0f, 0.0f);
    }
    return particles;
}

}  // namespace

int main() {
    const betamesh::Particles particles = block(8, 8);
    betamesh::validate(particles);
    betamesh::SkinParams params;
    params.radius = 1.5;
    int stages = 0;
    const betamesh::SkinnedFrame frame = betamesh::skinFrame(particles, params, [&](betamesh::Stage) { ++stages; });
    expect(stages == 4, "the four stages of a frame are announced");
    expect(frame.mesh.velocity.size() == frame.mesh.position.size(), "the mesh has velocities");

    const betamesh::MeshCheck check = betamesh::checkMesh(frame.mesh);
    expect(betamesh::faultsOf(check, true).empty(), "the mesh is valid");
    expect(check.volume > 7 * 7 * 7 && check.volume < 10 * 10 * 10, "the mesh encloses the block");
    expect(betamesh::measureMesh(frame.mesh).euler == 2, "the mesh is a sphere");

    const betamesh::Particles later = betamesh::advected(particles, 0.5);
    expect(betamesh::particleMotion(particles, later)->max == 0.5, "the particles move by half a unit");
    const betamesh::SurfaceDistance distance =
        betamesh::surfaceDistance(frame.mesh, betamesh::skinFrame(later, params).mesh);
    expect(distance.max > 0.45 && distance.max < 0.55, "the surface moves with the particles");

    const betamesh::SkinnedPlane plane = betamesh::skinPlane(block(8, 1), params);
    expect(betamesh::faultsOf(betamesh::checkCurves(plane.curves, {}), true).empty(), "the curves are valid");
    expect(betamesh::linesOf(plane.curves).size() == 1, "one curve surrounds the square");

    try {
        params.skin = 2;  // beyond the radius
        betamesh::skinFrame(particles, params);
        expect(false, "a skin beyond the radius is refused");
    } catch (const betamesh::Error& error) {
        expect(std::string(error.what()).find("skin") != std::string::npos, "the error names the skin");
    }
    expect(betamesh::version() == std::string(BETAMESH_VERSION), "headers and library have the same version");
    expect(betamesh::version() == std::to_string(BETAMESH_VERSION_MAJOR) + '.' +
                                      std::to_string(BETAMESH_VERSION_MINOR) + '.' +
                                      std::to_string(BETAMESH_VERSION_PATCH),
           "the version has three parts");
    std::cout << "betamesh " << betamesh::version() << ": " << failures << " failures\n";
    return failures == 0 ? 0 : 1;
}
