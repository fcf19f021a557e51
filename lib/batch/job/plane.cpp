
#include "batch/job/plane.h"

#include "betamesh/error.h"
#include "io/curve_file.h"
#include "io/mesh_file.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace betamesh {

namespace {

const std::vector<std::pair<std::string, Layer>> kLayers{{"discs", Layer::discs}, {"particles", Layer::particles},
                                                         {"alpha", Layer::alpha}, {"before", Layer::before},
                                                         {"beta", Layer::beta},   {"vertices", Layer::vertices}};

constexpr double kFlat = 0.01;  // spacings: particles this close to one plane lie in it

Boxf boxOf(const std::vector<Vec3f>& positions) {
    Boxf box;
    for (const Vec3f& p : positions) box.extendBy(p);
    return box;
}

}  // namespace

std::vector<Layer> parseLayers(const std::vector<std::string>& names) {
    std::vector<Layer> layers;
    for (const std::string& name : names) {
        const auto found =
            std::find_if(kLayers.begin(), kLayers.end(), [&](const auto& layer) { return layer.first == name; });
        if (found == kLayers.end()) throw Error("'" + name + "' is no layer");
        layers.push_back(found->second);
    }
    std::sort(layers.begin(), layers.end());
    return layers;
}

PlaneBounds parseBounds(const std::string& text) {
    if (text == "auto") return {};
    std::istringstream in(text);
    PlaneBounds bounds;
    char comma[3] = {',', ',', ','};
    in >> bounds.low.x >> comma[0] >> bounds.low.y >> comma[1] >> bounds.high.x >> comma[2] >> bounds.high.y;
    const bool read =
        in && in.eof() && std::all_of(std::begin(comma), std::end(comma), [](char c) { return c == ','; });
    if (!read || !(bounds.low.x < bounds.high.x) || !(bounds.low.y < bounds.high.y))
        throw Error("'" + text + "' is invalid. Use auto, or the lowest x and y and then the highest, as in 0,0,4,2.5");
    return bounds;
}

void requireDimension(const Config& config, const SkinParams& params) {
    if (config.surface.dimension == 3) {
        if (isSvg(config.output.path))
            throw Error(config.output.path +
                        ": an .svg drawing shows curves, but surface.dimension 3 gives a mesh. Use another extension, "
                        "or --dimension 2.");
        requireMeshExtension(config.output.path);
    } else {
        requireCurveExtension(config.output.path);
        requirePlanar(params);
        for (const auto& [is_set, key] : {std::pair(!config.surface.walls.empty(), "surface.walls (--walls)"),
                                          std::pair(config.surface.box.has_value(), "surface.box (--surface-box)"),
                                          std::pair(config.output.simplify.value > 0, "output.simplify (--simplify)")})
            if (is_set)
                throw Error(std::string(key) + " is for meshes, but surface.dimension 2 gives curves. Leave it out.");
    }
    if (isSvg(config.output.path)) return;
    if (config.picture.layers != Config{}.picture.layers || config.picture.bounds != Config{}.picture.bounds)
        throw Error("picture.layers and picture.bounds are for .svg output; the output is " + config.output.path);
}

Vec3 AxisPlane::toPlane(const Vec3& v) const {
    return axis == 2 ? v : axis == 1 ? Vec3(v.x, v.z, -v.y) : Vec3(v.y, v.z, v.x);
}

Vec3 AxisPlane::toSpace(const Vec3& v) const {
    return axis == 2 ? v : axis == 1 ? Vec3(v.x, -v.z, v.y) : Vec3(v.z, v.x, v.y);
}

std::optional<AxisPlane> planeOf(const std::vector<Vec3f>& positions, double spacing) {
    if (positions.empty()) return AxisPlane{};
    const Boxf box = boxOf(positions);
    for (const int axis : {2, 1, 0}) {
        const float low = box.min[axis], high = box.max[axis];
        if (static_cast<double>(high) - static_cast<double>(low) <= kFlat * spacing)
            return AxisPlane{axis, low == high ? low : low + (high - low) / 2};
    }
    return std::nullopt;
}

FlatParticles flattened(Particles particles, double spacing) {
    const auto plane = planeOf(particles.position, spacing);
    if (!plane) {
        const Vec3f size = boxOf(particles.position).size();
        throw Error("the particles do not lie in a plane of one z, one y or one x: they extend over " +
                    std::to_string(size.x) + ", " + std::to_string(size.y) + " and " + std::to_string(size.z) +
                    ". Skin them in three dimensions (surface.dimension 3)");
    }
    FlatParticles flat{*plane, std::move(particles)};
    for (Vec3f& p : flat.particles.position) {
        p = Vec3f(plane->toPlane(Vec3(p)));
        p.z = plane->axis == 1 ? -plane->height : plane->height;
    }
    for (Vec3f& v : flat.particles.velocity) v = Vec3f(plane->toPlane(Vec3(v)));
    return flat;
}

Spheres toSpace(Spheres spheres, const AxisPlane& plane) {
    for (auto* rows : {&spheres.position, &spheres.velocity})
        for (Vec3& v : *rows) v = plane.toSpace(v);
    return spheres;
}

Curves toSpace(Curves curves, const AxisPlane& plane) {
    for (auto* rows : {&curves.position, &curves.velocity})
        for (Vec3& v : *rows) v = plane.toSpace(v);
    return curves;
}

void writePlane(const std::string& output, const SkinnedPlane& plane, const FlatParticles& discs,
                const SkinParams& params, const Config& config, const WriteOptions& options) {
    if (!isSvg(output)) return writeCurves(output, toSpace(plane.curves, discs.plane), options);
    PlaneDrawing drawing;
    const std::vector<Vec3f>& centres = discs.particles.position;
    drawing.particles.assign(centres.begin(), centres.end());
    drawing.radius = params.radius;
    drawing.alpha = plane.alpha;
    drawing.before = plane.before;
    drawing.beta = plane.curves;
    drawing.pure = plane.pure;
    drawing.apart = plane.spheres.position;
    writeSvg(output, drawing, parseLayers(config.picture.layers), parseBounds(config.picture.bounds));
}

}  // namespace betamesh
