// The configuration of a job: its values, the table of its keys, and how pipeline files are read and printed.

#pragma once

#include "betamesh/skin.h"
#include "io/particle_input.h"
#include "render/render_settings.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

inline constexpr double kDefaultRadiusSpacings = 1.5;  ///< ball radius in particle spacings, as in the paper

/// A length in world units or in particle spacings.
struct Length {
    double value = 0;
    bool in_spacings = false;
    bool operator==(const Length&) const = default;
};

enum class OnMissing { error, skip, empty };  ///< what to do with a frame whose input is missing

/// What a preview shows.
enum class ShownGeometry {
    surface,
    particles,  ///< small balls
    union_      ///< balls with the radius of the surface
};
enum class PreviewNormals { smooth, flat };

/// A key with a value for it.
struct KeyValue {
    std::string path, value;
    std::string where;  ///< where the value comes from, for errors: "--radius", "--set surface.radius=1.5dx"
};

/// The configuration of one job. The initialisers below are the only place where defaults are written; configKeys()
/// explains each member. Zero means `auto` for spacing, arc_subdivisions, smoothing.width, bubble_volume,
/// frames_in_flight, threads and memory_limit.
struct Config {
    std::vector<std::string> preset;  ///< names, already applied to the members below
    struct Input : ParticleInput {    ///< its origin is set when the job is planned, see resolvedLocalOrigin()
        std::string path;
        std::optional<std::array<double, 3>> given_origin;  ///< nullopt: auto
        bool is_one_file = false;  ///< a file holds all frames; set when the job is planned, see inputFrames()
    } input;
    std::string frames = "all";
    struct Surface {
        Length radius{kDefaultRadiusSpacings, true};
        double spacing = 0;
        std::string radius_attribute;
        double radius_scale = 1;
        std::string radius_rate_attribute;
        SurfaceKind kind = SurfaceKind::beta;
        int dimension = 3;
        Tessellation tessellation = Tessellation::complete;
        int arc_subdivisions = 0;
        PredicateKind predicates = PredicateKind::exact;
        std::optional<Length> skin;   ///< nullopt: auto; 0: the surface of the balls
        std::optional<Length> inset;  ///< deprecated: the skin is the radius minus this; nullopt: not set
        std::vector<std::string> walls;
        std::optional<std::array<double, 6>> box;  ///< lowest x, y, z, highest x, y, z; nullopt: none
        bool resolve_intersections = false;
    } surface;
    struct Perturbation {
        int retries = 3;
        double tolerance = 1e-5;
    } perturbation;
    struct Smoothing {
        SmoothingMethod method = SmoothingMethod::coherent;
        Length width{0, false};
        int passes = 1;
    } smoothing;
    struct Features {
        Droplets droplets = Droplets::mesh;
        int droplet_particles = 8;
        Tendrils tendrils = Tendrils::mesh;
        std::optional<Bubbles> bubbles;  ///< nullopt: fill, unless the surface does not allow it
        Length bubble_gap{5, true};
        double bubble_volume = 0;  ///< deprecated, replaces bubble_gap; spacings cubed (2D: squared); 0: not set
    } features;
    struct Output : WriteOptions {  ///< its frame is set for each file
        std::string path;
        std::vector<std::string> attributes;
        std::optional<bool> normals;  ///< nullopt: auto
        std::vector<std::string> surface_attributes;
        bool components = false;
        Length simplify{0, false};  ///< 0: none
        Length voxel{0.5, true};    ///< level_set.voxel is set when the job is planned
    } output;
    struct Picture {
        std::vector<std::string> layers{"discs", "particles", "alpha", "beta"};
        std::string bounds = "auto";
    } picture;
    struct Preview {
        std::string path;
        ShownGeometry show = ShownGeometry::surface;
        Length particle_radius{0.5, true};
        int width = 1920;
        int height = 1080;
        int samples = 8;
        std::optional<std::array<double, 3>> camera_position;  ///< nullopt: auto
        std::optional<std::array<double, 3>> look_at;          ///< nullopt: auto
        double azimuth = 30;
        double elevation = 20;
        double fov = 30;
        UpAxis up = UpAxis::y;
        Shading shading = Shading::studio;
        PreviewNormals normals = PreviewNormals::smooth;
        std::optional<CutawayPlane> cut;
        double wireframe = 0;
        Colouring colouring;                       ///< without its range, which follows
        std::array<double, 2> colour_range{0, 0};  ///< equal: auto
        double shutter = 0;
        double fps = 24;
        enum class Ground { automatic, none, given } ground = Ground::automatic;
        double ground_height = 0;  ///< world units, if ground is given
    } preview;
    struct Run {
        int frames_in_flight = 0;
        int threads = 0;
        int retries = 1;
        double timeout = 0;  ///< seconds per frame; 0: no limit
        OnMissing on_missing = OnMissing::error;
        std::uint64_t memory_limit = 0;
        std::string scratch;  ///< deprecated, has no effect
    } run;

    /// The list `outputs`: for each output of the job the keys that it sets itself, `preset` first. Empty: the members
    /// above are the only output. See outputConfigs().
    std::vector<std::vector<KeyValue>> outputs;

    std::vector<std::filesystem::path> files;  ///< that were read: the pipeline file and those that it includes
};

/// One configuration key. YAML, --set, options, `config print`, default.yaml and the manual are derived from it.
struct ConfigKey {
    enum class Kind { text, list, number, length, choice, boolean };

    std::string path;    ///< "surface.radius"
    std::string option;  ///< "--radius"; empty if no option sets this key
    Kind kind = Kind::text;
    std::string accepts;                                         ///< valid values: "a whole number from 0 to 100"
    std::string unit;                                            ///< empty if the value has no unit or names its own
    std::string help;                                            ///< what the key does and why one would change it
    std::function<std::string(const Config&)> get;               ///< the value as text, which set() reads back
    std::function<void(Config&, const std::string& value)> set;  ///< throws Error that names the valid values
    std::string replaced_by{};                                   ///< for a deprecated key, the key to use instead
    std::vector<std::string> choices{};                          ///< the valid words of a choice
};

/// All keys in the order in which they are printed, section by section.
const std::vector<ConfigKey>& configKeys();

/// The key or section most similar to an unknown one, for error messages.
std::string nearestConfigKey(std::string_view unknown);

/// The key and value in `a.b=c`. option: whose argument it is, for errors.
KeyValue keyValueOf(const std::string& assignment, const std::string& option = "--set");

/// Sets one key. `where` is the place of the value for errors: "--set", "splash.yaml:4:11". Setting `preset` sets
/// all keys of those presets, so it has to come before keys that override them.
void setConfigKey(Config& config, const std::string& path, const std::string& value, const std::string& where);

/// Sets one key from `a.b=c`.
void setConfigKey(Config& config, const std::string& assignment);

/// Sets the keys of a preset (presets.h) and leaves all others unchanged.
void applyPreset(Config& config, std::string_view name);

/// The whole configuration of a job. Later values win, in this order: base, presets, included files one after the
/// other, the keys of the pipeline file, those of the command line one after the other. A `preset` on the command line
/// replaces the `preset` of the file, and that of a file replaces those of the files it includes.
///
/// in      file: a pipeline file; empty: none
/// errors  file, line and column of an unknown key (with the most similar one), a key set twice, a wrong type, an
///         invalid value, a missing or circular include, invalid YAML; an unknown preset
Config readConfig(const std::filesystem::path& file, const std::vector<KeyValue>& command_line = {},
                  const Config& base = {});

/// What is read of the input for a frame. The frame itself is set only where a file holds all frames.
ParticleInput inputOf(const Config& config, int frame);

/// The configuration of each output of a job, in the order of the list `outputs`: `config`, in which the keys of the
/// output override all others, those of the command line too. Without that list, `config` alone.
///
/// errors  a list of outputs beside output.path; an output without output.path
std::vector<Config> outputConfigs(const Config& config);

/// A pipeline file with every key, its value, and its help, valid values and unit as comments. Deprecated keys are left
/// out unless they are set. readConfig() reads the same Config back.
std::string printConfig(const Config& config);

}  // namespace betamesh
