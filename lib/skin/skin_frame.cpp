#include "skin/skin_frame.h"

#include "core/error.h"
#include "measure/mesh_measure.h"
#include "skin/alpha_mesh.h"
#include "skin/ball_boundary.h"
#include "skin/ball_faces.h"
#include "skin/paper_mesh.h"
#include "skin/smooth.h"
#include "skin/survivors.h"
#include "skin/union_mesh.h"
#include "skin/velocity.h"

namespace betamesh {

namespace {

struct Structure {
    SnappedParticles snapped;
    BallBoundary boundary;
    int retries = 0;
};

std::string describe(const Particles& particles, std::uint32_t row) {
    const Vec3f& p = particles.position[row];
    return "particle " + std::to_string(row) + " (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
           std::to_string(p.z) + ")";
}

Structure exactStructure(const Particles& particles, const SkinParams& params) {
    Structure structure;
    structure.snapped = snapParticles(particles, params.radius);
    structure.boundary = ballBoundary(structure.snapped, survivors(structure.snapped));
    return structure;
}

// The paper's way: test in floats, validate by counting edges, perturb and run again.
Structure floatStructure(const Particles& particles, const SkinParams& params) {
    for (int attempt = 0;; ++attempt) {
        Structure structure;
        structure.snapped = snapParticles(particles, params.radius, {params.tolerance, attempt});
        auto built = ballBoundaryInFloats(structure.snapped, survivors(structure.snapped));
        if (auto* boundary = std::get_if<BallBoundary>(&built)) {
            structure.boundary = std::move(*boundary);
            structure.retries = attempt;
            return structure;
        }
        if (attempt >= params.retries) {
            const auto edge = std::get<UnpairedEdge>(built);
            throw Error("floating-point predicates left the alpha mesh open after " + std::to_string(params.retries) +
                        " retries: the edge from " + describe(particles, edge.from) + " to " +
                        describe(particles, edge.to) + " " + std::string(edge.fault) +
                        "; expected every oriented edge to have one opposite. Use exact "
                        "predicates, more retries or a larger tolerance");
        }
    }
}

PaperMesh betaSurface(const Particles& particles, const Structure& structure, const std::vector<Moving>& balls,
                     const SkinParams& params, const Watch& watch) {
    const std::vector<Moving> vertices = movingVertices(particles, structure.snapped, structure.boundary, balls);
    watch("velocity");
    PaperMesh beta = paperTessellation(structure.boundary, balls, vertices);
    watch("tessellate");
    if (params.smoothing == SmoothingMethod::paper) smoothAsInPaper(beta, params.passes);
    if (params.resolve_intersections) resolveIntersections(structure.boundary, balls, beta);
    watch("smooth");
    return beta;
}

void count(const Particles& particles, const Structure& structure, SkinReport& report) {
    const BallBoundary& boundary = structure.boundary;
    report.particles = particles.size();
    report.distinct_particles = structure.snapped.size();
    report.alpha_triangles = boundary.triangle.size();
    report.double_sided_triangles = doubleSidedTriangles(boundary);
    report.degenerate_edges = boundary.circle.size();
    report.isolated_particles = boundary.bare.size();
    std::vector<bool> used(boundary.position.size(), false);
    for (const Triangle& t : boundary.triangle)
        for (const std::uint32_t ball : t) {
            report.alpha_vertices += !used[ball];
            used[ball] = true;
        }
    report.perturbation_retries = structure.retries;
}

}  // namespace

SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch_or_none) {
    const Watch watch = watch_or_none ? watch_or_none : [](std::string_view) {};
    SkinnedFrame frame;

    Structure structure = params.predicates == PredicateKind::exact ? exactStructure(particles, params)
                                                                    : floatStructure(particles, params);
    groupFaces(structure.snapped, structure.boundary);
    count(particles, structure, frame.report);
    watch("structure");

    const std::vector<Moving> balls = movingBalls(structure.boundary, particles);
    switch (params.surface) {
        case SurfaceKind::alpha:
            frame.mesh = alphaMesh(structure.boundary, balls);
            break;
        case SurfaceKind::union_:
            frame.mesh = unionOfBalls(structure.snapped, structure.boundary, balls);
            break;
        case SurfaceKind::beta:
            frame.mesh = asMesh(betaSurface(particles, structure, balls, params, watch));
            frame.spheres = externalSpheres(structure.boundary, particles);
            break;
    }
    if (particles.velocity.empty()) frame.mesh.velocity.clear();
    watch("tessellate");

    const MeshMeasure measure = measureMesh(frame.mesh);
    frame.report.components = measure.components;
    frame.report.euler = measure.euler;
    frame.report.volume = measure.volume;
    frame.report.area = measure.area;
    watch("measure");
    return frame;
}

}  // namespace betamesh
