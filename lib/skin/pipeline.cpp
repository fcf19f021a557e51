
#include "skin/pipeline.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "mesh/mesh_edges.h"
#include "skin/alpha_mesh.h"
#include "skin/arcs.h"
#include "skin/attributes.h"
#include "skin/ball_boundary.h"
#include "skin/ball_faces.h"
#include "skin/boundary_samples.h"
#include "skin/droplets.h"
#include "skin/exposure_candidates.h"
#include "skin/face_points.h"
#include "skin/features.h"
#include "skin/limit_velocities.h"
#include "skin/near_surface.h"
#include "skin/outer_boundary.h"
#include "skin/paper_mesh.h"
#include "skin/retract.h"
#include "skin/self_intersections.h"
#include "skin/skin_smoothing.h"
#include "skin/smooth_coherent.h"
#include "skin/smooth_paper.h"
#include "skin/tessellate.h"
#include "skin/union_mesh.h"
#include "skin/velocity.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

constexpr double kSampleAngle = 0.56;    // radians between samples of wide faces of the paper's tessellation
constexpr double kSmoothingWidth = 2.8;  // radii
constexpr double kArcAngle = 0.75;  // of a common arc, radians: a segment of it is as long as face points are apart
constexpr double kSmoothedAngle = 0.235;     // radians per segment of what is smoothed: small jumps where balls meet
constexpr double kFlatAngle = 0.4;           // round small patches of balls, where jumps are smaller
constexpr double kSmoothedFaceAngle = 0.37;  // between points inside faces of the same
constexpr double kSkinAngle = 0.6, kSkinFlatAngle = 0.7, kSkinFaceAngle = 0.55;  // the same where there is a skin
constexpr double kCoarser = 1.5;  // edges of the skin, where arcs are one segment
constexpr double kFarthestSmoothed = 0.9;  // of the skin: no vertex gets past a particle
constexpr int kLoosenings = 6;
constexpr double kLeastAngle = 0.05, kLargestAngle = 0.7;

struct Structure {
    SnappedParticles snapped;  // without what left as a feature
    BallBoundary boundary;
    Spheres apart;  // what left, and is to be kept
    std::size_t distinct_particles = 0;
    LeftOut left_out;
    std::size_t tendril_particles = 0;
    int retries = 0;
};

std::string describe(const Particles& particles, std::uint32_t row) {
    const Vec3f& p = particles.position[row];
    return "particle " + std::to_string(row) + " (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
           std::to_string(p.z) + ")";
}

// Particles -> the boundary of those that are to be meshed; boundaryOf tells why there is none, if so.
template <typename BoundaryOf>
std::optional<UnpairedEdge> buildStructure(const Particles& particles, const SkinParams& params,
                                           SnappedParticles&& snapped, const BoundaryOf& boundaryOf,
                                           const std::vector<Vec3>& directions, Structure& structure) {
    structure = {};
    structure.snapped = std::move(snapped);
    structure.distinct_particles = structure.snapped.size();
    structure.left_out = leaveOutDroplets(particles, params.features, structure.snapped, structure.apart);
    for (;;) {
        std::variant<BallBoundary, UnpairedEdge> built =
            boundaryOf(structure.snapped, exposureCandidates(structure.snapped), directions);
        if (const auto* unpaired = std::get_if<UnpairedEdge>(&built)) return *unpaired;
        structure.boundary = std::move(std::get<BallBoundary>(built));
        if (params.features.tendrils == Tendrils::mesh) return std::nullopt;
        // Without them the alpha mesh gains triangles at most, and rarely a new tendril: look again.
        const std::vector<std::uint32_t> tendrils = tendrilParticles(structure.boundary);
        if (tendrils.empty()) return std::nullopt;
        addSpheres(particles, structure.snapped, tendrils, structure.apart);
        structure.tendril_particles += tendrils.size();
        structure.snapped = without(structure.snapped, tendrils);
    }
}

Structure exactStructure(const Particles& particles, const NearSurface& near, const SkinParams& params,
                         const std::vector<Vec3>& directions) {
    const auto boundaryOf = [&](const SnappedParticles& snapped, const std::vector<std::uint32_t>& exposed,
                                const std::vector<Vec3>& towards) {
        return ballBoundary(snapped, exposed, towards,
                            params.surface == SurfaceKind::alpha ? Arcs::left_out : Arcs::traced);
    };
    Structure structure;
    buildStructure(particles, params, snapParticles(particles, params.radius, near), boundaryOf, directions, structure);
    return structure;
}

// The paper's way: test in floats, validate by counting edges, perturb and run again.
Structure floatStructure(const Particles& particles, const SkinParams& params, const std::vector<Vec3>& directions) {
    for (int attempt = 0;; ++attempt) {
        Structure structure;
        const auto edge = buildStructure(particles, params,
                                         snapParticles(particles, params.radius, Jitter{params.tolerance, attempt}),
                                         ballBoundaryInFloats, directions, structure);
        structure.retries = attempt;
        if (!edge) return structure;
        if (attempt >= params.retries)
            throw Error("floating-point predicates left the alpha mesh open after " + std::to_string(params.retries) +
                        " retries: the edge from " + describe(particles, edge->from) + " to " +
                        describe(particles, edge->to) + " " + std::string(edge->fault) +
                        "; expected every oriented edge to have one opposite. Use exact "
                        "predicates, more retries or a larger tolerance");
    }
}

// Of coherent smoothing.
int passesOf(const SkinParams& params) { return params.smoothing == SmoothingMethod::coherent ? params.passes : 0; }

double widthOf(const SkinParams& params) {
    return params.smoothing_width > 0 ? params.smoothing_width : kSmoothingWidth * params.radius;
}

// Of either tessellation.
CoherentSmoothing smoothingOf(const SkinParams& params) {
    return {params.radius, widthOf(params), passesOf(params), params.inset};
}

bool hasSkin(const SkinParams& params) { return skinDepth(params) > 0; }

bool isSmoothed(const SkinParams& params) { return passesOf(params) > 0 || params.inset > 0 || hasSkin(params); }

// In which there are points inside faces, or samples of them; none where these are not asked for.
Icosphere directionsOf(const SkinParams& params) {
    if (params.surface != SurfaceKind::beta) return {};
    if (params.tessellation == Tessellation::paper) return isSmoothed(params) ? icosphereOf(kSampleAngle) : Icosphere();
    return icosphereOf(params.arc_subdivisions > 0
                           ? std::clamp(kArcAngle / params.arc_subdivisions, kLeastAngle, kLargestAngle)
                       : isSmoothed(params) ? hasSkin(params) ? kSkinFaceAngle : kSmoothedFaceAngle
                                            : ArcSubdivision().max_angle);
}

SkinLengths lengthsOf(const SkinParams& params) {
    const double spacing = particleSpacing(params);
    return {params.radius / spacing, leastSkin(params) / spacing, !params.skin,
            params.arc_subdivisions == 1 ? kCoarser : 1};
}

// Takes the vertices of the boundary of the union of balls to the skin, and smooths it.
void giveSkin(const OuterSamples& outer, const BallBoundary& boundary, const SkinParams& params, BetaMesh& mesh) {
    std::exchange(mesh.rim_distance, {});  // large, and of no more use
    const double spacing = particleSpacing(params);
    DeformingMesh surface(mesh, spacing);
    retract(outer, lengthsOf(params), surface);
    const DualPoints on_balls = copyOf(mesh.vertex);
    surface.writePositions();
    if (passesOf(params) > 0) {
        const DualPoints retracted = copyOf(mesh.vertex);
        smoothSkin(surface, params.smoothing_width > 0 ? params.smoothing_width / spacing : kWidestFit,
                   kFarthestSmoothed * leastSkin(params) / spacing, passesOf(params));
        surface.writePositions();
        if (resolveSelfIntersections(boundary, retracted, mesh, kLoosenings, false)) return;
    }
    resolveSelfIntersections(boundary, on_balls, mesh, kLoosenings);
}

// Of the structure only the boundary is left, without exposed directions.
BetaMesh completeSurface(const Particles& particles, Structure& structure, const std::vector<DualVec3>& balls,
                         Icosphere&& directions, const SkinParams& params, const Watch& watch, SkinReport& report) {
    const BallBoundary& boundary = structure.boundary;
    const bool smoothed = isSmoothed(params), has_skin = hasSkin(params);
    ArcSubdivision subdivision;
    subdivision.segments = params.arc_subdivisions;
    if (smoothed) {
        subdivision.appearance = Appearance::gradual;
        subdivision.max_angle = has_skin ? kSkinAngle : kSmoothedAngle;
        subdivision.moves_far = has_skin;
        if (has_skin)
            subdivision.flat_angle = kSkinFlatAngle;
        else if (passesOf(params) > 0 && widthOf(params) >= kSmoothingWidth * params.radius)
            subdivision.flat_angle = kFlatAngle;
    }
    std::vector<DualVec3> vertices = boundaryVertices(particles, structure.snapped, boundary, balls);
    watch("velocity");
    ArcNetwork network = arcPoints(boundary, balls, std::move(vertices), subdivision);
    FacePoints points = facePoints(structure.snapped, boundary, balls, std::move(directions));
    OuterSamples outer =
        has_skin ? outerSamples(particles, structure.snapped, boundary,
                                lengthsOf(params).outer() * particleSpacing(params), particleSpacing(params))
                 : OuterSamples();
    std::exchange(structure.snapped, {});  // large, and of no more use
    std::exchange(structure.boundary.exposed, {});
    watch("tessellate");
    std::optional<CoherentSmoother> smoother;
    if (smoothed && !has_skin)
        smoother.emplace(boundarySamples(boundary, balls, network, points), smoothingOf(params));
    watch("smooth");
    BetaMesh beta = completeTessellation(boundary, balls, std::move(network), std::move(points),
                                         subdivision);
    if (params.features.bubbles == Bubbles::fill)  // before smoothing: small bubbles may be turned inside out by it
        report.bubbles_filled = fillBubbles(beta, boundary, params.features);
    watch("tessellate");
    if (has_skin) {
        giveSkin(outer, boundary, params, beta);
    } else {
        const DualPoints from = smoother ? smoother->smooth(beta) : copyOf(beta.vertex);
        smoother.reset();
        std::exchange(beta.rim_distance, {});  // large, and of no more use
        resolveSelfIntersections(boundary, from, beta);
    }
    watch("smooth");
    if (!particles.velocity.empty())
        limitVelocities(balls, liquidReach(params), vertexNormals(beta), beta.vertex);
    watch("velocity");
    return beta;
}

PaperMesh paperSurface(const Particles& particles, const Structure& structure, const std::vector<DualVec3>& balls,
                       Icosphere&& directions, const SkinParams& params, const Watch& watch) {
    const std::vector<DualVec3> vertices = boundaryVertices(particles, structure.snapped, structure.boundary, balls);
    watch("velocity");
    PaperMesh beta = paperTessellation(structure.boundary, balls, vertices);
    watch("tessellate");
    if (params.smoothing == SmoothingMethod::paper) smoothAsInPaper(beta, params.passes);
    if (params.smoothing != SmoothingMethod::paper && isSmoothed(params)) {
        CoherentSmoother smoother(
            boundarySamples(structure.boundary, balls, arcPoints(structure.boundary, balls, vertices, {}),
                            facePoints(structure.snapped, structure.boundary, balls, std::move(directions))),
            smoothingOf(params));
        smoother.smooth(beta);
    }
    if (params.resolve_intersections) resolveIntersections(structure.boundary, balls, beta);
    watch("smooth");
    return beta;
}

void append(const Spheres& from, Spheres& to) {
    const auto add = [](const auto& more, auto& all) { all.insert(all.end(), more.begin(), more.end()); };
    add(from.position, to.position);
    add(from.velocity, to.velocity);
    add(from.radius, to.radius);
    add(from.id, to.id);
}

void count(const NearSurface& near, const Structure& structure, SkinReport& report) {
    const BallBoundary& boundary = structure.boundary;
    report.particles = near.particles;
    report.distinct_particles = structure.distinct_particles + near.leftOut();
    report.droplets = structure.left_out.droplets;
    report.droplet_particles = structure.left_out.particles;
    report.tendril_particles = structure.tendril_particles;
    report.alpha_triangles = boundary.triangle.size();
    report.double_sided_triangles = doubleSidedTriangles(boundary);
    report.degenerate_edges = boundary.circle.size();
    report.isolated_particles = boundary.isolated.size();
    report.alpha_vertices = verticesOf(boundary.triangle, boundary.position.size()).size();
    report.perturbation_retries = structure.retries;
}

}  // namespace

SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch) {
    NearSurfaceFinder finder(params);
    finder.add(particles.position);
    return skinFrame(particles, finder.find(), params, watch);
}

SkinnedFrame skinFrame(const Particles& particles, const NearSurface& near, const SkinParams& params,
                       const Watch& watch_or_none) {
    const Watch watch = watch_or_none ? watch_or_none : [](std::string_view) {};
    if (params.surface == SurfaceKind::beta && params.tessellation != Tessellation::paper &&
        params.smoothing == SmoothingMethod::paper)
        throw Error("the paper's smoothing averages over the fans of its own tessellation, expected that one");
    const bool complete = params.surface == SurfaceKind::beta && params.tessellation == Tessellation::complete;
    if (params.features.bubbles == Bubbles::fill && !complete)
        throw Error("only the complete tessellation has bubbles that can be filled, expected that one");
    requireSkin(params);
    SkinnedFrame frame;

    Icosphere directions = directionsOf(params);
    Structure structure = params.predicates == PredicateKind::exact
                              ? exactStructure(particles, near, params, directions.position)
                              : floatStructure(particles, params, directions.position);
    if (complete) groupFaces(structure.snapped, structure.boundary);
    count(near, structure, frame.report);
    watch("structure");

    frame.spheres = std::move(structure.apart);
    const std::vector<DualVec3> balls = ballCentres(structure.boundary, particles);
    switch (params.surface) {
        case SurfaceKind::alpha:
            frame.mesh = alphaMesh(structure.boundary, balls);
            break;
        case SurfaceKind::union_:
            frame.mesh = unionOfBalls(structure.snapped, structure.boundary, balls);
            break;
        case SurfaceKind::beta:
            if (complete) {
                frame.mesh = asMesh(
                    completeSurface(particles, structure, balls, std::move(directions), params, watch, frame.report));
            } else {
                frame.mesh = asMesh(paperSurface(particles, structure, balls, std::move(directions), params, watch));
                append(externalSpheres(structure.boundary, particles), frame.spheres);
            }
            break;
    }
    if (particles.velocity.empty()) frame.mesh.velocity.clear();
    frame.mesh.attributes = carriedAttributes(particles, structure.boundary.row, balls,
                                              structure.boundary.worldRadius(), params.attributes, frame.mesh.position);
    if (params.components) labelComponents(frame.mesh);
    watch("tessellate");
    return frame;
}

}  // namespace betamesh
