#include "skin/stage_settings.h"

#include "betamesh/error.h"
#include "skin/beta_mesh.h"
#include "skin/constants.h"
#include "skin/surface_attributes.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

bool isComplete(const SkinParams& params) {
    return params.surface == SurfaceKind::beta && params.tessellation == Tessellation::complete;
}

bool hasSkin(const SkinParams& params) { return skinDepth(params) > 0; }

bool isSmoothed(const SkinParams& params) { return coherentPasses(params) > 0 || hasSkin(params); }

int coherentPasses(const SkinParams& params) {
    return params.smoothing == SmoothingMethod::coherent ? params.passes : 0;
}

Icosphere faceDirections(const SkinParams& params) {
    if (params.surface != SurfaceKind::beta) return {};
    if (params.tessellation == Tessellation::paper)
        return isSmoothed(params) ? icosphereOf(kPaperSampleAngle) : Icosphere();
    if (params.arc_subdivisions > 0)
        return icosphereOf(std::clamp(kCommonArcAngle / params.arc_subdivisions, kMinFaceAngle, kMaxFaceAngle));
    if (hasSkin(params)) return icosphereOf(kSkinFaceAngle);
    return icosphereOf(isSmoothed(params) ? kSmoothedFaceAngle : ArcSubdivision().max_angle);
}

ArcSubdivision arcSubdivision(const SkinParams& params) {
    ArcSubdivision subdivision;
    subdivision.segments = params.arc_subdivisions;
    if (!isSmoothed(params)) return subdivision;
    subdivision.appearance = Appearance::gradual;
    subdivision.is_retracted = hasSkin(params);
    subdivision.max_angle = subdivision.is_retracted ? kSkinArcAngle : kSmoothedArcAngle;
    return subdivision;
}

CoherentSmoothing coherentSmoothing(const SkinParams& params) {
    const double width = params.smoothing_width > 0 ? params.smoothing_width : kSmoothingWidth * params.radius;
    return {params.radius, width, coherentPasses(params)};
}

SkinLengths skinLengths(const SkinParams& params) {
    const double spacing = particleSpacing(params);
    return {params.radius / spacing, effectiveSkinDepth(params) / spacing, !params.skin,
            params.arc_subdivisions == 1 ? kSingleSegmentEdgeFactor : 1};
}

bool facetsMayCutOffParticles(const SkinParams& params) {
    const SkinLengths lengths = skinLengths(params);
    const double longest_edges = lengths.edge_factor * std::max(1.0, lengths.joining / kLargeBalls);
    return lengths.skin < kThinSkin * longest_edges || params.passes > kFewPasses;
}

double widestSkinFit(const SkinParams& params) {
    return params.smoothing_width > 0 ? params.smoothing_width / particleSpacing(params) : kWidestFit;
}

double farthestSkinSmoothing(const SkinParams& params) {
    return kMaxSkinSmoothing * effectiveSkinDepth(params) / particleSpacing(params);
}

void requireWalls(const SkinParams& params) {
    if (params.walls.empty()) return;
    if (!isComplete(params))
        throw Error(
            "walls (surface.walls) need the beta mesh with the complete tessellation. Leave them out, or choose that "
            "(surface.kind, surface.tessellation)");
    for (const Wall& wall : params.walls)
        if (!(std::abs(wall.normal.length() - 1) < 1e-6) || !std::isfinite(wall.offset))
            throw Error("a wall needs a normal of unit length and a finite offset (surface.walls)");
}

std::optional<Box> clippingBox(const SkinParams& params) {
    if (!params.box) return std::nullopt;
    if (!isComplete(params))
        throw Error(
            "a box that cuts the surface off (surface.box) needs the beta mesh with the complete tessellation. Leave "
            "it out, or choose that (surface.kind, surface.tessellation)");
    const Box box(roundedToFloats(params.box->min), roundedToFloats(params.box->max));
    for (int k = 0; k < 3; ++k)
        if (!(box.min[k] < box.max[k]) || !std::isfinite(box.max[k] - box.min[k]))
            throw Error(
                "a box needs finite corners, the lower one first, that differ in each coordinate (surface.box)");
    return box;
}

void requireSizes(const SkinParams& params) {
    if (!params.radius_rate_attribute.empty() && params.radius_attribute.empty())
        throw Error("surface.radius_rate_attribute is given, but surface.radius_attribute is not. Give both");
    if (params.radius_attribute.empty()) return;
    if (!(params.radius_scale > 0) || !std::isfinite(params.radius_scale))
        throw Error("the factor of the radii (surface.radius_scale) is " + std::to_string(params.radius_scale) +
                    "; expected a number above 0");
    if (params.tessellation == Tessellation::paper && params.surface == SurfaceKind::beta)
        throw Error(
            "surface.radius_attribute needs the complete tessellation: the paper's supports one radius alone "
            "(surface.tessellation)");
    if (params.predicates != PredicateKind::exact)
        throw Error(
            "surface.radius_attribute needs exact predicates: floating ones support one radius alone "
            "(surface.predicates)");
}

void requireConsistent(const SkinParams& params) {
    if (params.surface == SurfaceKind::beta && params.tessellation != Tessellation::paper &&
        params.smoothing == SmoothingMethod::paper)
        throw Error(
            "the paper's smoothing averages over the fans of its own tessellation; expected the paper's "
            "tessellation or coherent smoothing");
    if (params.features.bubbles == Bubbles::fill && !isComplete(params))
        throw Error(
            "only the complete tessellation has bubbles that can be filled; expected the complete "
            "tessellation, or bubbles that are meshed");
    requireScale(params);
    requireSizes(params);
    requireSkin(params);
    requireDistinctNames(params);
    requireWalls(params);
    clippingBox(params);
}

}  // namespace betamesh
