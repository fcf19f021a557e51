// The table of keys. A new key is a member of Config and a row here; everything else follows.

#include "batch/config.h"
#include "batch/frames.h"
#include "batch/plane.h"
#include "core/error.h"
#include "io/curve_file.h"
#include "io/particle_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

namespace betamesh {
namespace {

using Kind = ConfigKey::Kind;

struct Words {
    std::string path, option, unit, reason;
};

ConfigKey keyOf(const Words& words, Kind kind, const std::string& expects,
                std::function<std::string(const Config&)> get,
                std::function<void(Config&, const std::string& value)> set) {
    return {words.path, words.option, kind, expects, words.unit, words.reason, std::move(get), std::move(set)};
}

[[noreturn]] void failValue(const std::string& value, const std::string& expects) {
    throw Error("'" + value + "' was found; expected " + expects);
}

template <typename Number>
std::optional<Number> numberOf(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// The shortest text that reads back as the same number.
std::string textOf(double number) {
    std::array<char, 64> buffer{};
    const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    return {buffer.data(), end};
}

template <typename Member>
const auto& read(const Config& config, Member member) {
    return member(const_cast<Config&>(config));  // members are plain accessors: they change nothing
}

template <typename Member>
ConfigKey textKey(const Words& words, const std::string& expects, Member member,
                  std::function<void(const std::string&)> check = {}) {
    return keyOf(
        words, Kind::text, expects, [=](const Config& config) { return read(config, member); },
        [=](Config& config, const std::string& value) {
            if (check) check(value);
            member(config) = value;
        });
}

std::vector<std::string> wordsBetweenCommas(const std::string& text) {
    std::vector<std::string> words;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        word.erase(0, word.find_first_not_of(' '));
        words.push_back(word.substr(0, word.find_last_not_of(' ') + 1));
    }
    return words;
}

/// Names with commas between them; a list in YAML.
template <typename Member>
ConfigKey namesKey(const Words& words, const std::string& expects, Member member,
                   std::function<void(const std::vector<std::string>&)> check = {}) {
    return keyOf(
        words, Kind::names, expects,
        [=](const Config& config) {
            std::string text;
            for (const std::string& name : read(config, member)) text += (text.empty() ? "" : ",") + name;
            return text;
        },
        [=](Config& config, const std::string& value) {
            const std::vector<std::string> names = wordsBetweenCommas(value);
            for (const std::string& name : names)
                if (name.empty() || std::count(names.begin(), names.end(), name) > 1) failValue(value, expects);
            if (check) check(names);
            member(config) = names;
        });
}

/// zero_is_auto: the word `auto` stands for the value 0.
template <typename Member>
ConfigKey integerKey(const Words& words, int least, int most, bool zero_is_auto, Member member) {
    const std::string expects = std::string(zero_is_auto ? "auto or " : "") + "a whole number, " +
                                std::to_string(least) + " to " + std::to_string(most);
    return keyOf(
        words, Kind::number, expects,
        [=](const Config& config) {
            const int number = read(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : std::to_string(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<int>(0) : numberOf<int>(value);
            if (!number || (!automatic && (*number < least || *number > most))) failValue(value, expects);
            member(config) = *number;
        });
}

/// Above zero and finite; most included.
template <typename Member>
ConfigKey positiveKey(const Words& words, const std::string& expects, double most, bool zero_is_auto, Member member) {
    return keyOf(
        words, Kind::number, expects,
        [=](const Config& config) {
            const double number = read(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : textOf(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<double>(0) : numberOf<double>(value);
            if (!number || (!automatic && !(*number > 0 && *number <= most))) failValue(value, expects);
            member(config) = *number;
        });
}

/// Any number from least to most.
template <typename Member>
ConfigKey realKey(const Words& words, double least, double most, Member member) {
    const std::string expects = "a number, " + textOf(least) + " to " + textOf(most);
    return keyOf(
        words, Kind::number, expects, [=](const Config& config) { return textOf(read(config, member)); },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (!number || !(*number >= least && *number <= most)) failValue(value, expects);
            member(config) = *number;
        });
}

/// Finite numbers with commas between them, or nothing where the text is anything else.
template <std::size_t count>
std::optional<std::array<double, count>> numbersOf(const std::string& text) {
    const std::vector<std::string> words = wordsBetweenCommas(text);
    if (words.size() != count) return std::nullopt;
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = numberOf<double>(words[i]);
        if (!number || !std::isfinite(*number)) return std::nullopt;
        numbers[i] = *number;
    }
    return numbers;
}

template <std::size_t count>
std::string textOfNumbers(const std::array<double, count>& numbers) {
    std::string text;
    for (const double number : numbers) text += (text.empty() ? "" : ",") + textOf(number);
    return text;
}

/// A point, or `auto`.
template <typename Member>
ConfigKey pointKey(const Words& words, Member member) {
    const std::string expects = "auto or three numbers with commas between them";
    return keyOf(
        words, Kind::names, expects,
        [=](const Config& config) {
            const auto& point = read(config, member);
            return point ? textOfNumbers(*point) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<3>(value);
            if (!numbers && value != "auto") failValue(value, expects);
            member(config) = numbers;
        });
}

/// The ends of a scale, or `auto`.
template <typename Member>
ConfigKey rangeKey(const Words& words, Member member) {
    const std::string expects = "auto or two numbers with a comma between them, the lower one first";
    return keyOf(
        words, Kind::names, expects,
        [=](const Config& config) {
            const auto& range = read(config, member);
            return range[1] > range[0] ? textOfNumbers(range) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<2>(value);
            if (value != "auto" && !(numbers && (*numbers)[1] > (*numbers)[0])) failValue(value, expects);
            member(config) = numbers.value_or(std::array<double, 2>{0, 0});
        });
}

template <typename Member>
ConfigKey booleanKey(const Words& words, Member member) {
    const std::string expects = "true or false";
    return keyOf(
        words, Kind::boolean, expects,
        [=](const Config& config) { return std::string(read(config, member) ? "true" : "false"); },
        [=](Config& config, const std::string& value) {
            if (value != "true" && value != "false") failValue(value, expects);
            member(config) = value == "true";
        });
}

template <typename Choice>
using Choices = std::vector<std::pair<std::string, Choice>>;

template <typename Choice, typename Member>
ConfigKey choiceKey(const Words& words, const Choices<Choice>& choices, Member member) {
    std::string expects = choices.size() > 1 ? "one of" : "the word";
    for (const auto& choice : choices) expects += ' ' + choice.first;
    return keyOf(
        words, Kind::choice, expects,
        [=](const Config& config) {
            return std::find_if(choices.begin(), choices.end(),
                                [&](const auto& choice) { return choice.second == read(config, member); })
                ->first;
        },
        [=](Config& config, const std::string& value) {
            const auto found =
                std::find_if(choices.begin(), choices.end(), [&](const auto& choice) { return choice.first == value; });
            if (found == choices.end()) failValue(value, expects);
            member(config) = found->second;
        });
}

/// "0.02" or "1.5dx". zero: the word that stands for the value 0; "0" itself, or empty where there is none.
template <typename Member>
ConfigKey lengthKey(const Words& words, const std::string& zero, Member member) {
    const std::string expects =
        (zero.empty() ? "" : zero + ", ") + "a number above 0, or a multiple of the spacing such as 1.5dx";
    return keyOf(
        words, Kind::number, expects,
        [=](const Config& config) {
            const LengthText& length = read(config, member);
            if (!zero.empty() && length.value == 0) return zero;
            return textOf(length.value) + (length.in_spacings ? "dx" : "");
        },
        [=](Config& config, const std::string& value) {
            const bool in_spacings = value.ends_with("dx");
            const auto number =
                numberOf<double>(std::string_view(value).substr(0, value.size() - (in_spacings ? 2 : 0)));
            if ((!zero.empty() && value == zero) || (zero == "0" && number == 0.0)) {
                member(config) = {0, false};
                return;
            }
            if (!number || !(*number > 0) || !std::isfinite(*number)) failValue(value, expects);
            member(config) = {*number, in_spacings};
        });
}

struct ByteUnit {
    std::string_view name;
    double bytes;
};
constexpr std::array<ByteUnit, 6> kByteUnits{
    {{"TiB", 0x1p40}, {"GiB", 0x1p30}, {"MiB", 0x1p20}, {"TB", 1e12}, {"GB", 1e9}, {"MB", 1e6}}};

/// "16GiB"; zero is `auto`.
template <typename Member>
ConfigKey bytesKey(const Words& words, Member member) {
    const std::string expects = "auto or a size from 1MiB to 1024TiB with its unit (MiB GiB TiB MB GB TB)";
    return keyOf(
        words, Kind::number, expects,
        [=](const Config& config) {
            const std::uint64_t bytes = read(config, member);
            if (bytes == 0) return std::string("auto");
            for (const ByteUnit& unit : kByteUnits) {
                const auto unit_bytes = static_cast<std::uint64_t>(unit.bytes);
                if (bytes % unit_bytes == 0) return std::to_string(bytes / unit_bytes) + std::string(unit.name);
            }
            return textOf(static_cast<double>(bytes) / 0x1p20) + "MiB";
        },
        [=](Config& config, const std::string& value) {
            if (value == "auto") {
                member(config) = 0;
                return;
            }
            for (const ByteUnit& unit : kByteUnits) {
                if (!value.ends_with(unit.name)) continue;
                const auto number =
                    numberOf<double>(std::string_view(value).substr(0, value.size() - unit.name.size()));
                if (!number || !(*number * unit.bytes >= 0x1p20 && *number * unit.bytes <= 0x1p50)) break;
                member(config) = static_cast<std::uint64_t>(*number * unit.bytes);
                return;
            }
            failValue(value, expects);
        });
}

void checkInputPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    requireParticleExtension(path);
}

void checkOutputPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    requireCurveExtension(path);  // meshes have no more
}

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

ConfigKey colourKey(const Words& words) {
    return keyOf(
        words, Kind::text, "plain, velocity, kind, curvature, component, or the name of an attribute of the mesh",
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

ConfigKey groundKey(const Words& words) {
    using Ground = Config::Preview::Ground;
    const std::string expects = "auto, none or a number";
    return keyOf(
        words, Kind::text, expects,
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

void addPreviewKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"preview.path", "", "",
         "Pictures of the meshes, one a frame, to look at: .png as it is, .exr with depth, normals, positions, motion "
         "and ids beside it. Empty: none."},
        "a path ending in .png or .exr, with a place for the frame number as in input.path; or empty",
        [](Config& c) -> std::string& { return c.preview.path; }, checkPreviewPath));
    keys.push_back(choiceKey<Show>(
        {"preview.show", "--show", "",
         "surface: the mesh and the spheres beside it. particles: small balls. union: balls of the surface's radius, "
         "the ground truth. `render` shows a mesh as a surface whatever this says, and particles never."},
        {{"surface", Show::surface}, {"particles", Show::particles}, {"union", Show::union_}},
        [](Config& c) -> Show& { return c.preview.show; }));
    keys.push_back(lengthKey({"preview.particle_radius", "--particle-radius",
                              "world units, or particle spacings with dx", "Of the balls that show particles."},
                             "", [](Config& c) -> LengthText& { return c.preview.particle_radius; }));
    keys.push_back(integerKey({"preview.width", "--width", "pixels", "Of the picture."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.width; }));
    keys.push_back(integerKey({"preview.height", "--height", "pixels", "Of the picture."}, 16, 16384, false,
                              [](Config& c) -> int& { return c.preview.height; }));
    keys.push_back(integerKey({"preview.samples", "--samples", "rays",
                               "Of each pixel. More make edges, shadows and blur smoother; the time grows with them."},
                              1, 4096, false, [](Config& c) -> int& { return c.preview.samples; }));
    keys.push_back(pointKey(
        {"preview.camera_position", "--camera-position", "world units",
         "auto: as near as has every frame of the sequence on disk in the picture, in the "
         "direction of azimuth and elevation. The log says where that is; given back with --ground, no frame need be "
         "read to find it."},
        [](Config & c) -> auto& { return c.preview.camera_position; }));
    keys.push_back(pointKey(
        {"preview.look_at", "--look-at", "world units",
         "The point in the middle of the picture. auto: the middle of the sequence."},
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
                   "everything in the sequence. none: no shadows fall on what is not there."}));
}

void checkFrames(const std::string& frames) {
    if (frames != "all") parseFrames(frames);
}

std::vector<ConfigKey> makeKeys() {
    std::vector<ConfigKey> keys;
    keys.push_back(textKey(
        {"input.path", "", "",
         "The particles, one file a frame. The frame number stands at #### or @@@@ (a digit each), %04d, "
         "$F4 or $F; numbers with more digits are written in full. A relative path starts at the folder "
         "in which the command runs."},
        "a path ending in .vdb, .bgeo, .bgeo.gz or .ply; needed by `run`",
        [](Config& c) -> std::string& { return c.input.path; }, checkInputPath));
    keys.push_back(textKey({"input.velocity", "--velocity", "world units per second",
                            "The attribute that is the velocity. Empty: the first of v, velocity, vel; where none "
                            "exists, zero velocities are written and a warning says so. A name given here must exist."},
                           "the name of an attribute with three components, or empty",
                           [](Config& c) -> std::string& { return c.input.velocity; }));
    keys.push_back(textKey(
        {"input.id", "--id", "",
         "The attribute that stays with a particle from frame to frame. Empty: id, where it exists. A "
         "name given here must exist."},
        "the name of a whole-number attribute, or empty", [](Config& c) -> std::string& { return c.input.id; }));
    keys.push_back(textKey(
        {"frames", "--frames", "",
         "Which frames to mesh; all: every frame found on disk. A step is written x, as in 1-100x2; ':' "
         "is refused because farm engines disagree about it."},
        "all, or frames such as 12, 1-100, 1-100x2, -5--1, 1-10,15,20-30",
        [](Config& c) -> std::string& { return c.frames; }, checkFrames));
    keys.push_back(
        lengthKey({"surface.radius", "--radius", "world units, or particle spacings with dx",
                   "Of the balls. The paper uses 1.5 spacings: large enough to close the surface over still "
                   "liquid. Larger is smoother and joins drops earlier; smaller keeps detail and opens holes."},
                  "", [](Config& c) -> LengthText& { return c.surface.radius; }));
    keys.push_back(
        positiveKey({"surface.spacing", "--spacing", "world units",
                     "What dx stands for: the distance at which the simulation seeded its particles. auto: radius "
                     "/ 1.5 where the radius is a plain number, otherwise measured once, in the first frame on "
                     "disk that has seven distinct particles."},
                    "auto or a number above 0", std::numeric_limits<double>::max(), true,
                    [](Config& c) -> double& { return c.surface.spacing; }));
    keys.push_back(choiceKey<SurfaceKind>(
        {"surface.kind", "--surface", "",
         "beta: the method's result. alpha: triangles between the particles themselves, quick and rough. union: the "
         "balls "
         "as they are, the ground truth to look at."},
        {{"beta", SurfaceKind::beta}, {"alpha", SurfaceKind::alpha}, {"union", SurfaceKind::union_}},
        [](Config& c) -> SurfaceKind& { return c.surface.kind; }));
    keys.push_back(integerKey(
        {"surface.dimension", "--dimension", "",
         "3: balls and closed meshes. 2: discs and closed curves, for particles that all have the same z; written as "
         ".ply edges, .bgeo polylines, .obj lines, or drawn as .svg."},
        2, 3, false, [](Config& c) -> int& { return c.surface.dimension; }));
    keys.push_back(choiceKey<Tessellation>(
        {"surface.tessellation", "--tessellation", "",
         "How the faces become triangles. complete: all of them, so that the mesh is closed and manifold, and holds "
         "every sheet, tendril and drop. paper: fans around one vertex a face; drops and tendrils of single "
         "particles become spheres beside the mesh."},
        {{"complete", Tessellation::complete}, {"paper", Tessellation::paper}},
        [](Config& c) -> Tessellation& { return c.surface.tessellation; }));
    keys.push_back(integerKey({"surface.arc_subdivisions", "--arc-subdivisions", "segments",
                               "Complete tessellation: how finely the arcs between neighbouring balls are cut, and the "
                               "faces with them; in two dimensions an eighth of how often a circle is cut. auto: so "
                               "that no arc is missed by more than 0.01 radii. 1 makes meshes small."},
                              1, 64, true, [](Config& c) -> int& { return c.surface.arc_subdivisions; }));
    keys.push_back(choiceKey<PredicateKind>({"surface.predicates", "--predicates", "",
                                             "exact: signs are computed exactly and ties broken by rule, which never "
                                             "fails. float: the paper's test in double "
                                             "precision, repeated on jittered particles while its result is invalid."},
                                            {{"exact", PredicateKind::exact}, {"float", PredicateKind::floating}},
                                            [](Config& c) -> PredicateKind& { return c.surface.predicates; }));
    keys.push_back(lengthKey(
        {"surface.inset", "--inset", "world units, or particle spacings with dx",
         "Takes the surface inwards, less where the liquid is thin: the balls reach a radius beyond their particles, "
         "so "
         "sheets are two radii thick. At most the radius less half a spacing, which leaves half a spacing of liquid "
         "round the outermost particles. 0 keeps the volume of the balls."},
        "0", [](Config& c) -> LengthText& { return c.surface.inset; }));
    keys.push_back(booleanKey(
        {"surface.resolve_intersections", "--resolve-intersections", "",
         "The paper's step 4, for its tessellation: move vertices out to particles that smoothing left outside. The "
         "complete tessellation leaves none outside."},
        [](Config& c) -> bool& { return c.surface.resolve_intersections; }));
    keys.push_back(integerKey({"perturbation.retries", "--retries", "",
                               "float predicates only: how often a frame is jittered and tried again before it fails."},
                              0, 100, false, [](Config& c) -> int& { return c.perturbation.retries; }));
    keys.push_back(positiveKey(
        {"perturbation.tolerance", "--tolerance", "multiples of the radius",
         "float predicates only: the size of the jitter. Larger succeeds sooner and moves the surface "
         "more."},
        "a number above 0, at most 0.1", 0.1, false, [](Config& c) -> double& { return c.perturbation.tolerance; }));
    keys.push_back(choiceKey<SmoothingMethod>(
        {"smoothing.method", "--smoothing", "",
         "coherent: vertices move onto spheres fitted to the surface round them, which calms "
         "the bumps of the balls, keeps drops and sheets, and never jumps in time. paper: to "
         "the weighted centroids of the faces around them, on the paper's tessellation. "
         "none: they stay on the balls."},
        {{"coherent", SmoothingMethod::coherent}, {"paper", SmoothingMethod::paper}, {"none", SmoothingMethod::none}},
        [](Config& c) -> SmoothingMethod& { return c.smoothing.method; }));
    keys.push_back(lengthKey(
        {"smoothing.width", "--smoothing-width", "world units, or particle spacings with dx",
         "Coherent smoothing: how far around it a vertex looks. Bumps much shorter than this vanish, waves twice as "
         "long stay. auto: 2.8 radii, which is 4.2dx at the default radius."},
        "auto", [](Config& c) -> LengthText& { return c.smoothing.width; }));
    keys.push_back(
        integerKey({"smoothing.passes", "--passes", "",
                    "How often the surface is smoothed. The paper uses 1; each further pass costs detail and "
                    "volume."},
                   0, 100, false, [](Config& c) -> int& { return c.smoothing.passes; }));
    keys.push_back(choiceKey<Droplets>(
        {"features.droplets", "--droplets", "",
         "What becomes of droplets, groups of few particles whose balls meet each other and no others. mesh: they get "
         "a "
         "surface like everything else. points: they are left out of the mesh, and their particles written beside it "
         "as NAME.spheres.EXT with position, radius, velocity and id, to be rendered as spheres. drop: they are left "
         "out."},
        {{"mesh", Droplets::mesh}, {"points", Droplets::points}, {"drop", Droplets::drop}},
        [](Config& c) -> Droplets& { return c.features.droplets; }));
    keys.push_back(integerKey(
        {"features.droplet_particles", "--droplet-particles", "particles",
         "Groups of fewer particles are droplets. All particles count, also those inside; several at one place are "
         "one. 8 make a cube two spacings wide, what a FLIP solver seeds in one cell."},
        1, 1000000000, false, [](Config& c) -> int& { return c.features.droplet_particles; }));
    keys.push_back(choiceKey<Tendrils>(
        {"features.tendrils", "--tendrils", "",
         "What becomes of threads a single particle thick: particles in no triangle of the alpha mesh whose balls meet "
         "others. mesh: they get a surface. points: they are left out of the mesh and written as spheres beside it. "
         "What they held together stays in the mesh, however small."},
        {{"mesh", Tendrils::mesh}, {"points", Tendrils::points}},
        [](Config& c) -> Tendrils& { return c.features.tendrils; }));
    keys.push_back(choiceKey<Bubbles>(
        {"features.bubbles", "--bubbles", "",
         "What becomes of small voids inside the liquid. mesh: they get a surface that faces inwards. fill: they, and "
         "what is in them, are left out of the mesh; complete tessellation only. The rest of the mesh stays as it is."},
        {{"mesh", Bubbles::mesh}, {"fill", Bubbles::fill}}, [](Config& c) -> Bubbles& { return c.features.bubbles; }));
    keys.push_back(positiveKey(
        {"features.bubble_volume", "--bubble-volume", "spacings cubed",
         "Voids of less volume, before smoothing and inset, are filled. One spacing cubed is what a particle stands "
         "for, "
         "so that 8 treats bubbles as features.droplet_particles treats droplets. The balls narrow a void by a radius "
         "all round: 8 is a gap in the particles about 5 spacings wide."},
        "a number above 0", std::numeric_limits<double>::max(), false,
        [](Config& c) -> double& { return c.features.bubble_volume; }));
    keys.push_back(textKey(
        {"output.path", "", "",
         "The meshes, one file a frame, with a place for the frame number as in input.path. Beside each "
         "stand NAME.json, its report, and NAME.spheres.EXT where particles are left out of the mesh as spheres."},
        "a path ending in .ply, .bgeo, .bgeo.gz or .obj, in two dimensions also .svg; needed by `run`",
        [](Config& c) -> std::string& { return c.output.path; }, checkOutputPath));
    keys.push_back(namesKey(
        {"output.attributes", "--attributes", "",
         "Attributes of the particles, such as Cd or temperature, that the mesh's vertices get too: means over the "
         "particles near them; whole numbers from the nearest. Accelerations (accel, acceleration) are carried "
         "unasked."},
        "names of attributes that every input has, each once, with commas between them; or empty",
        [](Config& c) -> std::vector<std::string>& { return c.output.attributes; }));
    keys.push_back(booleanKey(
        {"output.components", "--components", "",
         "Numbers the connected pieces of each mesh by volume, 0 the largest, bubbles last: a whole number `component` "
         "of every face in .ply and of every primitive in .bgeo, objects component_N in .obj. Numbers change from "
         "frame to frame."},
        [](Config& c) -> bool& { return c.output.components; }));
    keys.push_back(namesKey(
        {"picture.layers", "--layers", "",
         "What an .svg shows, in two dimensions. discs: their union. particles: dots. alpha: the alpha mesh. before: "
         "the curves before smoothing, dotted. beta: the curves. vertices: theirs, pure beta vertices red, alphabeta "
         "vertices blue."},
        "some of discs, particles, alpha, before, beta, vertices, each once, with commas between them",
        [](Config& c) -> std::vector<std::string>& { return c.picture.layers; }, [](const auto& n) { layersOf(n); }));
    keys.push_back(textKey(
        {"picture.bounds", "--bounds", "world units",
         "The part of the plane that an .svg shows: lowest x, lowest y, highest x, highest y. auto: all discs, of each "
         "frame for itself."},
        "auto or four numbers with commas between them", [](Config& c) -> std::string& { return c.picture.bounds; },
        [](const std::string& text) { boundsOf(text); }));
    addPreviewKeys(keys);
    keys.push_back(integerKey(
        {"run.frames_in_flight", "--frames-in-flight", "frames",
         "How many frames are worked on at once, at most; fewer where memory is short. auto: as many as there "
         "are threads. The meshes do not depend on it."},
        1, 4096, true, [](Config& c) -> int& { return c.run.frames_in_flight; }));
    keys.push_back(
        integerKey({"run.threads", "-j,--threads", "threads",
                    "auto: the processors this process may use, or fewer if SLURM_CPUS_PER_TASK or CUE_THREADS "
                    "says so. The meshes do not depend on it."},
                   1, 4096, true, [](Config& c) -> int& { return c.run.threads; }));
    keys.push_back(
        integerKey({"run.retries", "--io-retries", "",
                    "How often reading or writing a frame is tried again, after a short wait, before the frame "
                    "fails: shared disks stumble."},
                   0, 100, false, [](Config& c) -> int& { return c.run.retries; }));
    keys.push_back(
        choiceKey<OnMissing>({"run.on_missing", "--on-missing", "",
                              "What a frame without an input file is. error: it fails, the others are written. skip: "
                              "it is left out. empty: an "
                              "empty mesh is written for it."},
                             {{"error", OnMissing::error}, {"skip", OnMissing::skip}, {"empty", OnMissing::empty}},
                             [](Config& c) -> OnMissing& { return c.run.on_missing; }));
    keys.push_back(bytesKey(
        {"run.memory_limit", "--memory-limit", "bytes",
         "For all frames at once. Frames wait until there is room for them, by the sizes of their files and by "
         "what earlier ones took. auto: what the machine, its container or Slurm grants. A size is also "
         "enforced: a frame that needs more even alone fails, and the job ends with exit code 33."},
        [](Config& c) -> std::uint64_t& { return c.run.memory_limit; }));
    return keys;
}

/// Levenshtein's distance: single characters inserted, removed or replaced.
std::size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

std::string_view lastWord(std::string_view path) { return path.substr(path.rfind('.') + 1); }

/// Empty at the top level.
std::string_view sectionOf(std::string_view path) { return path.substr(0, path.size() - lastWord(path).size()); }

}  // namespace

const std::vector<ConfigKey>& configKeys() {
    static const std::vector<ConfigKey> keys = makeKeys();
    return keys;
}

std::string nearestConfigKey(std::string_view unknown) {
    std::vector<std::string> names{"version", "include"};
    for (const ConfigKey& key : configKeys()) {
        names.push_back(key.path);
        const std::string section = key.path.substr(0, key.path.find('.'));
        if (section != key.path && section != names[names.size() - 2]) names.push_back(section);
    }
    // A right word in a wrong section is nearer than a wrong word in the right one; between equals the whole path
    // decides.
    constexpr std::size_t kWrongSection = 2;
    const auto distance = [&](const std::string& name) {
        const std::size_t words = editDistance(lastWord(unknown), lastWord(name));
        const std::size_t whole = editDistance(unknown, name);
        return std::pair(words + (sectionOf(unknown) == sectionOf(name) ? 0 : kWrongSection), whole);
    };
    return *std::min_element(names.begin(), names.end(),
                             [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
}

void setConfigKey(Config& config, const std::string& path, const std::string& value, const std::string& where) {
    const auto& keys = configKeys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.path == path; });
    if (key == keys.end()) {
        throw Error(where + ": unknown key '" + path + "'; the nearest known key is '" + nearestConfigKey(path) + "'");
    }
    try {
        key->set(config, value);
    } catch (const Error& error) {
        throw Error(where + ": " + path + ": " + error.what());
    }
}

void setConfigKey(Config& config, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw Error("--set " + assignment + ": expected key=value, such as surface.radius=1.5dx");
    }
    setConfigKey(config, assignment.substr(0, equals), assignment.substr(equals + 1), "--set " + assignment);
}

}  // namespace betamesh
