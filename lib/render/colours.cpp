
#include "render/colours.h"

#include "base/parallel.h"
#include "base/random.h"
#include "betamesh/error.h"
#include "mesh/components.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

// Linear red, green, blue.
const Vec3f kLiquid(0.055f, 0.165f, 0.30f);
const Vec3f kBubble(0.75f, 0.36f, 0.08f);
const Vec3f kTwoSided(0.10f, 0.50f, 0.36f);
const Vec3f kSphere(0.42f, 0.12f, 0.40f);

using Scale = std::vector<Vec3f>;  // colours from low to high, evenly spaced
const Scale kFoam{
    {0.015f, 0.05f, 0.18f}, {0.02f, 0.16f, 0.38f}, {0.05f, 0.38f, 0.52f}, {0.32f, 0.66f, 0.66f}, {0.92f, 0.92f, 0.86f}};
const Scale kDiverging{
    {0.02f, 0.10f, 0.42f}, {0.20f, 0.45f, 0.75f}, {0.52f, 0.52f, 0.50f}, {0.72f, 0.30f, 0.10f}, {0.45f, 0.03f, 0.03f}};

Vec3f colourAt(const Scale& scale, double share) {
    const double at = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) * static_cast<double>(scale.size() - 1) : 0;
    const auto below = std::min(static_cast<std::size_t>(at), scale.size() - 2);
    const auto part = static_cast<float>(at - static_cast<double>(below));
    return scale[below] * (1 - part) + scale[below + 1] * part;
}

template <typename ValueOf>
std::vector<Vec3f> scaled(std::size_t rows, const Scale& scale, double low, double high, const ValueOf& valueOf) {
    std::vector<Vec3f> colours(rows);
    parallelFor(rows, 4096, [&](std::size_t i) {
        colours[i] = colourAt(scale, high > low ? (static_cast<double>(valueOf(i)) - low) / (high - low) : 0);
    });
    return colours;
}

void colourByVelocity(const Mesh& mesh, const Spheres& spheres, Colouring colouring, SurfaceColours& colours) {
    if (!(colouring.high > colouring.low))
        colouring.low = 0, colouring.high = std::max(largestLength(mesh.velocity), largestLength(spheres.velocity));
    const auto coloured = [&](std::size_t rows, const std::vector<Vec3>& velocity) {
        return scaled(rows, kFoam, colouring.low, colouring.high,
                      [&](std::size_t i) { return velocity.empty() ? 0.0 : velocity[i].length(); });
    };
    colours.vertex = coloured(mesh.position.size(), mesh.velocity);
    colours.sphere = coloured(spheres.size(), spheres.velocity);
}

void colourByCurvature(const Mesh& mesh, const std::vector<Vec3>& normal, Colouring colouring,
                       SurfaceColours& colours) {
    const std::vector<float> curvature = vertexCurvatures(mesh, normal);
    if (!(colouring.high > colouring.low) &&
        !curvature.empty()) {  // symmetric range that excludes the tenth of largest magnitude
        std::vector<float> magnitudes(curvature.size());
        std::transform(curvature.begin(), curvature.end(), magnitudes.begin(), [](float x) { return std::abs(x); });
        const auto most = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() * 9 / 10);
        std::nth_element(magnitudes.begin(), most, magnitudes.end());
        colouring.high = static_cast<double>(*most);
        colouring.low = -colouring.high;
    }
    colours.vertex = scaled(curvature.size(), kDiverging, colouring.low, colouring.high,
                            [&](std::size_t i) { return curvature[i]; });
}

/// Random hue; component 0 has the plain colour.
Vec3f colourOfComponent(std::uint32_t component) {
    if (component == 0) return kLiquid;
    Random random(component);
    const double hue = 2 * 3.14159265358979 * random.unit(), brightness = random.between(0.25, 0.5);
    const auto channel = [&](double turn) {
        return static_cast<float>(brightness * (0.62 + 0.5 * std::cos(hue - turn)));
    };
    return {channel(0), channel(2.0944), channel(4.1888)};
}

void colourByComponent(const Mesh& mesh, SurfaceColours& colours) {
    colours.triangle.resize(mesh.triangles.size());
    if (mesh.component) {
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            colours.triangle[i] = colourOfComponent(static_cast<std::uint32_t>((*mesh.component)[i]));
        return;
    }
    const Components components = componentsOf(mesh.position.size(), mesh.triangles);
    std::vector<std::uint32_t> triangles(components.count, 0);
    for (const Triangle& t : mesh.triangles) ++triangles[components.of_vertex[t[0]]];
    const auto largest = std::max_element(triangles.begin(), triangles.end()) - triangles.begin();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t component = components.of_vertex[mesh.triangles[i][0]];
        colours.triangle[i] = colourOfComponent(component == largest ? 0 : component + 1);
    }
}

/// 1 for triangles that are in the mesh twice, once per side.
std::vector<std::uint8_t> twoSided(const Mesh& mesh) {
    struct Row {
        Triangle corners;  // ascending
        std::uint32_t triangle;
        bool operator<(const Row& other) const {
            return corners != other.corners ? corners < other.corners : triangle < other.triangle;
        }
    };
    std::vector<Row> rows(mesh.triangles.size());
    parallelFor(rows.size(), 4096, [&](std::size_t i) {
        rows[i] = {mesh.triangles[i], static_cast<std::uint32_t>(i)};
        std::sort(rows[i].corners.begin(), rows[i].corners.end());
    });
    parallelSort(rows, std::less<>());
    std::vector<std::uint8_t> two_sided(rows.size(), 0);
    for (std::size_t k = 1; k < rows.size(); ++k)
        if (rows[k].corners == rows[k - 1].corners) two_sided[rows[k].triangle] = two_sided[rows[k - 1].triangle] = 1;
    return two_sided;
}

void colourByKind(const Mesh& mesh, const Spheres& spheres, SurfaceColours& colours) {
    const Components components = componentsOf(mesh.position.size(), mesh.triangles);
    std::vector<double> volume(components.count, 0);
    for (const Triangle& t : mesh.triangles)
        volume[components.of_vertex[t[0]]] +=
            signedVolume(mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]]);
    const std::vector<std::uint8_t> two_sided = twoSided(mesh);
    colours.triangle.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        colours.triangle[i] = two_sided[i]                                             ? kTwoSided
                              : volume[components.of_vertex[mesh.triangles[i][0]]] < 0 ? kBubble
                                                                                       : kLiquid;
    colours.sphere.assign(spheres.size(), kSphere);
}

const Attribute* find(const std::vector<Attribute>& attributes, const std::string& name) {
    const auto found = std::ranges::find(attributes, name, &Attribute::name);
    return found == attributes.end() ? nullptr : &*found;
}

/// errors  rows, of which `attributes` has no attribute of that name
void requireAttribute(const char* rows, const std::vector<Attribute>& attributes, const std::string& name) {
    if (find(attributes, name) != nullptr) return;
    std::string names;
    for (const Attribute& a : attributes) names += (names.empty() ? "" : ", ") + a.name;
    throw Error(std::string(rows) + " no attribute '" + name + "' to colour by" +
                (names.empty() ? "" : ". These exist: " + names));
}

void colourByAttribute(const Mesh& mesh, const Spheres& spheres, Colouring colouring, SurfaceColours& colours) {
    if (!mesh.position.empty()) requireAttribute("the mesh has", mesh.attributes, colouring.attribute);
    if (mesh.position.empty() && spheres.size() > 0)
        requireAttribute("the particles have", spheres.attributes, colouring.attribute);
    const Attribute* const of_vertices = find(mesh.attributes, colouring.attribute);
    const Attribute* const of_spheres = find(spheres.attributes, colouring.attribute);
    const auto value = [](const Attribute& a, std::size_t i) {
        return a.integer.empty() ? static_cast<double>(a.real[i]) : static_cast<double>(a.integer[i]);
    };
    const auto rowsOf = [](const Attribute& a) { return std::max(a.real.size(), a.integer.size()) / a.components; };
    if (!(colouring.high > colouring.low)) {
        bool any = false;
        for (const Attribute* a : {of_vertices, of_spheres})
            for (std::size_t i = 0; a != nullptr && i < rowsOf(*a); ++i) {
                const double x = value(*a, i * a->components);
                colouring.low = any ? std::min(colouring.low, x) : x;
                colouring.high = any ? std::max(colouring.high, x) : x;
                any = true;
            }
    }
    const auto coloursOf = [&](const Attribute* a) -> std::vector<Vec3f> {
        if (a == nullptr) return {};
        const std::size_t n = rowsOf(*a);
        if (a->components != 3)
            return scaled(n, kFoam, colouring.low, colouring.high,
                          [&](std::size_t i) { return value(*a, i * a->components); });
        std::vector<Vec3f> linear(n);
        const auto channel = [&](std::size_t i) { return static_cast<float>(std::clamp(value(*a, i), 0.0, 1.0)); };
        for (std::size_t i = 0; i < n; ++i) linear[i] = {channel(3 * i), channel(3 * i + 1), channel(3 * i + 2)};
        return linear;
    };
    colours.vertex = coloursOf(of_vertices);
    colours.sphere = coloursOf(of_spheres);
}

}  // namespace

std::vector<float> vertexCurvatures(const Mesh& mesh, const std::vector<Vec3>& normal) {
    std::vector<double> sum(mesh.position.size(), 0);
    std::vector<std::uint32_t> edges(mesh.position.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (std::size_t m = 0; m < 3; ++m) {
            const std::uint32_t a = t[m], b = t[(m + 1) % 3];
            const Vec3 edge = mesh.position[b] - mesh.position[a];
            if (!(edge.length2() > 0)) continue;
            const double along = dot(normal[b] - normal[a], edge) / edge.length2();
            for (const std::uint32_t end : {a, b}) sum[end] += along, ++edges[end];
        }
    std::vector<float> curvature(sum.size(), 0);
    for (std::size_t i = 0; i < sum.size(); ++i)
        if (edges[i] > 0) curvature[i] = static_cast<float>(sum[i] / edges[i]);
    return curvature;
}

SurfaceColours surfaceColours(const Mesh& mesh, const Spheres& spheres, const std::vector<Vec3>& normal,
                              const Colouring& colouring) {
    SurfaceColours colours;
    colours.plain = kLiquid;
    switch (colouring.by) {
        case ColourBy::nothing:
            break;
        case ColourBy::velocity:
            colourByVelocity(mesh, spheres, colouring, colours);
            break;
        case ColourBy::kind:
            colourByKind(mesh, spheres, colours);
            break;
        case ColourBy::curvature:
            colourByCurvature(mesh, normal, colouring, colours);
            break;
        case ColourBy::component:
            colourByComponent(mesh, colours);
            break;
        case ColourBy::attribute:
            colourByAttribute(mesh, spheres, colouring, colours);
            break;
    }
    return colours;
}

}  // namespace betamesh
