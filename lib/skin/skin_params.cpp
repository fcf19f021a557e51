
#include "betamesh/skin_params.h"

#include "betamesh/error.h"

#include <algorithm>
#include <sstream>

namespace betamesh {

namespace {

constexpr double kLiquidInSpacings = 3.5, kLiquidInRadii = 2;
constexpr double kUsualRadius = 1.5;  // spacings, as in the paper
constexpr double kAutomaticSkin =
    0.55;  // spacings: between 0.5, true to the volume of bulk and sheets, and 0.62 of drops
constexpr double kAutomaticPlanarSkin = 0.5;   // spacings: true to the area of bulk and rows
constexpr double kLonePlanarSkin = 0.5641896;  // spacings: sqrt(1/pi), the radius of a disc of area 1
constexpr double kMostOfRadius = 0.8;          // that an automatic skin takes where balls are small

bool hasSkin(const SkinParams& params) {
    return params.surface == SurfaceKind::beta && params.tessellation == Tessellation::complete;
}

double automaticSkin(const SkinParams& params, double spacings) {
    return std::min(spacings * particleSpacing(params), kMostOfRadius * params.radius);
}

}  // namespace

double particleSpacing(const SkinParams& params) {
    return params.spacing > 0 ? params.spacing : params.radius / kUsualRadius;
}

double liquidReach(const SkinParams& params) {
    return std::max(kLiquidInSpacings * particleSpacing(params), kLiquidInRadii * params.radius);
}

double skinDepth(const SkinParams& params, int dimension) {
    if (!hasSkin(params)) return 0;
    if (params.skin) return *params.skin;
    if (params.smoothing != SmoothingMethod::coherent || params.passes == 0) return 0;
    return automaticSkin(params, dimension == 2 ? kAutomaticPlanarSkin : kAutomaticSkin);
}

double leastSkin(const SkinParams& params) {
    const double depth = skinDepth(params);
    return depth > 0 ? std::max(depth, params.radius / 7) : 0;
}

double loneSkinDepth(const SkinParams& params) {
    const double depth = skinDepth(params, 2);
    return params.skin || depth == 0 ? depth : automaticSkin(params, kLonePlanarSkin);
}

void requireSkin(const SkinParams& params) {
    const double skin = params.skin.value_or(0);
    if (skin == 0) return;
    if (!hasSkin(params)) throw Error("a length needs the complete tessellation; expected auto or none");
    if (skin > 0 && skin < params.radius) return;
    std::ostringstream message;
    message << "the skin is " << skin << " and the radius of the balls " << params.radius
            << "; expected a skin above 0 and below the radius, or none for the surface of the balls themselves";
    throw Error(message.str());
}

}  // namespace betamesh
