// Pictures of what happens in a plane, that any browser shows.

#pragma once

#include "betamesh/curves.h"

#include <filesystem>
#include <string>
#include <vector>

namespace betamesh {

/// What can be drawn, lowest first.
enum class Layer {
    discs,      ///< their union, and the circles left out of the curves
    particles,  ///< dots
    alpha,      ///< the alpha mesh, black
    before,     ///< the curves before smoothing, dotted, with hollow dots for vertices
    beta,       ///< the curves, red
    vertices    ///< of the curves: pure beta vertices red, alphabeta vertices blue
};

/// Everything that layers show; lengths in world units. pure has a row for each vertex of before and of beta.
struct PlanePicture {
    std::vector<Vec3> particles;
    double radius = 0;
    Curves alpha, before, beta;
    std::vector<std::uint8_t> pure;  ///< 1 where a vertex is a pure beta vertex
    std::vector<Vec3> apart;         ///< centres of circles beside the curves
};

/// A rectangle of the plane; x and y alone.
struct PlaneBounds {
    Vec3 low{0, 0, 0}, high{0, 0, 0};
    bool operator==(const PlaneBounds&) const = default;
};

/// An .svg 1000 pixels wide; nothing stands under that name before it is complete.
///
/// bounds  what is shown; low == high: all discs
void writePicture(const std::filesystem::path& path, const PlanePicture& picture, const std::vector<Layer>& layers,
                  const PlaneBounds& bounds = {});

/// Is this the name of a picture?
bool isPicture(const std::filesystem::path& path);

}  // namespace betamesh
