#include "skin/skin_frame.h"

#include "core/error.h"
#include "skin/alpha_mesh.h"
#include "skin/arc_points.h"
#include "skin/ball_boundary.h"
#include "skin/ball_faces.h"
#include "skin/boundary_samples.h"
#include "skin/complete_mesh.h"
#include "skin/face_points.h"
#include "skin/paper_mesh.h"
#include "skin/smooth_coherent.h"
#include "skin/smooth_paper.h"
#include "skin/survivors.h"
#include "skin/union_mesh.h"
#include "skin/velocity.h"

#include <algorithm>

namespace betamesh {

namespace {

constexpr double kSampleAngle = 0.56;    // radians between samples of wide faces of the paper's tessellation
constexpr double kSmoothingWidth = 2.8;  // radii
constexpr double kArcAngle = 0.75;  // of a common arc, radians: a segment of it is as long as face points are apart
constexpr double kLeastAngle = 0.05, kLargestAngle = 0.7;

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

// Coherent smoothing of either tessellation; the network is that of the samples.
void smooth(const Structure& structure, const std::vector<Moving>& balls, const std::vector<Vec3>& spins,
            const ArcNetwork& network, const FacePoints& points, const SkinParams& params, BetaMesh& mesh) {
    const double width = params.smoothing_width > 0 ? params.smoothing_width : kSmoothingWidth * params.radius;
    smoothCoherently(mesh, boundarySamples(structure.boundary, balls, spins, network, points),
                     {params.radius, width, params.passes});
}

BetaMesh completeSurface(const Particles& particles, const Structure& structure, const std::vector<Moving>& balls,
                         const SkinParams& params, const Watch& watch) {
    const BallBoundary& boundary = structure.boundary;
    const bool smoothed = params.smoothing == SmoothingMethod::coherent && params.passes > 0;
    ArcSubdivision subdivision;
    subdivision.segments = params.arc_subdivisions;
    subdivision.appearance = smoothed ? Appearance::gradual : Appearance::on_boundary;
    const double angle = params.arc_subdivisions > 0
                             ? std::clamp(kArcAngle / params.arc_subdivisions, kLeastAngle, kLargestAngle)
                             : subdivision.max_angle;
    const std::vector<Vec3> spins = spinsOfBalls(boundary, balls, particles);
    std::vector<Moving> vertices = movingVertices(particles, structure.snapped, boundary, balls);
    watch("velocity");
    const ArcNetwork network = arcPoints(boundary, balls, spins, std::move(vertices), subdivision);
    const FacePoints points = facePoints(structure.snapped, boundary, balls, spins, angle);
    BetaMesh beta = completeTessellation(boundary, balls, spins, network, points, subdivision.appearance);
    watch("tessellate");
    if (smoothed) smooth(structure, balls, spins, network, points, params, beta);
    watch("smooth");
    if (!particles.velocity.empty()) slideWithParticles(boundary, balls, beta);
    watch("velocity");
    return beta;
}

PaperMesh paperSurface(const Particles& particles, const Structure& structure, const std::vector<Moving>& balls,
                       const SkinParams& params, const Watch& watch) {
    const std::vector<Moving> vertices = movingVertices(particles, structure.snapped, structure.boundary, balls);
    watch("velocity");
    PaperMesh beta = paperTessellation(structure.boundary, balls, vertices);
    watch("tessellate");
    if (params.smoothing == SmoothingMethod::paper) smoothAsInPaper(beta, params.passes);
    if (params.smoothing == SmoothingMethod::coherent) {
        const std::vector<Vec3> spins = spinsOfBalls(structure.boundary, balls, particles);
        smooth(structure, balls, spins, arcPoints(structure.boundary, balls, spins, vertices, {}),
               facePoints(structure.snapped, structure.boundary, balls, spins, kSampleAngle), params, beta);
    }
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
    if (params.surface == SurfaceKind::beta && params.tessellation != Tessellation::paper &&
        params.smoothing == SmoothingMethod::paper)
        throw Error("the paper's smoothing averages over the fans of its own tessellation, expected that one");
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
            if (params.tessellation == Tessellation::complete) {
                frame.mesh = asMesh(completeSurface(particles, structure, balls, params, watch));
            } else {
                frame.mesh = asMesh(paperSurface(particles, structure, balls, params, watch));
                frame.spheres = externalSpheres(structure.boundary, particles);
            }
            break;
    }
    if (particles.velocity.empty()) frame.mesh.velocity.clear();
    watch("tessellate");
    return frame;
}

}  // namespace betamesh
