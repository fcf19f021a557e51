
#include "betamesh/skin_params.h"

#include "betamesh/error.h"
#include "skin/constants.h"

#include <algorithm>
#include <sstream>

namespace betamesh {

namespace {

bool canHaveSkin(const SkinParams& params) {
    return params.surface == SurfaceKind::beta && params.tessellation == Tessellation::complete;
}

double automaticSkin(const SkinParams& params, double spacings) {
    return std::min(spacings * particleSpacing(params), kMaxAutomaticSkin * params.radius);
}

}  // namespace

double particleSpacing(const SkinParams& params) {
    return params.spacing > 0 ? params.spacing : params.radius / kPaperRadius;
}

double motionReach(const SkinParams& params) {
    return std::max(kLiquidReachSpacings * particleSpacing(params), kLiquidReachRadii * params.radius);
}

double skinDepth(const SkinParams& params, int dimension) {
    if (!canHaveSkin(params)) return 0;
    if (params.skin) return *params.skin;
    if (params.smoothing != SmoothingMethod::coherent || params.passes == 0) return 0;
    return automaticSkin(params, dimension == 2 ? kAutomaticPlanarSkin : kAutomaticSkin);
}

double effectiveSkinDepth(const SkinParams& params) {
    const double depth = skinDepth(params);
    return depth > 0 ? std::max(depth, params.radius / kMaxRadiusInSkins) : 0;
}

double isolatedSkinDepth(const SkinParams& params) {
    const double depth = skinDepth(params, 2);
    return params.skin || depth == 0 ? depth : automaticSkin(params, kLonePlanarSkin);
}

void requireScale(const SkinParams& params) {
    const double spacing = particleSpacing(params);
    if (params.radius >= kFewestSpacings * spacing && params.radius <= kMostSpacings * spacing) return;
    std::ostringstream message;
    message << "the radius of the balls is " << params.radius << " and the particle spacing " << spacing
            << "; expected a radius of " << kFewestSpacings << " to " << kMostSpacings << " spacings";
    throw Error(message.str());
}

void requireSkin(const SkinParams& params) {
    const double skin = params.skin.value_or(0);
    if (skin == 0) return;
    if (!canHaveSkin(params))
        throw Error("a skin of a given depth needs the complete tessellation; expected auto or none for the skin");
    if (skin > 0 && skin < params.radius) return;
    std::ostringstream message;
    message << "the skin is " << skin << " and the radius of the balls " << params.radius
            << "; expected a skin above 0 and below the radius, or none for the boundary of the balls themselves";
    throw Error(message.str());
}

}  // namespace betamesh
