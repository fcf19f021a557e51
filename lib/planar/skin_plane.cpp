
#include "betamesh/skin.h"

#include "base/angles.h"
#include "base/cell_grid.h"
#include "base/parallel.h"
#include "betamesh/error.h"
#include "planar/boundary_curves.h"
#include "planar/curve_displacement.h"
#include "planar/disc_boundary.h"
#include "planar/gap_points.h"
#include "planar/keep_inside.h"
#include "planar/retract.h"
#include "planar/skin_smoothing.h"
#include "planar/smooth.h"
#include "planar/velocity.h"
#include "skin/attributes.h"
#include "skin/constants.h"
#include "skin/features.h"
#include "skin/particle_sizes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

constexpr double kCurveSmoothingWidth = 2.8;  // radii
constexpr int kDirections = 24;               // points of a circle: a sagitta of 0.009 radii
constexpr int kDirectionsPerSubdivision = 8;  // arcs between neighbours on a flat surface are about an eighth turn
constexpr double kSkinWidth = 5.4;            // spacings: radius of the widest fit that smooths a skin
constexpr double kLeastSkin = 0.05;           // radii: thinner skins would need neighbours a dozen radii away
constexpr double kMostSkins = 4;              // skins: largest unit of widths and steps
constexpr double kOuterSpacing = 0.1;         // spacings: distance of samples of the outer boundary

// The union of discs always has the complete tessellation.
bool usesPaperTessellation(const SkinParams& params) {
    return params.surface == SurfaceKind::beta && params.tessellation == Tessellation::paper;
}

BetaCurve tessellated(const DiscBoundary& boundary, const std::vector<DualVec3>& discs,
                      const std::vector<DualVec3>& vertices, const SkinParams& params) {
    if (usesPaperTessellation(params)) return paperCurve(boundary, vertices);
    const int directions =
        params.arc_subdivisions > 0 ? kDirectionsPerSubdivision * params.arc_subdivisions : kDirections;
    return completeCurve(boundary, discs, vertices, directions);
}

bool isSmoothedCoherently(const SkinParams& params) {
    return params.smoothing == SmoothingMethod::coherent && params.passes > 0;
}

// Distance between the curve and the outermost particles, world units.
double effectiveSkin(const SkinParams& params) { return std::max(skinDepth(params, 2), kLeastSkin * params.radius); }

// The unit of widths and steps: the particle spacing, unless discs or the skin are much smaller.
double lengthUnit(const SkinParams& params) {
    return std::min({particleSpacing(params), params.radius, kMostSkins * effectiveSkin(params)});
}

// All particles are alike, or each has a disc of its own size.
struct SizedParticles {
    const Particles& particles;
    ParticleSizes sizes;

    SnappedParticles snapped(double radius) const {
        return sizes.radius.empty() ? snapParticles(particles, radius) : snapParticles(particles, sizes.radius);
    }
    DiscBoundary boundaryOf(const SnappedParticles& snapped) const {
        DiscBoundary boundary = discBoundary(snapped);
        if (!sizes.rate.empty())
            for (const std::uint32_t row : boundary.row) boundary.radius_rate.push_back(sizes.rate[row]);
        return boundary;
    }
};

// The positions and velocities of selected particles.
Particles particlesAt(const std::vector<std::uint32_t>& rows, const Particles& particles) {
    Particles selected;
    for (const std::uint32_t row : rows) {
        selected.position.push_back(particles.position[row]);
        if (!particles.velocity.empty()) selected.velocity.push_back(particles.velocity[row]);
    }
    return selected;
}

double scaleOf(const SnappedParticles& snapped, std::size_t i) {
    return static_cast<double>(snapped.radiusOf(i)) / static_cast<double>(snapped.radius);
}

// Lowers the scales of outer points so that the disc that rolls at each reaches hardly deeper than to the skin of any
// particle. Only the skins of smaller particles can be nearer than that of the point's own.
void keepOutOfSkins(const std::vector<DualVec3>& particles, const std::vector<double>& particle_scale,
                    const CurveSkin& skin, OuterBoundary& outer) {
    const double least_depth = std::max(0.0, skin.skin - kOutermost * skin.spacing), reach = skin.rolling() + skin.skin;
    std::vector<DualVec3> points;
    for (const BoundarySample& sample : outer.samples) points.push_back(sample.position);
    points.insert(points.end(), outer.corners.begin(), outer.corners.end());
    std::vector<double> own;
    for (const Dual& scale : outer.scale) own.push_back(scale.value);
    forScaledNeighbours(
        {reach, reach / 2, reach / 2}, points.size(), [&](std::size_t i) { return points[i].position; }, own,
        particles.size(), [&](std::size_t i) { return particles[i].position; },
        [&](std::uint32_t row, std::span<const std::uint32_t> near) {
            for (const std::uint32_t i : near) {
                if (!(particle_scale[i] < own[row])) continue;
                const Dual room = length(points[row] - particles[i]) - least_depth * particle_scale[i],
                           scale = room / skin.rolling();
                if (scale.value < outer.scale[row].value) outer.scale[row] = scale;
            }
        });
}

// entranceOffset() of each sample of an outer boundary and then of each corner: at corners for their two arcs, inside
// an arc the mean of both ends.
std::vector<Dual> entranceOffsets(const DiscBoundary& outer, const std::vector<DualVec3>& discs,
                                  const std::vector<DualVec3>& corners, const DiscSamples& samples,
                                  const CurveSkin& skin) {
    const auto offsetFor = [&](Dual length, double scale) {
        return entranceOffset(length / (skin.spacing * scale), skin.rolling() / skin.spacing) *
               (skin.spacing * skin.spacing);
    };
    std::vector<Dual> at_corner(corners.size());
    for (std::uint32_t v = 0; v < corners.size(); ++v) {
        const Dual half = arcLength(outer, discs, corners, v) * 0.5;
        for (const std::uint32_t end : {v, outer.next[v]}) at_corner[end] = at_corner[end] + half;
    }
    for (std::uint32_t v = 0; v < corners.size(); ++v)
        at_corner[v] = offsetFor(at_corner[v], outer.movingScaleOfVertex(v).value);
    std::vector<Dual> offset;
    for (std::size_t i = 0; i < samples.sample.size(); ++i) {
        const std::uint32_t disc = samples.disc[i], arc = samples.arc[i];
        offset.push_back(arc == kInvalidIndex ? offsetFor(outer.worldRadiusOf(disc) * kTwoPi, outer.scaleOf(disc))
                                              : (at_corner[arc] + at_corner[outer.next[arc]]) * 0.5);
    }
    offset.insert(offset.end(), at_corner.begin(), at_corner.end());
    return offset;
}

// The boundary of discs of the outer radius, as far as it influences the curve.
OuterBoundary outerBoundary(const SizedParticles& sized, const SnappedParticles& snapped, const DiscBoundary& boundary,
                            const CurveSkin& skin) {
    const double reach = skin.joining + skin.reach() + skin.outer();
    const CellGrid exposed(boundary.position.size(), reach / 2, [&](std::size_t d) { return boundary.centre(d); });
    const std::vector<std::uint32_t> near = indicesWhere(snapped.size(), [&](std::uint32_t i) {
        const Vec3 centre = toDouble(snapped.position[i]) * snapped.quantum;
        bool is_near = false;
        exposed.forCellsIn(centre - Vec3(reach, reach, 0), centre + Vec3(reach, reach, 0),
                           [&](std::uint32_t) { is_near = true; });
        return is_near;
    });
    std::vector<std::uint32_t> rows;
    for (const std::uint32_t i : near) rows.push_back(snapped.row[i]);
    const Particles selected = particlesAt(rows, sized.particles);
    const bool have_sizes = !snapped.radius_of.empty();
    std::vector<double> radii;
    for (const std::uint32_t i : near) radii.push_back(skin.outer() * scaleOf(snapped, i));
    DiscBoundary outer =
        discBoundary(have_sizes ? snapParticles(selected, radii) : snapParticles(selected, skin.outer()));
    if (!sized.sizes.rate.empty())
        for (const std::uint32_t row : outer.row)
            outer.radius_rate.push_back(sized.sizes.rate[rows[row]] * (skin.outer() / skin.joining));
    const std::vector<DualVec3> discs = movingDiscs(outer, selected);
    std::vector<DualVec3> corners = boundaryVertices(outer, discs);
    const int directions = static_cast<int>(std::ceil(kTwoPi * skin.outer() / (kOuterSpacing * skin.spacing)));
    DiscSamples samples = boundarySamples(outer, discs, corners, std::max(directions, kDirections));
    if (have_sizes || outer.hasScales()) {  // in those of the largest disc of all, which may not be near
        samples.scale.resize(samples.sample.size(), 1);
        for (std::size_t v = 0; v < corners.size(); ++v) samples.scale.push_back(outer.movingScaleOfVertex(v));
        const double largest = outer.worldRadius() / skin.outer();
        for (Dual& scale : samples.scale) scale = scale * largest;
    }
    std::vector<Dual> offset = entranceOffsets(outer, discs, corners, samples, skin);
    OuterBoundary result{
        std::move(samples.sample), std::move(corners), std::move(samples.scale), std::move(offset), {}};
    if (!have_sizes) return result;
    std::vector<DualVec3> moving;
    std::vector<double> scale;
    for (std::size_t i = 0; i < near.size(); ++i) {
        const Vec3f v = selected.velocity.empty() ? Vec3f(0) : selected.velocity[i];
        moving.push_back({Vec3(selected.position[i].x, selected.position[i].y, 0), Vec3(v.x, v.y, 0)});
        scale.push_back(scaleOf(snapped, near[i]));
    }
    keepOutOfSkins(moving, scale, skin, result);
    return result;
}

// Where sizes differ, particles keep a tenth of their skin; else smoothing keeps its distance from them by itself.
std::vector<DeepPoint> deepPoints(const SnappedParticles& snapped, const SkinParams& params) {
    const double depth = snapped.radius_of.empty() ? 0 : (1 - kMaxSkinSmoothing) * effectiveSkin(params);
    std::vector<DeepPoint> deep;
    for (std::size_t i = 0; i < snapped.size(); ++i)
        deep.push_back({toDouble(snapped.position[i]) * snapped.quantum, depth * scaleOf(snapped, i)});
    return deep;
}

// Moves the curve from the boundary of discs inwards to the skin. The skin is thicker around isolated particles.
void moveToSkin(const SizedParticles& sized, const SnappedParticles& snapped, const DiscBoundary& boundary,
                const std::vector<DualVec3>& discs, const std::vector<DualVec3>& vertices, const SkinParams& params,
                BetaCurve& curve) {
    const Particles& particles = sized.particles;
    const CurveSkin skin{params.radius, effectiveSkin(params), lengthUnit(params)};
    smoothScales(curve, skin.spacing);
    OuterBoundary outer = outerBoundary(sized, snapped, boundary, skin);
    outer.gaps = gapPoints(boundary, discs, vertices, skin);
    const double extra = isolatedSkinDepth(params) - skinDepth(params, 2);
    std::optional<IsolationField> isolation;
    if (extra > 0) {
        std::vector<DualVec3> moving;
        std::vector<double> scale;
        for (std::size_t i = 0; i < snapped.size(); ++i) {
            const Vec3f v = particles.velocity.empty() ? Vec3f(0) : particles.velocity[snapped.row[i]];
            moving.push_back({toDouble(snapped.position[i]) * snapped.quantum, Vec3(v.x, v.y, 0)});
            if (!snapped.radius_of.empty()) scale.push_back(scaleOf(snapped, i));
        }
        isolation.emplace(moving, params.radius, skin.outer(), std::move(scale));
    }
    const auto extraSkin = [&](const DualVec3& x) { return isolation ? isolation->at(x) * extra : Dual(0); };
    retract(outer, skin, extraSkin, curve);
}

// The boundary of wider discs, which has a vertex wherever a disc of diameter `gap` fits between the particles:
// discs of that radius, gap / 2, or, where sizes differ, discs that are all wider by gap / 2 - reference. In the latter
// case the exposed ones are enough. Without the others, vertices may appear within the liquid, but only in directions
// in which a disc is covered.
DiscBoundary widerBoundary(const Particles& particles, const SnappedParticles& snapped, const DiscBoundary& boundary,
                           double gap, double reference) {
    if (boundary.radius_of.empty()) return discBoundary(snapParticles(particlesAt(snapped.row, particles), gap / 2));
    std::vector<double> radii;
    for (std::size_t d = 0; d < boundary.row.size(); ++d)
        radii.push_back(boundary.worldRadiusOf(d).value + (gap / 2 - reference));
    return discBoundary(snapParticles(particlesAt(boundary.row, particles), radii));
}

// reference: radius of a particle's disc, which half of bubble_gap includes
std::size_t fillSmallHoles(const Particles& particles, const SnappedParticles& snapped, const DiscBoundary& boundary,
                           const SkinParams& params, double reference, BetaCurve& curve) {
    const double gap = params.features.bubble_gap;
    std::optional<std::vector<bool>> has_room;
    return fillHoles(curve, params.radius * boundary.leastScale(), [&](std::size_t line, double area) {
        if (!(gap > 0)) return area < params.features.bubble_volume;
        if (gap <= 2 * reference || line >= boundary.cycle.size()) return false;
        if (!has_room) has_room = cyclesWithRoom(boundary, widerBoundary(particles, snapped, boundary, gap, reference));
        return !(*has_room)[line];
    });
}

void smooth(const DiscBoundary& boundary, const std::vector<DualVec3>& discs, const std::vector<DualVec3>& vertices,
            const SkinParams& params, BetaCurve& curve) {
    if (params.smoothing == SmoothingMethod::paper) smoothAsInPaper(curve, params.passes);
    if (!(skinDepth(params, 2) > 0)) smoothScales(curve, particleSpacing(params));  // with a skin, they are already
    if (isSmoothedCoherently(params) && skinDepth(params, 2) > 0) {
        const double widest =
            params.smoothing_width > 0 ? params.smoothing_width : kSkinWidth * particleSpacing(params);
        smoothSkin(curve, {lengthUnit(params), widest, params.passes});
    } else if (isSmoothedCoherently(params)) {
        const double width = params.smoothing_width > 0 ? params.smoothing_width : kCurveSmoothingWidth * params.radius;
        smoothCoherently(curve, boundarySamples(boundary, discs, vertices), {params.radius, width, params.passes});
    }
    if (params.resolve_intersections && usesPaperTessellation(params)) resolveIntersections(boundary, discs, curve);
}

Curves asCurves(const BetaCurve& curve) {
    Curves curves;
    for (const DualVec3& vertex : curve.vertex) {
        curves.position.push_back(vertex.position);
        curves.velocity.push_back(vertex.velocity);
    }
    forEveryVertex(curve, [&](std::uint32_t, std::uint32_t v, std::uint32_t after) {
        curves.edges.push_back({v, after});
    });
    return curves;
}

// Isolated particles as rows of SnappedParticles, ascending.
std::vector<std::uint32_t> isolatedRows(const DiscBoundary& boundary) {
    std::vector<std::uint32_t> rows;
    for (const std::uint32_t disc : boundary.isolated) rows.push_back(boundary.snapped_row[disc]);
    return rows;
}

PlaneReport reportOf(const Particles& particles, const DiscBoundary& boundary) {
    PlaneReport report;
    report.particles = particles.size();
    report.alpha_segments = boundary.segment.size();
    report.double_sided_segments = doubleSidedSegments(boundary);
    report.isolated_particles = boundary.isolated.size();
    report.alpha_vertices = boundary.position.size() - boundary.isolated.size();
    return report;
}

/// errors  particles with different z; the message names the first
void requireOnePlane(const Particles& particles) {
    for (std::size_t i = 0; i < particles.size(); ++i) {
        const Vec3f &first = particles.position[0], &p = particles.position[i];
        if (p.z == first.z) continue;
        throw ParticleError(i, "is at z = " + std::to_string(p.z) + ", particle 0 at z = " + std::to_string(first.z) +
                                   "; expected one z for all particles in two dimensions");
    }
}

void requireUsable(const Particles& particles, const SkinParams& params) {
    requirePlanar(params);
    requireScale(params);
    requireSkin(params);
    requireOnePlane(particles);
    requireAttributesNamed(particles, params.attributes);
}

}  // namespace

SkinnedPlane skinPlane(const Particles& particles, const SkinParams& reference, const Watch& watch_or_none) {
    const Watch watch = watch_or_none ? watch_or_none : [](Stage) {};
    requireUsable(particles, reference);
    const SizedParticles sized{particles, particleSizes(particles, reference)};
    const std::vector<double>& radii = sized.sizes.radius;
    const SkinParams params =
        withRadius(reference, radii.empty() ? reference.radius : *std::max_element(radii.begin(), radii.end()));
    SkinnedPlane plane;
    SnappedParticles snapped = sized.snapped(params.radius);
    const double room_radius = snapped.radius_of.empty() ? params.radius : reference.radius;
    const std::size_t distinct_particles = snapped.size();
    const RemovedDroplets left_out = removeDroplets(particles, params.features, snapped, plane.spheres);
    const DiscBoundary boundary = sized.boundaryOf(snapped);
    const std::vector<DualVec3> discs = movingDiscs(boundary, particles);
    const bool is_moving = !particles.velocity.empty() || !sized.sizes.rate.empty();
    watch(Stage::structure);

    plane.report = reportOf(particles, boundary);
    plane.report.distinct_particles = distinct_particles;
    plane.report.droplets = left_out.droplets;
    plane.report.droplet_particles = left_out.particles;
    plane.alpha = alphaCurves(boundary, discs);
    if (params.surface == SurfaceKind::alpha) {
        plane.curves = plane.alpha;
        watch(Stage::tessellate);
        watch(Stage::smooth);
    } else {
        const std::vector<DualVec3> vertices = boundaryVertices(boundary, discs);
        BetaCurve curve = tessellated(boundary, discs, vertices, params);
        if (params.features.bubbles == Bubbles::fill)
            plane.report.bubbles_filled = fillSmallHoles(particles, snapped, boundary, params, room_radius, curve);
        plane.before = asCurves(curve);
        plane.pure = curve.pure;
        watch(Stage::tessellate);
        const std::vector<DualVec3> on_discs = curve.vertex;
        if (skinDepth(params, 2) > 0) moveToSkin(sized, snapped, boundary, discs, vertices, params, curve);
        if (params.surface == SurfaceKind::beta) smooth(boundary, discs, vertices, params, curve);
        if (skinDepth(params, 2) > 0)
            keepInside(deepPoints(snapped, params), on_discs, params.radius, lengthUnit(params) * curve.leastScale(),
                       curve);
        watch(Stage::smooth);
        if (is_moving) limitVelocities(boundary, discs, curve);
        plane.curves = asCurves(curve);
        if (usesPaperTessellation(params)) addSpheres(particles, snapped, isolatedRows(boundary), plane.spheres);
    }
    if (!is_moving) plane.curves.velocity.clear();
    plane.before.velocity.clear();
    for (Vec3& v : plane.spheres.velocity) v.z = 0;
    plane.alpha.velocity.clear();
    for (auto* rows : {&plane.curves.position, &plane.before.position, &plane.alpha.position, &plane.spheres.position})
        for (Vec3& p : *rows) p.z = particles.position[0].z;
    plane.curves.attributes = carriedAttributes(particles, boundary.row, discs, {boundary.worldRadius()},
                                                params.attributes, plane.curves.position);
    plane.spheres.attributes = attributesOf(particles, plane.spheres.particle, params.attributes);
    watch(Stage::velocity);
    return plane;
}

void requirePlanar(const SkinParams& params) {
    const Features& features = params.features;
    const auto refuse = [](const std::string& what) {
        throw Error(what + " works in three dimensions only. Leave it out in two");
    };
    if (params.predicates == PredicateKind::floating) refuse("floating predicates (--predicates float)");
    if (!params.radius_attribute.empty() && usesPaperTessellation(params))
        throw Error(
            "particles of different sizes work with the complete tessellation only; expected "
            "that tessellation");
    if (features.tendrils != Tendrils::mesh) refuse("leaving out tendrils (--tendrils)");
    if (features.bubbles != Bubbles::mesh &&
        (params.surface != SurfaceKind::beta || params.tessellation != Tessellation::complete))
        throw Error("bubbles can be filled only with the complete tessellation; expected that tessellation");
    if (params.components) refuse("numbering components (--components)");
    if (!params.walls.empty()) refuse("laying the surface against walls (--walls)");
    if (params.box) refuse("cutting the surface off at a box (--surface-box)");
    if (params.surface_attributes.normals) refuse("measuring normals (--output-normals)");
    if (!(params.surface_attributes == SurfaceAttributes{})) refuse("measuring the surface (--surface-attributes)");
    if (params.smoothing == SmoothingMethod::paper && params.tessellation != Tessellation::paper)
        throw Error("the paper's smoothing works only on the paper's tessellation; expected that tessellation");
}

}  // namespace betamesh
