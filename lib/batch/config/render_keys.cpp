// Configuration keys of previews, pictures of meshes and particles.

#include "batch/config/key_tables.h"
#include "batch/config/key_types.h"
#include "batch/job/frames.h"

#include <cmath>
#include <filesystem>

namespace betamesh {
namespace {

void checkPreviewPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    const std::filesystem::path extension = std::filesystem::path(path).extension();
    if (extension != ".png" && extension != ".exr") failValue(path, "a path ending in .png or .exr");
}

const Choices<ColourBy> kColourChoices{{"plain", ColourBy::nothing},
                                       {"velocity", ColourBy::velocity},
                                       {"kind", ColourBy::kind},
                                       {"curvature", ColourBy::curvature},
                                       {"component", ColourBy::component}};

ConfigKey colourKey(const KeyText& text) {
    return makeKey(
        text, ConfigKey::Kind::text, "plain, velocity, kind, curvature, component, or the name of an attribute",
        [](const Config& config) {
            const Colouring& colouring = config.preview.colouring;
            for (const auto& [name, by] : kColourChoices)
                if (by == colouring.by) return name;
            return colouring.attribute;
        },
        [](Config& config, const std::string& value) {
            Colouring& colouring = config.preview.colouring;
            colouring = {ColourBy::attribute, value};
            for (const auto& [name, by] : kColourChoices)
                if (name == value) colouring = {by, ""};
            if (value.empty())
                failValue(value, "plain, velocity, kind, curvature, component, or the name of an attribute");
        });
}

ConfigKey cutKey(const KeyText& text) {
    const std::string accepts = "none, or an axis, < or >, and a number, as in z<0.25";
    return makeKey(
        text, ConfigKey::Kind::text, accepts,
        [](const Config& config) {
            const auto& cut = config.preview.cut;
            return cut ? std::string(1, "xyz"[cut->axis]) + (cut->below ? '<' : '>') + textOf(cut->at) : "none";
        },
        [=](Config& config, const std::string& value) {
            if (value == "none") return config.preview.cut.reset();
            const std::size_t axis = std::string_view("xyz").find(value.empty() ? ' ' : value[0]);
            const auto at = numberOf<double>(std::string_view(value).substr(std::min<std::size_t>(2, value.size())));
            if (axis > 2 || value.size() < 3 || (value[1] != '<' && value[1] != '>') || !at || !fitsFloat(*at))
                failValue(value, accepts);
            config.preview.cut = CutawayPlane{static_cast<int>(axis), value[1] == '<', *at};
        });
}

ConfigKey groundKey(const KeyText& text) {
    using Ground = Config::Preview::Ground;
    const std::string accepts = "auto, none, or a number";
    return makeKey(
        text, ConfigKey::Kind::text, accepts,
        [](const Config& config) {
            const Config::Preview& preview = config.preview;
            if (preview.ground == Ground::given) return textOf(preview.ground_height);
            return std::string(preview.ground == Ground::none ? "none" : "auto");
        },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (number ? !fitsFloat(*number) : value != "auto" && value != "none") failValue(value, accepts);
            config.preview.ground = number ? Ground::given : value == "none" ? Ground::none : Ground::automatic;
            config.preview.ground_height = number.value_or(0);
        });
}

}  // namespace

void addPreviewKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"preview.path", "", "",
         "Previews, one picture per frame. .png: to look at. .exr: also depth, normals, positions, motion "
         "vectors and ids for compositing. Empty: no previews."},
        "a path ending in .png or .exr, with the frame number written as in input.path; or leave it empty",
        [](Config& c) -> std::string& { return c.preview.path; }, checkPreviewPath));
    keys.push_back(choiceKey<ShownGeometry>(
        {"preview.show", "--show", "",
         "What the preview shows. surface: the mesh and the spheres beside it. particles: small balls. union: balls "
         "with the radius of the surface. Balls are all alike, or with surface.radius_attribute as large as their "
         "particles say; no other attribute changes them. `betamesh render` always shows a mesh as a surface, and "
         "particle files as balls."},
        {{"surface", ShownGeometry::surface},
         {"particles", ShownGeometry::particles},
         {"union", ShownGeometry::union_}},
        [](Config& c) -> ShownGeometry& { return c.preview.show; }));
    keys.push_back(lengthKey({"preview.particle_radius", "--particle-radius", "",
                              "Radius of the small balls that preview.show particles draws. With "
                              "surface.radius_attribute, that of a particle whose size is surface.spacing."},
                             "", [](Config& c) -> Length& { return c.preview.particle_radius; }));
    keys.push_back(integerKey({"preview.width", "--width", "pixels", "Width of the preview."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.width; }));
    keys.push_back(integerKey({"preview.height", "--height", "pixels", "Height of the preview."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.height; }));
    keys.push_back(integerKey({"preview.samples", "--samples", "rays per pixel",
                               "Number of rays per pixel. More rays give cleaner edges, shadows and motion blur but "
                               "take proportionally longer. "
                               "Noise in shadows is filtered, more strongly with few rays."},
                              1, 4096, false, [](Config& c) -> int& { return c.preview.samples; }));
    keys.push_back(pointKey(
        {"preview.camera_position", "--camera-position", "world units",
         "Position of the camera. auto: a fixed camera that frames the whole sequence on disk as tightly as possible, "
         "in the direction of azimuth and elevation; the input of a single frame is framed by itself. Drops farther "
         "from the bulk of the surface than the bulk is long are not framed. The log prints this camera as options; "
         "given together with --ground, they avoid reading all frames first."},
        [](Config & c) -> auto& { return c.preview.camera_position; }));
    keys.push_back(pointKey(
        {"preview.look_at", "--look-at", "world units",
         "Point at the centre of the preview. auto: the centre of what the automatic camera frames."},
        [](Config & c) -> auto& { return c.preview.look_at; }));
    keys.push_back(realKey({"preview.azimuth", "--azimuth", "degrees",
                            "Direction of the automatic camera around the vertical axis: 0 looks along -z (+y if z is "
                            "up), 90 looks from +x."},
                           -360, 360, [](Config& c) -> double& { return c.preview.azimuth; }));
    keys.push_back(realKey({"preview.elevation", "--elevation", "degrees",
                            "Angle at which the automatic camera looks down; a negative angle looks up."},
                           -89, 89, [](Config& c) -> double& { return c.preview.elevation; }));
    keys.push_back(realKey({"preview.fov", "--fov", "degrees", "Vertical field of view of the camera."}, 1, 150,
                           [](Config& c) -> double& { return c.preview.fov; }));
    keys.push_back(choiceKey<UpAxis>({"preview.up", "--up", "", "Axis that points up in the preview."},
                                     {{"y", UpAxis::y}, {"z", UpAxis::z}},
                                     [](Config& c) -> UpAxis& { return c.preview.up; }));
    keys.push_back(choiceKey<Shading>({"preview.shading", "--shading", "",
                                       "Lighting. studio: soft light with shadows and a rim light, which shows bumps. "
                                       "zebra: reflected stripes, which are "
                                       "straight where the surface is flat and break at creases."},
                                      {{"studio", Shading::studio}, {"zebra", Shading::zebra}},
                                      [](Config& c) -> Shading& { return c.preview.shading; }));
    keys.push_back(choiceKey<PreviewNormals>({"preview.normals", "--normals", "",
                                              "Shading normals. smooth: normals are interpolated across triangles. "
                                              "flat: every triangle has its own normal."},
                                             {{"smooth", PreviewNormals::smooth}, {"flat", PreviewNormals::flat}},
                                             [](Config& c) -> PreviewNormals& { return c.preview.normals; }));
    keys.push_back(cutKey({"preview.cut", "--cut", "world units",
                           "Cuts the preview open: shows only one side of a plane across an axis, as in z<0.25, and "
                           "the cross-section of the liquid there. none: shows everything."}));
    keys.push_back(realKey({"preview.wireframe", "--wireframe", "pixels", "Wireframe line width; 0 disables it."}, 0,
                           100, [](Config& c) -> double& { return c.preview.wireframe; }));
    keys.push_back(colourKey(
        {"preview.colour", "--colour", "",
         "What the surface is coloured by. plain: a single colour. velocity: dark where slow, pale where fast. kind: "
         "surface blue, bubbles orange, triangles that are both sides of a sheet green, spheres violet. curvature: "
         "convex red, concave blue. component: one colour per connected component. An attribute with three components "
         "is used as a colour, one with a single component as a scale from dark to pale. Balls are coloured by "
         "attributes of "
         "their particles, velocity or kind."}));
    keys.push_back(rangeKey(
        {"preview.colour_range", "--colour-range", "that of the coloured quantity",
         "Values at the two ends of the colour scale. auto: for velocity, from 0 to 2.5 times the root-mean-square "
         "speed of the whole sequence; otherwise the range of each frame, which flickers."},
        [](Config & c) -> auto& { return c.preview.colour_range; }));
    keys.push_back(realKey(
        {"preview.shutter", "--shutter", "frames",
         "Motion blur by velocity: how long the shutter is open, half of it before and half after the frame. 0: no "
         "motion blur; 0.5 is common."},
        0, 10, [](Config& c) -> double& { return c.preview.shutter; }));
    keys.push_back(positiveKey(
        {"preview.fps", "--fps", "frames per second", "Frame rate for motion blur, motion vectors and movies."},
        "a number above 0, at most 10000", 10000, false, [](Config& c) -> double& { return c.preview.fps; }));
    keys.push_back(groundKey(
        {"preview.ground", "--ground", "world units",
         "Height of a ground plane that receives shadows: darker in .png, the channel `shadow` in .exr. auto: just "
         "below everything that the automatic camera frames. none: no ground."}));
}

}  // namespace betamesh
