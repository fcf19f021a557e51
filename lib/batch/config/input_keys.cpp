// Configuration keys that choose particles of the input and say what its attributes mean.

#include "batch/config/key_tables.h"
#include "batch/config/key_types.h"
#include "io/attribute_expression.h"

#include <limits>

namespace betamesh {
namespace {

/// Six numbers, or nothing.
ConfigKey particleBoxKey(const KeyText& text) {
    const std::string accepts =
        "six numbers separated by commas: the lowest x, y and z, then the highest; or leave it empty";
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [](const Config& config) { return config.input.box ? textOfNumbers(*config.input.box) : ""; },
        [=](Config& config, const std::string& value) {
            const auto box = numbersOf<6>(value);
            const bool is_box = box && (*box)[0] <= (*box)[3] && (*box)[1] <= (*box)[4] && (*box)[2] <= (*box)[5];
            if (!is_box && !value.empty()) failValue(value, accepts);
            config.input.box = box;
        });
}

/// auto (nullopt), none (zeros), or three numbers.
ConfigKey originKey(const KeyText& text) {
    const std::string accepts = "auto, none, or three numbers separated by commas";
    using Origin = std::optional<std::array<double, 3>>;
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [](const Config& config) -> std::string {
            const Origin& origin = config.input.given_origin;
            return !origin ? "auto" : *origin == std::array<double, 3>{} ? "none" : textOfNumbers(*origin);
        },
        [=](Config& config, const std::string& value) {
            const Origin origin = value == "none" ? Origin(std::array<double, 3>{}) : numbersOf<3>(value);
            if (!origin && value != "auto") failValue(value, accepts);
            config.input.given_origin = origin;
        });
}

/// One attribute, or three separated by commas.
ConfigKey velocityKey(const KeyText& text) {
    const std::string accepts =
        "the name of an attribute with three components, or three names separated by commas; or leave it empty";
    return makeKey(
        text, ConfigKey::Kind::list, accepts, [](const Config& config) { return config.input.velocity; },
        [=](Config& config, const std::string& value) {
            const std::vector<std::string> names = entriesOf(value);
            const bool has_empty =
                std::any_of(names.begin(), names.end(), [](const auto& name) { return name.empty(); });
            if (has_empty || (names.size() > 1 && names.size() != 3)) failValue(value, accepts);
            config.input.velocity.clear();
            for (const std::string& name : names)
                config.input.velocity += (config.input.velocity.empty() ? "" : ",") + name;
        });
}

/// A number other than 0, in the range of 32-bit floats.
template <typename Member>
ConfigKey factorKey(const KeyText& text, Member member) {
    const std::string accepts = "a number other than 0";
    return makeKey(
        text, ConfigKey::Kind::number, accepts, [=](const Config& config) { return textOf(readOnly(config, member)); },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (!number || !isFloatAboveZero(std::abs(*number))) failValue(value, accepts);
            member(config) = *number;
        });
}

void addChoice(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"input.where", "--where", "",
         "Condition that chooses particles, such as type == 1 && density > 900. Names are attributes of the file, id, "
         "and P for the position; components are P.x or P[0]; length(v) is the length of a vector. Operators: + - * / "
         "^ (power), comparisons, && || ! and a ? b : c. Values are those in the file, before input.scale and the "
         "like. A comparison with NaN fails. Everything else, such as the measured spacing, is derived from the chosen "
         "particles alone."},
        "a condition, or leave it empty", [](Config& c) -> std::string& { return c.input.where; },
        [](const std::string& text) {
            if (!text.empty()) AttributeExpression{text};
        }));
    keys.push_back(particleBoxKey({"input.box", "--box", "units of the file, before input.scale",
                                   "Reads only the particles inside this box or on its sides."}));
    keys.push_back(
        namesKey({"input.group", "--group", "",
                  "Reads only the particles that are in one of these point groups, of .vdb and Houdini's files."},
                 "names of point groups, each at most once, separated by commas; or leave it empty",
                 [](Config& c) -> std::vector<std::string>& { return c.input.group; }));
    keys.push_back(namesKey(
        {"input.grid", "--grid", "",
         "Reads only these point grids of .vdb files, or prims of .usda files by path or name. Empty: all of them; a "
         "warning names them if there are several. In .abc files "
         "it chooses objects, by their path or its last part; if empty, the file must contain exactly one."},
        "names of point grids, prims or objects, each at most once, separated by commas; or leave it empty",
        [](Config& c) -> std::vector<std::string>& { return c.input.grid; }));
    keys.push_back(choiceKey<OnBadParticle>(
        {"input.on_bad_particle", "--on-bad-particle", "",
         "What to do with particles whose position or velocity is NaN or infinite. error: the frame fails. drop: leave "
         "them out; a warning counts them."},
        {{"error", OnBadParticle::error}, {"drop", OnBadParticle::drop}},
        [](Config& c) -> OnBadParticle& { return c.input.on_bad_particle; }));
}

void addUnits(std::vector<ConfigKey>& keys) {
    const double most = std::numeric_limits<double>::max();
    keys.push_back(positiveKey(
        {"input.scale", "--scale", "world units per unit of the file",
         "Multiplies positions, velocities and accelerations. All other lengths, such as --radius, are in world units, "
         "after this scale."},
        "a number above 0", most, false, [](Config& c) -> double& { return c.input.scale; }));
    keys.push_back(factorKey({"input.velocity_scale", "--velocity-scale", "",
                              "Multiplies velocities, to correct their unit: 24 for velocities per frame at 24 frames "
                              "per second, -1 for velocities that point backwards."},
                             [](Config& c) -> double& { return c.input.velocity_scale; }));
    keys.push_back(positiveKey(
        {"input.time_scale", "--time-scale", "simulated seconds per second of playback",
         "Velocities are multiplied by this, and accelerations by its square, so that motion blur fits the playback. "
         "For frames that are DT simulated seconds apart and are played at FPS frames per second it is DT * FPS: 24 / "
         "64 for steps of 1/64 s at 24 frames per second. Below 1 is slow motion."},
        "a number above 0", most, false, [](Config& c) -> double& { return c.input.time_scale; }));
    keys.push_back(choiceKey<UpAxis>(
        {"input.up_axis", "--up-axis", "",
         "Axis of the file that becomes y in the output. y: nothing is rotated. z: positions, velocities, "
         "accelerations "
         "(accel, acceleration) and normals (N, normal, normals) are rotated by -90 degrees about x: (x, y, z) becomes "
         "(x, z, -y)."},
        {{"y", UpAxis::y}, {"z", UpAxis::z}}, [](Config& c) -> UpAxis& { return c.input.up_axis; }));
    keys.push_back(originKey(
        {"input.origin", "--origin", "units of the file, before input.scale",
         "Point that becomes the origin of the output, subtracted in double precision. auto: none, unless positions "
         "are stored in double precision and so far from the origin that single precision loses them: then a point of "
         "few digits near the middle of the first frame on disk, for all frames. The warning and the manifest "
         "(local_origin) tell what has to be added to the mesh."}));
}

}  // namespace

void addParticleKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(velocityKey(
        {"input.velocity", "--velocity", "",
         "Particle attribute that contains the velocity, or three attributes with its components, such as v_1,v_2,v_3. "
         "Empty: the first that exists of v, velocity, vel and other usual names in any case, also as components (vx "
         "vy vz, velx, velocity_x, v_1, u v w and so on); the log tells which. If there is none, zero velocities are "
         "written and a warning says so. An attribute named here must exist."}));
    keys.push_back(textKey(
        {"input.id", "--id", "",
         "Particle attribute that identifies a particle in every frame. Empty: id, if it exists. An attribute named "
         "here must exist."},
        "the name of a whole-number attribute, or leave it empty",
        [](Config& c) -> std::string& { return c.input.id; }));
    addChoice(keys);
    addUnits(keys);
}

}  // namespace betamesh
