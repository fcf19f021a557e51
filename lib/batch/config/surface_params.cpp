#include "batch/config/surface_params.h"

#include "batch/config/key_types.h"
#include "betamesh/error.h"
#include "io/extension.h"
#include "skin/particle_sizes.h"
#include "skin/stage_settings.h"
#include "skin/surface_attributes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace betamesh {
namespace {

constexpr double kMostDrift = 0.25;  // of a frame's spacing before there is a warning, relative
constexpr double kLeastUsualRadius = 0.8, kMostUsualRadius = 3;  // usual ball radii, in spacings
constexpr double kJoiningRadius = 0.5;  // spacings; smaller balls of most neighbours do not touch

constexpr double kMostSpacingInSizes = 1.5;  // usual distance between particles in sizes of their own, or its inverse

// Spacings; a larger radius is taken for a mistake. It costs hours where a ball has thousands of neighbours.
constexpr double kWrongRadius = 50, kWrongRadiusOfMany = 10;
constexpr std::size_t kMany = 5000;  // particles

// SpacingEstimate::clumped from which on particles are as unevenly spaced as in FLIP, and the radius, in spacings, from
// which on balls close the gaps between them.
constexpr double kClumped = 0.12, kClosesGaps = 2;

// Ratio of the local spacings of the outermost of 90 % of the particles from which on the spacing is uncertain. It is
// at most 1.2 in SPH, 1.6 in FLIP, and more where sheets have thinned out.
constexpr double kUncertainRange = 1.65;

ResolvedRadius resolvedRadius(const Length& radius, double spacing, std::string source) {
    return {radius.in_spacings ? radius.value * spacing : radius.value, spacing, std::move(source), {}, {}};
}

/// Advice for the log where small balls would leave gaps between unevenly spaced particles.
std::string adviceOnRadius(const Config::Surface& surface, const SpacingEstimate& estimate) {
    const bool has_gaps = estimate.clumped > kClumped && surface.radius.value < kClosesGaps;
    if (!has_gaps || surface.kind != SurfaceKind::beta || surface.tessellation != Tessellation::complete) return {};
    return "the particles are as unevenly spaced as those of FLIP: " +
           std::to_string(static_cast<int>(100 * estimate.clumped)) +
           " % have another one nearer than half the usual distance. --preset flip closes the gaps that show as pits "
           "and pinholes";
}

/// Advice for the log where the measured spacing may not be the one of the simulation.
std::string adviceOnSpacing(const SpacingEstimate& estimate) {
    const double range = estimate.high / estimate.low;
    if (!(range > kUncertainRange)) return {};
    return "the local spacing of the particles differs by a factor of " + shortNumber(std::round(range * 10) / 10) +
           ", which makes the measured one uncertain. If you know the distance at which the simulation seeded its "
           "particles, give it with --spacing";
}

/// The paper's smoothing needs its tessellation.
void reconcileTessellation(Config& config, std::vector<std::string>& warnings) {
    if (config.smoothing.method != SmoothingMethod::paper || config.surface.kind != SurfaceKind::beta ||
        config.surface.tessellation == Tessellation::paper)
        return;
    config.surface.tessellation = Tessellation::paper;
    warnings.emplace_back("smoothing.method paper needs the paper's tessellation: surface.tessellation paper is used");
}

void reconcileBubbles(Config& config, std::vector<std::string>& warnings) {
    const Config::Surface& surface = config.surface;
    std::optional<Bubbles>& bubbles = config.features.bubbles;
    const bool can_fill = surface.kind == SurfaceKind::beta && surface.tessellation == Tessellation::complete;
    if (bubbles == Bubbles::fill && !can_fill)
        warnings.emplace_back("features.bubbles fill needs surface.tessellation complete: bubbles are not filled");
    bubbles = can_fill ? bubbles.value_or(Bubbles::fill) : Bubbles::mesh;
}

void reconcileNormals(Config& config) {
    const Config::Surface& surface = config.surface;
    const Config::Output& output = config.output;
    if (output.normals) return;
    const bool are_fitted =
        surface.kind == SurfaceKind::beta && surface.tessellation == Tessellation::complete && surface.dimension == 3;
    const auto carried = std::find(output.attributes.begin(), output.attributes.end(), "N");
    config.output.normals =
        are_fitted && carried == output.attributes.end() && (output.path.empty() || holdsNormals(output.path));
}

double worldLength(const Length& length, double spacing) { return length.value * (length.in_spacings ? spacing : 1); }

/// surface.skin, or the deprecated surface.inset; nullopt for auto.
const std::optional<Length>& skinText(const Config::Surface& surface) {
    return surface.inset ? surface.inset : surface.skin;
}

/// The parameters with radius, spacing and skin, in world units.
SkinParams withSkin(SkinParams params, const Config::Surface& surface, double radius, double spacing) {
    params.radius = radius;
    params.spacing = spacing;
    const std::optional<Length>& given = skinText(surface);
    if (!given) return params;
    const std::string key = surface.inset ? "surface.inset" : "surface.skin";
    const double length = worldLength(*given, spacing);
    if (length > 0 && length >= radius) {
        const bool same_unit = given->in_spacings == surface.radius.in_spacings;
        throw Error(key + " is " + textOf(*given) + ", but must be less than surface.radius, which is " +
                    textOf(surface.radius) +
                    (same_unit ? "" : " (" + shortNumber(length) + " and " + shortNumber(radius) + " in world units)"));
    }
    params.skin = surface.inset && length > 0 ? radius - length : length;
    try {
        requireSkin(params);
    } catch (const Error& error) {
        throw Error(key + " is " + textOf(*given) + ": " + error.what());
    }
    return params;
}

/// The skin that replaces an inset, for a warning.
std::string skinForInset(const Length& inset, const Length& radius) {
    if (inset.value == 0) return "none";
    std::string rule = "the radius less the inset";
    if (inset.in_spacings != radius.in_spacings) return rule;
    return rule + ", " + shortNumber(radius.value - inset.value) + (radius.in_spacings ? "dx" : "");
}

/// errors  a length above 0, in world units, that 32-bit floats cannot store
void requireFloatLength(const std::string& key, double length) {
    if (length == 0 || isFloatAboveZero(length)) return;
    throw Error(key + " is " + shortNumber(length) +
                " in world units, but files store 32-bit floats, which range from 1.2e-38 to 3.4e38. Choose another "
                "unit of length");
}

/// The walls relative to the local origin of the positions.
std::vector<Wall> localWalls(const Config& config) {
    const Vec3 origin = worldOrigin(config.input, UpAxis::y);
    std::vector<Wall> walls;
    for (const std::string& text : config.surface.walls) {
        walls.push_back(wallOf(text).value());
        walls.back().offset -= dot(walls.back().normal, origin);
    }
    return walls;
}

/// The parameters with walls and box, relative to the local origin of the positions.
SkinParams withWalls(SkinParams params, const Config& config) {
    params.walls = localWalls(config);
    requireWalls(params);
    if (const auto& box = config.surface.box) {
        const Vec3 origin = worldOrigin(config.input, UpAxis::y);
        params.box =
            Box(Vec3((*box)[0], (*box)[1], (*box)[2]) - origin, Vec3((*box)[3], (*box)[4], (*box)[5]) - origin);
        clippingBox(params);
    }
    return params;
}

/// Compares sizes with local spacings, which are given in sizes.
FrameSpacing compareSizes(std::vector<double> spacings, const std::string& attribute) {
    if (spacings.empty()) return {};
    const double typical = typicalSpacing(std::move(spacings));
    if (typical < kMostSpacingInSizes && typical > 1 / kMostSpacingInSizes) return {};
    return {{},
            {},
            "the distance between neighbouring particles is typically " + shortNumber(typical) + " times their " +
                attribute + " with its factor; about 1 is expected, as " + attribute +
                " stands for the particle spacing. Multiply the factor (--radius-scale, surface.radius_scale) by " +
                shortNumber(typical)};
}

}  // namespace

std::optional<Wall> wallOf(std::string_view given) {
    std::string text(given);
    std::erase(text, ' ');
    const std::size_t relation = text.find_first_of("<>");
    if (relation == std::string::npos) return std::nullopt;
    const auto offset = numberOf<double>(std::string_view(text).substr(relation + 1));
    const std::string_view terms = std::string_view(text).substr(0, relation);
    if (!offset || terms.empty()) return std::nullopt;
    Wall wall{Vec3(0), *offset};
    for (std::size_t at = 0, axis = 0; at < terms.size(); at = axis + 1) {
        const bool has_sign = terms[at] == '+' || terms[at] == '-';
        if (!has_sign && at > 0) return std::nullopt;
        const std::size_t begin = at + (has_sign ? 1 : 0);
        axis = terms.find_first_of("xyz", begin);
        if (axis == std::string_view::npos) return std::nullopt;
        std::string_view factor = terms.substr(begin, axis - begin);
        if (factor.ends_with('*')) factor.remove_suffix(1);
        const auto number = factor.empty() ? std::optional(1.0) : numberOf<double>(factor);
        if (!number || *number < 0) return std::nullopt;
        wall.normal[terms[axis] - 'x'] += terms[at] == '-' ? -*number : *number;
    }
    const double length = wall.normal.length() * (text[relation] == '<' ? 1 : -1);
    wall.normal /= length;
    wall.offset /= length;
    const bool is_plane = length != 0 && std::isfinite(length) && std::isfinite(wall.normal.length2()) &&
                          std::isfinite(wall.offset) && fitsFloat(wall.offset);
    return is_plane ? std::optional(wall) : std::nullopt;
}

std::optional<ResolvedRadius> givenRadius(const Config& config) {
    const Length& radius = config.surface.radius;
    if (config.surface.spacing > 0) return resolvedRadius(radius, config.surface.spacing, "as given");
    if (!radius.in_spacings) return resolvedRadius(radius, radius.value / kDefaultRadiusSpacings, "radius / 1.5");
    return std::nullopt;
}

std::optional<ResolvedRadius> measuredRadius(const Config& config, const MeasuredSpacing& measured) {
    const std::optional<ResolvedRadius> given = givenRadius(config);
    if (config.surface.spacing > 0) return given;

    const std::optional<SpacingEstimate>& found = measured.estimate;
    const Length& radius = config.surface.radius;
    const double most = measured.most_particles > kMany ? kWrongRadiusOfMany : kWrongRadius;
    if (found && radius.value > most * (radius.in_spacings ? 1 : found->spacing))
        throw Error("the radius " + textOf(radius) + " is " +
                    shortNumber(radius.in_spacings ? radius.value : radius.value / found->spacing) +
                    " times the particle spacing " + shortNumber(found->spacing) + ", measured in " + measured.where +
                    ". " +
                    (radius.in_spacings ? "Did you mean world units?"
                                        : "Did you mean " + textOf(radius) + "dx, that is in spacings?") +
                    " To use this radius nevertheless, give the spacing as well (--spacing, surface.spacing).");
    if (given) return given;
    if (!found) return std::nullopt;
    ResolvedRadius resolved =
        resolvedRadius(config.surface.radius, found->spacing,
                       "measured in " + measured.where + ", where the local spacing of 90 % of the particles is " +
                           shortNumber(found->low) + " to " + shortNumber(found->high));
    for (const std::string& advice : {adviceOnRadius(config.surface, *found), adviceOnSpacing(*found)})
        if (!advice.empty()) resolved.advice.push_back(advice);
    return resolved;
}

void reconcileSurface(Config& config, std::vector<std::string>& warnings) {
    reconcileTessellation(config, warnings);
    reconcileBubbles(config, warnings);
    reconcileNormals(config);
}

SkinParams skinParams(const Config& config) {
    SkinParams params;
    params.surface = config.surface.kind;
    params.tessellation = config.surface.tessellation;
    params.predicates = config.surface.predicates;
    params.retries = config.perturbation.retries;
    params.tolerance = config.perturbation.tolerance;
    params.arc_subdivisions = config.surface.arc_subdivisions;
    params.radius_attribute = config.surface.radius_attribute;
    params.radius_scale = config.surface.radius_scale * config.input.scale;
    params.radius_rate_attribute = config.surface.radius_rate_attribute;
    params.radius_rate_scale = config.input.time_scale;
    params.smoothing = config.smoothing.method;
    params.passes = config.smoothing.passes;
    params.resolve_intersections = config.surface.resolve_intersections;
    params.attributes = config.output.attributes;
    params.features.droplets = config.features.droplets;
    params.features.droplet_particles = config.features.droplet_particles;
    params.features.tendrils = config.features.tendrils;
    params.features.bubbles = config.features.bubbles.value_or(Bubbles::mesh);
    params.components = config.output.components;
    const auto measures = [&](std::string_view name) {
        const std::vector<std::string>& names = config.output.surface_attributes;
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    params.surface_attributes = {config.output.normals.value_or(false), measures("thickness"), measures("curvature"),
                                 measures("shape")};
    return params;
}

void checkSkin(const Config& config, std::vector<std::string>& warnings) {
    const SkinParams params = skinParams(config);
    requireDistinctNames(params);
    requireSizes(params);
    withWalls(params, config);
    const Config::Surface& surface = config.surface;
    if (surface.inset && surface.skin)
        throw Error("surface.skin and surface.inset are both set. Use surface.skin alone; surface.inset is deprecated");
    if (surface.inset)
        warnings.push_back("surface.inset (--inset) is deprecated. Use surface.skin (--skin) instead: " +
                           skinForInset(*surface.inset, surface.radius));
    if (!params.radius_attribute.empty() && !surface.radius.in_spacings && surface.spacing == 0)
        warnings.push_back(
            "--radius " + textOf(surface.radius) +
            " (surface.radius) alone does not change the size of the balls: without --spacing "
            "(surface.spacing) the spacing is this radius / 1.5, which makes the radius 1.5dx again, where dx "
            "is the " +
            params.radius_attribute +
            " of each particle. Give the radius in dx, as in --radius 2dx, or give --spacing, too");
    const std::optional<Length>& length = skinText(surface);
    if (!length) return;
    if (const auto given = givenRadius(config)) {
        withSkin(params, surface, given->radius, given->spacing);
    } else {
        const double large_enough = 2 * length->value;  // stands for a radius that is given in the other unit
        withSkin(params, surface, length->in_spacings ? surface.radius.value : large_enough, 1);
    }
}

SkinParams withLengths(SkinParams params, const Config& config, const ResolvedRadius& resolved) {
    params = withSkin(std::move(params), config.surface, resolved.radius, resolved.spacing);
    requireScale(params);
    params = withWalls(std::move(params), config);
    params.smoothing_width = worldLength(config.smoothing.width, resolved.spacing);
    const Config::Features& features = config.features;
    if (features.bubble_volume > 0)
        params.features.bubble_volume = features.bubble_volume * std::pow(resolved.spacing, config.surface.dimension);
    else
        params.features.bubble_gap = worldLength(features.bubble_gap, resolved.spacing);
    requireFloatLength("surface.spacing", resolved.spacing);
    requireFloatLength("surface.radius", resolved.radius);
    requireFloatLength("surface.skin", params.skin.value_or(0));
    requireFloatLength("smoothing.width", params.smoothing_width);
    requireFloatLength("features.bubble_gap", params.features.bubble_gap);
    return params;
}

FrameSpacing compareSpacing(const Particles& particles, const SkinParams& params, int dimension) {
    const double radius = params.radius, spacing = particleSpacing(params);
    if (ParticleSizes sizes = particleSizes(particles, params); !sizes.radius.empty()) {
        for (double& size : sizes.radius) size *= spacing / radius;
        return compareSizes(spacingsInSizes(particles.position, sizes.radius, dimension), params.radius_attribute);
    }
    std::vector<double> local = localSpacings(particles.position, dimension);
    if (local.empty()) return {};
    const double own = typicalSpacing(std::move(local));
    FrameSpacing result{own, {}, {}};
    const bool drifts = own > (1 + kMostDrift) * spacing || own < (1 - kMostDrift) * spacing;
    std::string scale;
    if (radius > kMostUsualRadius * own || radius < kLeastUsualRadius * own)
        scale = "the radius " + shortNumber(radius) + " is " + shortNumber(radius / own) +
                " times the particle spacing of this frame: " +
                (radius > kMostUsualRadius * own ? "parts that are far apart melt together, and meshing is slow"
                 : radius < kJoiningRadius * own ? "neighbours hardly join, so that most particles become drops"
                                                 : "sheets get holes, and threads break") +
                ". Use 0.8 to 3 times, such as --radius " + shortNumber(kDefaultRadiusSpacings * own) +
                " (surface.radius)";
    if (drifts)
        result.drift = "the particle spacing of this frame is " + shortNumber(own) + ", but " + shortNumber(spacing) +
                       " is used for all frames. Give the spacing of the liquid with --spacing (surface.spacing)" +
                       (scale.empty() ? "" : "; " + scale);
    else if (!scale.empty())
        result.scale = scale;
    return result;
}

}  // namespace betamesh
