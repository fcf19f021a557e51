// What a particle file contains, what of it is used, and how its numbers become world units.

#pragma once

#include "betamesh/io.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// An attribute, a group, a grid or something else that a file contains.
struct InputPart {
    enum class Kind { attribute, group, grid, other };

    Kind kind = Kind::attribute;
    std::string name;
    std::string type;  ///< as the format names it, with the number of components: "float", "vector", "3 float32"
    std::string use;   ///< "position", "velocity", "id", "selection", "size", "output"; empty: not used
};

/// A number that is finite in the file, but too large for single precision.
struct LostNumber {
    std::string attribute;       ///< as the file names it
    std::uint64_t particle = 0;  ///< row in the file, or in a block of its points
    double value = 0;
    std::size_t line = 0;  ///< of a text file; 0: none
};

/// "1e+39 (line 9), which is too large for single precision".
std::string describe(const LostNumber& lost);

/// ". In the file, 'x' is 1e+39 (line 9), …" if a number of the particle is lost, else empty.
std::string noteOnLost(const std::vector<LostNumber>& numbers, std::uint64_t particle);

/// What a particle file contains, and what of it is used.
struct InputSummary {
    std::uint64_t particles_read = 0;  ///< in the file, or in the chosen grids
    std::uint64_t dropped = 0;         ///< left out because their position or velocity is not finite
    std::uint64_t polygons = 0;        ///< in the file, whose vertices are taken as particles
    std::string first_dropped;         ///< "particle 77: position is (nan, 0, 0)"
    std::string velocity;              ///< attributes that contain the velocity: "v", "v_1, v_2, v_3"; empty: none
    std::string incomplete_velocity;   ///< if there is none: what is missing, see incompleteVelocity()
    std::vector<std::string> velocity_candidates;  ///< if there is none: attributes that might be meant
    std::vector<LostNumber> lost_numbers;          ///< the first of each attribute
    std::vector<std::string> warnings;             ///< as FileContents::warnings
    std::vector<InputPart> parts;                  ///< in the order of the file; grids and groups first
    bool z_is_up = false;                          ///< says the file
    std::optional<double> frames_per_second{};     ///< says the file; nullopt: nothing
    std::optional<double> meters_per_unit{};       ///< likewise
};

/// The attributes that contain the velocity.
struct VelocitySource {
    struct Component {
        std::size_t attribute = 0;  ///< index of the attribute
        std::size_t component = 0;
    };
    std::array<Component, 3> xyz;
    std::string name;                 ///< "v", "v_1, v_2, v_3"
    bool is_whole_attribute = false;  ///< all components of one attribute, in their order
};

/// Finds the velocity of n particles. Usual names, in the order of preference: attributes of three floats called v,
/// velocity or vel; then, in any case, v, velocity, vel, velocities or u; then three attributes of one number whose
/// names are one of v, velocity, vel and velocities with the endings x y z, 0 1 2, 1 2 3 or u v w, after nothing or one
/// of _ . : and space, or in brackets; then u, v and w.
///
/// in      requested: one name, or three separated by commas; empty: the usual names
///         known: what the file has, for messages
/// out     nullopt if none is requested and none is found
/// errors  a requested attribute that does not exist or is not three floats, unless there are no particles
std::optional<VelocitySource> findVelocity(const std::vector<Attribute>& attributes, std::size_t n,
                                           const std::string& requested, const std::string& known,
                                           const std::string& file);

/// What is missing where only two components of a usual velocity are there: "there are 'vx' and 'vy', but 'vz' is
/// missing"; of 'v_1' and 'v_2' "either 'v_0' or 'v_3'"; empty otherwise.
std::string incompleteVelocity(const std::vector<Attribute>& attributes, std::size_t n);

/// Attributes that might be a velocity: those of three floats, and triples of attributes of one number.
std::vector<std::string> velocityCandidates(const std::vector<Attribute>& attributes);

/// A name such as "vel_x", "Points:0" or "a[2]" as that of a vector and the index of a component.
struct ComponentName {
    std::string vector;
    std::size_t index = 0;
};
std::optional<ComponentName> componentName(const std::string& name);

/// Positions of the file, after subtracting the origin, in world units. Nothing changes with a scale of 1 and up axis
/// y.
void toWorld(const ParticleInput& input, std::vector<Vec3f>& positions);

/// What has to be added to a mesh to return to the coordinates of the file, in world units.
///
/// in      up_axis: of the axes in which the point is given; that of the mesh file, or y
Vec3 worldOrigin(const ParticleInput& input, UpAxis up_axis);

/// Velocities, accelerations and normals of the file in world units, seconds and axes.
void toWorld(const ParticleInput& input, Particles& particles);

}  // namespace betamesh
