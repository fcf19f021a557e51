
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
                        ": an .svg picture shows curves, but surface.dimension 3 gives a mesh. Use another extension, "
                        "or --dimension 2.");
        requireMeshExtension(config.output.path);
    } else {
        requireCurveExtension(config.output.path);
        requirePlanar(params);
    }
    if (isSvg(config.output.path)) return;
    if (config.picture.layers != Config{}.picture.layers || config.picture.bounds != Config{}.picture.bounds)
        throw Error("picture.layers and picture.bounds are for .svg output; the output is " + config.output.path);
}

void writePlane(const std::string& output, const SkinnedPlane& plane, const std::vector<Vec3f>& centres,
                const SkinParams& params, const Config& config) {
    if (!isSvg(output)) return writeCurves(output, plane.curves);
    PlanePicture picture;
    picture.particles.assign(centres.begin(), centres.end());
    picture.radius = params.radius;
    picture.alpha = plane.alpha;
    picture.before = plane.before;
    picture.beta = plane.curves;
    picture.pure = plane.pure;
    picture.apart = plane.spheres.position;
    writeSvg(output, picture, parseLayers(config.picture.layers), parseBounds(config.picture.bounds));
}

}  // namespace betamesh
