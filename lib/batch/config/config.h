// Everything a job can be told, and where each word of it comes from.

#pragma once

#include "render/render_settings.h"
#include "skin/pipeline.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// A length in world units or in particle spacings.
struct LengthText {
    double value = 1.5;
    bool in_spacings = true;
    bool operator==(const LengthText&) const = default;
};

enum class OnMissing { error, skip, empty };

/// What a picture of a frame shows.
enum class ShownGeometry {
    surface,
    particles,  ///< small balls
    union_      ///< balls of the surface's radius
};
enum class PreviewNormals { smooth, flat };
enum class UpAxis { y, z };

/// One job. The defaults are these initialisers; configKeys() says what each means.
/// Zero stands for `auto` in spacing, arc_subdivisions, smoothing.width, bubble_volume, frames_in_flight, threads and
/// memory_limit.
struct Config {
    std::vector<std::string> preset;  ///< names; their settings are in the other keys already
    struct Input {
        std::string path;
        std::string velocity;
        std::string id;
    } input;
    std::string frames = "all";
    struct Surface {
        LengthText radius;
        double spacing = 0;
        SurfaceKind kind = SurfaceKind::beta;
        int dimension = 3;
        Tessellation tessellation = Tessellation::complete;
        int arc_subdivisions = 0;
        PredicateKind predicates = PredicateKind::exact;
        std::optional<LengthText> skin;   ///< none: auto; 0: the surface of the balls
        std::optional<LengthText> inset;  ///< another way to say the skin: the radius less this; deprecated
        bool resolve_intersections = false;
    } surface;
    struct Perturbation {
        int retries = 3;
        double tolerance = 1e-5;
    } perturbation;
    struct Smoothing {
        SmoothingMethod method = SmoothingMethod::coherent;
        LengthText width{0, false};
        int passes = 1;
    } smoothing;
    struct Features {
        Droplets droplets = Droplets::mesh;
        int droplet_particles = 8;
        Tendrils tendrils = Tendrils::mesh;
        std::optional<Bubbles> bubbles;  ///< none: fill where bubbles can be filled
        LengthText bubble_gap{5, true};
        double bubble_volume = 0;  ///< instead of bubble_gap; spacings cubed, in two dimensions squared; 0: not given
    } features;
    struct Output {
        std::string path;
        std::vector<std::string> attributes;
        bool components = false;
    } output;
    struct Picture {
        std::vector<std::string> layers{"discs", "particles", "alpha", "beta"};
        std::string bounds = "auto";
    } picture;
    struct Preview {
        std::string path;
        ShownGeometry show = ShownGeometry::surface;
        LengthText particle_radius{0.5, true};
        int width = 1920;
        int height = 1080;
        int samples = 8;
        std::optional<std::array<double, 3>> camera_position;  ///< none: auto
        std::optional<std::array<double, 3>> look_at;          ///< none: auto
        double azimuth = 30;
        double elevation = 20;
        double fov = 30;
        UpAxis up = UpAxis::y;
        Shading shading = Shading::studio;
        PreviewNormals normals = PreviewNormals::smooth;
        std::optional<CutawayPlane> cut;
        double wireframe = 0;
        Colouring colouring;                       ///< its range is that below
        std::array<double, 2> colour_range{0, 0};  ///< equal: auto
        double shutter = 0;
        double fps = 24;
        enum class Ground { automatic, none, given } ground = Ground::automatic;
        double ground_height = 0;  ///< of a given one
    } preview;
    struct Run {
        int frames_in_flight = 0;
        int threads = 0;
        int retries = 1;
        double timeout = 0;  ///< seconds; 0: none
        OnMissing on_missing = OnMissing::error;
        std::uint64_t memory_limit = 0;
        std::string scratch;  ///< empty: beside the output
    } run;
};

/// One key: the row from which YAML, --set, command line options, `config print` and default.yaml come.
struct ConfigKey {
    enum class Kind { text, names, number, choice, boolean };

    std::string path;    ///< "surface.radius"
    std::string option;  ///< "--radius"; empty where the command line gives the value in another way
    Kind kind = Kind::text;
    std::string expects;                            ///< type and range in words: "a whole number, 0 to 100"
    std::string unit;                               ///< empty where there is none
    std::string reason;                             ///< what it does and why one would change it
    std::function<std::string(const Config&)> get;  ///< as text that set() reads back
    std::function<void(Config&, const std::string& value)> set;  ///< throws Error with what was found and expected
    std::string replaced_by{};  ///< the key to use instead; empty: this one is not deprecated
};

/// All keys, in the order in which they are printed; those of one section stand together.
const std::vector<ConfigKey>& configKeys();

/// The known key or section that was most likely meant.
std::string nearestConfigKey(std::string_view unknown);

/// A value for a key from the command line.
struct KeyValue {
    std::string path, value;
    std::string where;  ///< its origin in errors: "--radius", "--set surface.radius=1.5dx"
};

/// From `a.b=c`, as --set takes it.
KeyValue keyValueOf(const std::string& assignment);

/// Sets one key by its path. `where` names the origin in errors: "--set", "splash.yaml:4:11". `preset` sets all keys of
/// the presets at once, so it comes before the keys that are to win.
void setConfigKey(Config& config, const std::string& path, const std::string& value, const std::string& where);

/// Sets one key from `a.b=c`.
void setConfigKey(Config& config, const std::string& assignment);

/// The whole configuration of a job. The later value wins: base, presets, included files in their order, the keys of
/// the pipeline file, those of the command line in their order. A `preset` of the command line replaces that of the
/// file, and that of a file those of the files it includes.
///
/// in      file of the pipeline; empty: none
/// errors  file, line and column of an unknown key (and the nearest known one), a key given twice, a wrong
///         type, an impossible value, a missing or circular include, YAML that cannot be read; an unknown preset
Config readConfig(const std::filesystem::path& file, const std::vector<KeyValue>& command_line = {},
                  const Config& base = {});

/// A pipeline file with every key, its unit, range and reason, but for deprecated ones that are not given; readConfig()
/// gives the same Config back.
std::string printConfig(const Config& config);

}  // namespace betamesh
