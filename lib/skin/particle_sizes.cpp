#include "skin/particle_sizes.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "skin/attributes.h"

#include <cmath>
#include <string>

namespace betamesh {

namespace {

// One number per particle; throws for the first that is not as expected.
std::vector<double> numbersOf(const Particles& particles, const std::string& name, std::size_t first_row,
                              const auto& isExpected, const char* expected) {
    const Attribute* attribute = attributeOf(particles, name);
    if (attribute == nullptr) return {};
    if (attribute->components != 1)
        throw Error("the attribute '" + name + "' has " + std::to_string(attribute->components) +
                    " numbers per particle; expected one, since it gives the sizes of particles");
    std::vector<double> numbers(attribute->real.begin(), attribute->real.end());
    if (attribute->real.empty()) numbers.assign(attribute->integer.begin(), attribute->integer.end());
    const std::size_t bad = firstIndexWhere(numbers.size(), [&](std::size_t i) { return !isExpected(numbers[i]); });
    if (bad < numbers.size())
        throw ParticleError(first_row + bad,
                            "has " + name + " = " + std::to_string(numbers[bad]) + "; expected " + expected);
    return numbers;
}

}  // namespace

ParticleSizes particleSizes(const Particles& particles, const SkinParams& params, std::size_t first_row) {
    ParticleSizes sizes;
    if (params.radius_attribute.empty()) return sizes;
    const auto radiusOf = [&](double value) {
        return value * params.radius_scale / particleSpacing(params) * params.radius;
    };
    sizes.radius = numbersOf(
        particles, params.radius_attribute, first_row, [](double x) { return x > 0 && std::isfinite(x); },
        "a size above 0. Leave such particles out with --where (input.where)");
    for (double& radius : sizes.radius) radius = radiusOf(radius);
    if (params.radius_rate_attribute.empty()) return sizes;
    sizes.rate = numbersOf(
        particles, params.radius_rate_attribute, first_row, [](double x) { return std::isfinite(x); },
        "a finite number");
    for (double& rate : sizes.rate) rate = radiusOf(rate) * params.radius_rate_scale;
    return sizes;
}

SkinParams withRadius(const SkinParams& params, double radius) {
    if (radius == params.radius) return params;
    const double factor = radius / params.radius;
    SkinParams scaled = params;
    scaled.radius = radius;
    scaled.spacing *= factor;
    scaled.smoothing_width *= factor;
    if (scaled.skin) *scaled.skin *= factor;
    return scaled;
}

}  // namespace betamesh
