// The keys of pictures in three dimensions.

#include "batch/config/kinds.h"
#include "batch/config/tables.h"
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
const Choices<ColourBy> kColourings{{"plain", ColourBy::nothing},
                                    {"velocity", ColourBy::velocity},
                                    {"kind", ColourBy::kind},
                                    {"curvature", ColourBy::curvature},
                                    {"component", ColourBy::component}};

ConfigKey colourKey(const KeyWords& words) {
    return keyOf(
        words, ConfigKey::Kind::text,
        "plain, velocity, kind, curvature, component, or the name of an attribute of the mesh",
        [](const Config& config) {
            const Colouring& colouring = config.preview.colouring;
            for (const auto& [name, by] : kColourings)
                if (by == colouring.by) return name;
            return colouring.attribute;
        },
        [](Config& config, const std::string& value) {
            Colouring& colouring = config.preview.colouring;
            colouring = {ColourBy::attribute, value};
            for (const auto& [name, by] : kColourings)
                if (name == value) colouring = {by, ""};
            if (value.empty()) failValue(value, "plain, or what to colour by");
        });
}

ConfigKey cutKey(const KeyWords& words) {
    const std::string expects = "none, or an axis, < or >, and a number, such as z<0.25";
    return keyOf(
        words, ConfigKey::Kind::text, expects,
        [](const Config& config) {
            const auto& cut = config.preview.cut;
            return cut ? std::string(1, "xyz"[cut->axis]) + (cut->below ? '<' : '>') + textOf(cut->at) : "none";
        },
        [=](Config& config, const std::string& value) {
            if (value == "none") return config.preview.cut.reset();
            const std::size_t axis = std::string_view("xyz").find(value.empty() ? ' ' : value[0]);
            const auto at = numberOf<double>(std::string_view(value).substr(std::min<std::size_t>(2, value.size())));
            if (axis > 2 || value.size() < 3 || (value[1] != '<' && value[1] != '>') || !at || !std::isfinite(*at))
                failValue(value, expects);
            config.preview.cut = CutawayPlane{static_cast<int>(axis), value[1] == '<', *at};
        });
}

ConfigKey groundKey(const KeyWords& words) {
    using Ground = Config::Preview::Ground;
    const std::string expects = "auto, none or a number";
    return keyOf(
        words, ConfigKey::Kind::text, expects,
        [](const Config& config) {
            const Config::Preview& preview = config.preview;
            if (preview.ground == Ground::given) return textOf(preview.ground_height);
            return std::string(preview.ground == Ground::none ? "none" : "auto");
        },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (number ? !std::isfinite(*number) : value != "auto" && value != "none") failValue(value, expects);
            config.preview.ground = number ? Ground::given : value == "none" ? Ground::none : Ground::automatic;
            config.preview.ground_height = number.value_or(0);
        });
}

}  // namespace

void addPreviewKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"preview.path", "", "",
         "Pictures of the meshes, one a frame, to look at: .png as it is, .exr with depth, normals, positions, motion "
         "and ids beside it. Empty: none."},
        "a path ending in .png or .exr, with a place for the frame number as in input.path; or empty",
        [](Config& c) -> std::string& { return c.preview.path; }, checkPreviewPath));
    keys.push_back(choiceKey<ShownGeometry>(
        {"preview.show", "--show", "",
         "surface: the mesh and the spheres beside it. particles: small balls. union: balls of the surface's radius, "
         "the ground truth. `render` shows a mesh as a surface whatever this says, and particles never."},
        {{"surface", ShownGeometry::surface},
         {"particles", ShownGeometry::particles},
         {"union", ShownGeometry::union_}},
        [](Config& c) -> ShownGeometry& { return c.preview.show; }));
    keys.push_back(lengthKey({"preview.particle_radius", "--particle-radius",
                              "world units, or particle spacings with dx", "Of the balls that show particles."},
                             "", [](Config& c) -> LengthText& { return c.preview.particle_radius; }));
    keys.push_back(integerKey({"preview.width", "--width", "pixels", "Of the picture."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.width; }));
    keys.push_back(integerKey({"preview.height", "--height", "pixels", "Of the picture."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.height; }));
    keys.push_back(integerKey({"preview.samples", "--samples", "rays",
                               "Of each pixel. More make edges, shadows and blur finer; the time grows with them. The grain of few is "
                               "averaged out of shadows, less the more there are."},
                              1, 4096, false, [](Config& c) -> int& { return c.preview.samples; }));
    keys.push_back(pointKey(
        {"preview.camera_position", "--camera-position", "world units",
         "auto: one still camera that frames every frame of the sequence on disk as tightly as it can, in the "
         "direction of azimuth and elevation. Drops that are farther from the bulk of their frame's surface than that "
         "is long are not framed. The log says where the camera is; given back with --ground, no frame need be read to "
         "find it. The input of a single frame is framed by itself."},
        [](Config & c) -> auto& { return c.preview.camera_position; }));
    keys.push_back(pointKey(
        {"preview.look_at", "--look-at", "world units",
         "The point in the middle of the picture. auto: the middle of what an automatic camera frames."},
        [](Config & c) -> auto& { return c.preview.look_at; }));
    keys.push_back(realKey({"preview.azimuth", "--azimuth", "degrees",
                            "Where an automatic camera stands, round the vertical: 0 looks along -z (+y where z is "
                            "up), 90 from +x."},
                           -360, 360, [](Config& c) -> double& { return c.preview.azimuth; }));
    keys.push_back(realKey(
        {"preview.elevation", "--elevation", "degrees", "How far an automatic camera looks down; below 0 it looks up."},
        -89, 89, [](Config& c) -> double& { return c.preview.elevation; }));
    keys.push_back(realKey(
        {"preview.fov", "--fov", "degrees", "What the camera sees from the lower to the upper edge of the picture."}, 1,
        150, [](Config& c) -> double& { return c.preview.fov; }));
    keys.push_back(choiceKey<UpAxis>({"preview.up", "--up", "", "The axis that points upwards in the picture."},
                                     {{"y", UpAxis::y}, {"z", UpAxis::z}},
                                     [](Config& c) -> UpAxis& { return c.preview.up; }));
    keys.push_back(choiceKey<Shading>(
        {"preview.shading", "--shading", "",
         "studio: a soft light with shadows and a rim light, which show bumps. zebra: stripes reflected, which are "
         "straight where the surface is flat and break where it has creases."},
        {{"studio", Shading::studio}, {"zebra", Shading::zebra}},
        [](Config& c) -> Shading& { return c.preview.shading; }));
    keys.push_back(choiceKey<PreviewNormals>(
        {"preview.normals", "--normals", "", "smooth: as if triangles were round. flat: every triangle as it is."},
        {{"smooth", PreviewNormals::smooth}, {"flat", PreviewNormals::flat}},
        [](Config& c) -> PreviewNormals& { return c.preview.normals; }));
    keys.push_back(cutKey({"preview.cut", "--cut", "world units",
                           "Shows only what lies on one side of a plane across an axis, and where the liquid is cut "
                           "open there: z<0.25. none: all of it."}));
    keys.push_back(
        realKey({"preview.wireframe", "--wireframe", "pixels", "Draws the edges of the triangles, so wide. 0: not."}, 0,
                100, [](Config& c) -> double& { return c.preview.wireframe; }));
    keys.push_back(colourKey(
        {"preview.colour", "--colour", "",
         "velocity: dark where it is slow, pale where it is fast. kind: blue the surface, orange bubbles, green "
         "triangles that are both sides of a sheet, violet spheres. curvature: red bulges, blue hollows. component: "
         "the "
         "connected pieces. An attribute of three numbers is a colour, one of one number goes from dark to pale."}));
    keys.push_back(rangeKey(
        {"preview.colour_range", "--colour-range", "those of what is coloured by",
         "What the ends of the scale stand for. auto: for velocity, from 0 to 2.5 times the usual (root mean square) "
         "speed of the whole sequence; otherwise what each frame has, which flickers."},
        [](Config & c) -> auto& { return c.preview.colour_range; }));
    keys.push_back(realKey({"preview.shutter", "--shutter", "frames",
                            "How long the shutter is open, half of it before the frame and half after: motion blur "
                            "by velocity. 0: none; 0.5 is usual."},
                           0, 10, [](Config& c) -> double& { return c.preview.shutter; }));
    keys.push_back(positiveKey({"preview.fps", "--fps", "frames per second",
                                "How long a frame is, for the shutter, for motion vectors and for movies."},
                               "a number above 0, at most 10000", 10000, false,
                               [](Config& c) -> double& { return c.preview.fps; }));
    keys.push_back(
        groundKey({"preview.ground", "--ground", "world units",
                   "The height of a ground that takes shadows: darker in .png, `shadow` in .exr. auto: just below "
                   "all that an automatic camera frames. none: no shadows fall on what is not there."}));
}

}  // namespace betamesh
