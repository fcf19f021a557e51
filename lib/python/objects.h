// The types of the module: data of the library whose arrays Python reads without a copy.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/skin.h"
#include "python/binding.h"

#include <optional>
#include <vector>

namespace betamesh {

/// Vectors in double precision, rounded to single precision when Python asks for them first.
class RoundedVectors {
public:
    const std::vector<Vec3f>& of(const std::vector<Vec3>& vectors);

private:
    std::optional<std::vector<Vec3f>> rounded_;
};

/// What a surface was made with, world units.
struct SurfaceLengths {
    double radius = 0;
    double spacing = 0;
    double skin = 0;
};

struct ParticlesObject {
    Particles particles;
    Vec3 origin{0, 0, 0};  ///< to be added to positions, world units
};

struct SpheresObject {
    Spheres spheres;
    RoundedVectors position{}, velocity{};
};

struct MeshObject {
    Mesh mesh;
    Vec3 origin{0, 0, 0};  ///< to be added to positions, world units
    SpheresObject spheres{};
    std::optional<SkinReport> counts{};  ///< of a surface of particles
    SurfaceLengths lengths{};            ///< meaningful with counts
    RoundedVectors position{}, velocity{};
    std::optional<std::vector<Vec3f>> normals{};  ///< computed when Python asks for them first
};

struct CurvesObject {
    Curves curves;
    Vec3 origin{0, 0, 0};  ///< to be added to positions, world units
    SpheresObject spheres{};
    std::optional<PlaneReport> counts{};  ///< of curves of particles
    SurfaceLengths lengths{};             ///< meaningful with counts
    RoundedVectors position{}, velocity{};
};

/// Adds the types to the module.
void addTypes(nb::module_& module);

/// The origin that is given; nullopt for "auto", zero for None.
///
/// errors  anything else but three finite numbers
std::optional<Vec3> givenOrigin(nb::handle origin);

/// Particles of Python's arrays.
///
/// in      origin: None, "auto" or three numbers; auto: localOrigin() of positions in double precision, else zero
///         in_plane: positions may have two columns, and their origin is not chosen
/// errors  shapes, types and numbers as in arrays.h; what validate() throws
ParticlesObject particlesFrom(nb::handle positions, nb::handle velocities, nb::handle ids, nb::handle attributes,
                              nb::handle origin, bool in_plane = false);

}  // namespace betamesh
