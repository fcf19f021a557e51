// Frames in two dimensions: checks of the configuration, output as curves or as a drawing.

#pragma once

#include "batch/config/config.h"
#include "betamesh/skin.h"
#include "io/svg.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// Checks that configuration and output fit surface.dimension.
///
/// errors  an output format that cannot store meshes or curves, whichever is needed; in two dimensions, keys that are
///         for three dimensions only; keys of drawings if the output is not a drawing
void requireDimension(const Config& config, const SkinParams& params);

/// The values of picture.layers and picture.bounds.
std::vector<Layer> parseLayers(const std::vector<std::string>& names);
PlaneBounds parseBounds(const std::string& text);

/// A plane across an axis. Its own coordinates are (x, y) across z, (x, z) across y and (y, z) across x, with the rest
/// as the third: each is a rotation of space.
struct AxisPlane {
    int axis = 2;
    float height = 0;  ///< coordinate along the axis, world units

    Vec3 toPlane(const Vec3& v) const;
    Vec3 toSpace(const Vec3& v) const;
};

/// The plane across an axis in which all positions lie, within a hundredth of the spacing. z is preferred to y, y to x.
///
/// in      spacing: of the particles, world units
std::optional<AxisPlane> planeOf(const std::vector<Vec3f>& positions, double spacing);

/// Particles in the coordinates of their plane, all at z = plane.height.
struct FlatParticles {
    AxisPlane plane;
    Particles particles;
};

/// errors  particles that do not lie in one plane across an axis
FlatParticles flattened(Particles particles, double spacing);

/// Positions and velocities in the coordinates of space.
Spheres toSpace(Spheres spheres, const AxisPlane& plane);
Curves toSpace(Curves curves, const AxisPlane& plane);

/// Writes the curves; to an .svg, the layers in picture.layers, in the coordinates of the plane. discs: the particles.
void writePlane(const std::string& output, const SkinnedPlane& plane, const FlatParticles& discs,
                const SkinParams& params, const Config& config, const WriteOptions& options);

}  // namespace betamesh
