#include "skin/pipeline.h"

#include "mesh/clip_mesh.h"
#include "mesh/mesh_edges.h"
#include "skin/alpha_mesh.h"
#include "skin/attributes.h"
#include "skin/boundary_samples.h"
#include "skin/constants.h"
#include "skin/faces.h"
#include "skin/features.h"
#include "skin/keep_inside.h"
#include "skin/limit_velocities.h"
#include "skin/meetings.h"
#include "skin/merge_vertices.h"
#include "skin/narrow_gaps.h"
#include "skin/outer_boundary.h"
#include "skin/paper_mesh.h"
#include "skin/pinholes.h"
#include "skin/self_intersections.h"
#include "skin/skin_smoothing.h"
#include "skin/smooth_paper.h"
#include "skin/stage_settings.h"
#include "skin/structure.h"
#include "skin/surface_attributes.h"
#include "skin/tessellate.h"
#include "skin/unfold.h"
#include "skin/union_mesh.h"
#include "skin/velocity.h"
#include "skin/voids.h"
#include "skin/walls.h"

#include <array>
#include <iterator>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

// The tessellated union of balls, and samples for what moves its vertices.
struct BaseSurface {
    BetaMesh mesh;
    OuterSamples outer;                        // of a surface with a skin
    ParticlesAtRisk at_risk;                   // likewise
    std::vector<Meeting> meetings;             // likewise
    std::optional<CoherentSmoother> smoother;  // of one without, if it is smoothed
};

// Releases those parts of the structure that nothing needs afterwards.
BaseSurface baseSurface(const Particles& particles, Structure& structure, const std::vector<DualVec3>& balls,
                        const SkinParams& params, SkinReport& report) {
    const BallBoundary& boundary = structure.boundary;
    const ArcSubdivision subdivision = arcSubdivision(params);
    BaseSurface base;
    ArcNetwork network =
        arcPoints(boundary, balls, boundaryVertices(particles, structure.snapped, boundary, balls), subdivision);
    FacePoints points = facePoints(structure.snapped, boundary, balls, std::move(structure.directions));
    if (hasSkin(params)) {
        const double spacing = particleSpacing(params);
        base.outer = outerSamples(particles, structure.snapped, boundary, skinLengths(params), spacing);
        addNarrowGaps(boundary, balls, network, points, skinLengths(params), spacing, base.outer);
        base.meetings = meetings(boundary, network, points, spacing);
        base.at_risk = particlesAtRisk(structure.snapped, effectiveSkinDepth(params), facetsMayCutOffParticles(params));
    }
    std::exchange(structure.snapped, {});  // large
    std::exchange(structure.boundary.exposed, {});
    if (isSmoothed(params) && !hasSkin(params))
        base.smoother.emplace(boundarySamples(boundary, balls, network, points), coherentSmoothing(params));
    base.mesh = completeTessellation(boundary, balls, std::move(network), std::move(points), subdivision);
    if (params.features.bubbles == Bubbles::fill)  // before smoothing, which may turn small bubbles inside out
        report.bubbles_filled = fillBubbles(base.mesh, boundary, params.features, structure.reference_radius);
    return base;
}

// Moves the vertices to the skin and smooths it. Returns how many pairs of triangles still cross.
std::size_t moveToSkin(const BaseSurface& base, const BallBoundary& boundary, const SkinParams& params,
                       BetaMesh& mesh) {
    DeformingMesh surface(mesh, particleSpacing(params));
    const SkinLengths lengths = skinLengths(params);
    retract(base.outer, lengths, surface);
    DualPoints on_balls = dualPoints(mesh.vertex);
    std::optional<DualPoints> retracted;
    if (coherentPasses(params) > 0) {
        surface.writePositions();
        retracted = dualPoints(mesh.vertex);
        smoothSkin(surface, widestSkinFit(params), farthestSkinSmoothing(params), coherentPasses(params),
                   lengths.isCoarse());
    }
    const std::vector<Vec3>& before_smoothing = retracted ? retracted->position : surface.position();
    const std::vector<float> kept = keepMeetings(base.meetings, before_smoothing, surface);
    if (retracted) {
        if (!lengths.isCoarse()) surface.fairSharpParts(kept);  // drops of coarse triangles would shrink
        narrowPinholes(boundary, surface);
        limitDisplacements(surface, retracted->position, farthestSkinSmoothing(params));
    }
    if (!lengths.isCoarse()) surface.refineOnCurves(lengths.joining);
    surface.writePositions();
    addLastRefinement(mesh.fading, on_balls);
    if (retracted) addLastRefinement(mesh.fading, *retracted);
    InsideKeeper particles(base.at_risk, particleSpacing(params), mesh);
    particles.raise();
    const auto resolve = [&](const DualPoints& from, bool is_last) {
        return resolveSelfIntersections(boundary, from, mesh, true, is_last);
    };
    std::size_t crossings = retracted ? resolve(*retracted, false) : 0;
    if (!retracted || crossings > 0) crossings = resolve(on_balls, true);
    for (int round = 0; round < kMaxRestorations && particles.restore(on_balls); ++round)
        crossings = resolve(on_balls, true);
    const double depth = effectiveSkinDepth(params) / particleSpacing(params);
    unfold(surface.normals(), surface.spacing(), std::min(kMaxDiagonalDistance, kMaxDiagonalShare * depth), mesh);
    return crossings;
}

BetaMesh smoothedSurface(BaseSurface&& base, const BallBoundary& boundary, const SkinParams& params,
                         SkinReport& report) {
    BetaMesh mesh = std::move(base.mesh);
    if (hasSkin(params)) {
        std::exchange(mesh.rim_distance, {});  // large
        report.crossings = moveToSkin(base, boundary, params, mesh);
        std::exchange(base.outer, {});
        mergeCoincidentVertices(mesh);
        return mesh;
    }
    const DualPoints from = base.smoother ? base.smoother->smooth(mesh) : dualPoints(mesh.vertex);
    base.smoother.reset();
    std::exchange(mesh.rim_distance, {});  // large
    report.crossings = resolveSelfIntersections(boundary, from, mesh);
    mergeCoincidentVertices(mesh);
    return mesh;
}

std::vector<Attribute> measuredAttributes(const BetaMesh& mesh, const SkinParams& params) {
    if (params.surface_attributes == SurfaceAttributes{}) return {};
    return surfaceAttributes(mesh, particleSpacing(params), params.surface_attributes);
}

// The scales of the vertices that triangles use, which are those of the plain mesh.
std::vector<float> scalesOfUsed(const BetaMesh& mesh) {
    std::vector<float> scale;
    if (!mesh.scale.empty())
        for (const std::uint32_t v : verticesOf(mesh.triangles, mesh.vertex.size())) scale.push_back(mesh.scale[v]);
    return scale;
}

// The surface of the complete tessellation, with its measured attributes, and the local scale at each vertex.
Mesh completeSurface(const Particles& particles, Structure& structure, const std::vector<DualVec3>& balls,
                     const SkinParams& params, const Watch& watch, SkinReport& report, std::vector<float>& scale) {
    const BallBoundary& boundary = structure.boundary;
    BaseSurface base = baseSurface(particles, structure, balls, params, report);
    watch(Stage::tessellate);
    BetaMesh surface = smoothedSurface(std::move(base), boundary, params, report);
    watch(Stage::smooth);
    if (!particles.velocity.empty())
        limitVelocities(boundary, balls, motionReach(params), vertexNormals(surface), surface);
    if (!params.walls.empty())
        report.crossings +=  // what has not moved is not compared again
            layAgainstWalls(params.walls, particleSpacing(params), boundary, surface);
    std::vector<Attribute> measured = measuredAttributes(surface, params);
    scale = scalesOfUsed(surface);
    Mesh mesh = asMesh(std::move(surface));
    mesh.attributes = std::move(measured);
    return mesh;
}

PaperMesh paperSurface(const Particles& particles, const Structure& structure, const std::vector<DualVec3>& balls,
                       const SkinParams& params, const Watch& watch) {
    const BallBoundary& boundary = structure.boundary;
    const std::vector<DualVec3> vertices = boundaryVertices(particles, structure.snapped, boundary, balls);
    PaperMesh mesh = paperTessellation(boundary, balls, vertices);
    watch(Stage::tessellate);
    if (params.smoothing == SmoothingMethod::paper) {
        smoothAsInPaper(mesh, params.passes);
    } else if (isSmoothed(params)) {
        CoherentSmoother smoother(
            boundarySamples(boundary, balls, arcPoints(boundary, balls, vertices, {}),
                            facePoints(structure.snapped, boundary, balls, Icosphere(structure.directions))),
            coherentSmoothing(params));
        smoother.smooth(mesh);
    }
    if (params.resolve_intersections) resolveIntersections(boundary, balls, mesh);
    watch(Stage::smooth);
    return mesh;
}

// The surfaces for comparison: the alpha mesh, the union of balls, and the paper's beta mesh.
Mesh comparisonSurface(const Particles& particles, const Structure& structure, const std::vector<DualVec3>& balls,
                       const SkinParams& params, const Watch& watch) {
    Mesh mesh;
    if (params.surface == SurfaceKind::beta) {
        mesh = asMesh(paperSurface(particles, structure, balls, params, watch));
    } else {
        mesh = params.surface == SurfaceKind::alpha ? alphaMesh(structure.boundary, balls)
                                                    : unionOfBalls(structure.snapped, structure.boundary, balls);
        watch(Stage::tessellate);
        watch(Stage::smooth);
    }
    mesh.attributes = measuredAttributes(asBetaMesh(mesh), params);
    return mesh;
}

void append(const Spheres& from, Spheres& to) {
    const auto add = [](const auto& more, auto& all) { all.insert(all.end(), more.begin(), more.end()); };
    add(from.position, to.position);
    add(from.velocity, to.velocity);
    add(from.radius, to.radius);
    add(from.id, to.id);
    add(from.particle, to.particle);
}

SkinReport reportOf(const NearSurface& near, const Structure& structure) {
    const BallBoundary& boundary = structure.boundary;
    SkinReport report;
    report.particles = near.particles;
    report.distinct_particles = structure.distinct_particles + near.omitted();
    report.droplets = structure.left_out.droplets;
    report.droplet_particles = structure.left_out.particles;
    report.tendril_particles = structure.tendril_particles;
    report.alpha_triangles = boundary.triangle.size();
    report.double_sided_triangles = doubleSidedTriangles(boundary);
    report.degenerate_edges = boundary.circle.size();
    report.isolated_particles = boundary.isolated.size();
    report.alpha_vertices = verticesOf(boundary.triangle, boundary.position.size()).size();
    report.perturbation_retries = structure.retries;
    return report;
}

}  // namespace

std::string_view nameOf(Stage stage) {
    constexpr std::array<std::string_view, kStages> kNames = {
        "read", "structure", "tessellate", "smooth", "velocity", "simplify", "measure", "picture", "write"};
    static_assert(!kNames.back().empty());
    return kNames[static_cast<std::size_t>(stage)];
}

SkinnedFrame skinFrame(const Particles& particles, const SkinParams& params, const Watch& watch) {
    requireAttributesNamed(particles, params.attributes);  // before stages that take long
    NearSurfaceFinder finder(params);
    finder.add(particles.position, particleSizes(particles, params).radius);
    return skinFrame(particles, finder.find(), params, watch);
}

SkinnedFrame skinFrame(const Particles& particles, const NearSurface& near, const SkinParams& given,
                       const Watch& watch_or_none) {
    requireConsistent(given);
    requireAttributesNamed(particles, given.attributes);
    const Watch watch = watch_or_none ? watch_or_none : [](Stage) {};
    const ParticleSizes sizes = particleSizes(particles, given);
    const SkinParams params = near.largest > 0 ? withRadius(given, near.largest) : given;

    Structure structure = exposedStructure(particles, near, params, sizes, faceDirections(params));
    structure.reference_radius = near.is_unequal ? given.radius : params.radius;
    if (isComplete(params)) groupFaces(structure.snapped, structure.boundary);
    SkinnedFrame frame{{}, std::move(structure.spheres), reportOf(near, structure)};
    const BallBoundary& boundary = structure.boundary;
    const std::vector<DualVec3> balls = ballCentres(boundary, particles);
    watch(Stage::structure);

    LocalRadii radii{boundary.worldRadius()};
    if (isComplete(params)) {
        frame.mesh = completeSurface(particles, structure, balls, params, watch, frame.report, radii.vertex_scale);
    } else {
        frame.mesh = comparisonSurface(particles, structure, balls, params, watch);
        if (params.surface == SurfaceKind::beta) append(externalSpheres(boundary, particles), frame.spheres);
    }
    if (particles.velocity.empty()) frame.mesh.velocity.clear();
    for (std::size_t b = 0; b < boundary.radius_of.size(); ++b)
        radii.ball_scale.push_back(static_cast<float>(boundary.scaleOf(b)));
    std::vector<Attribute> carried =
        carriedAttributes(particles, boundary.row, balls, radii, params.attributes, frame.mesh.position);
    std::move(carried.begin(), carried.end(), std::inserter(frame.mesh.attributes, frame.mesh.attributes.begin()));
    if (const auto box = clippingBox(params)) {
        frame.mesh = clippedToBox(frame.mesh, box->min, box->max);
        keepInside(box->min, box->max, frame.spheres);
    }
    frame.spheres.attributes = attributesOf(particles, frame.spheres.particle, params.attributes);
    if (params.components) labelComponents(frame.mesh);
    watch(Stage::velocity);
    return frame;
}

}  // namespace betamesh
