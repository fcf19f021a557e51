// SVG drawings of two-dimensional results: particles, discs, alpha mesh and curves.
//
// Written: the shapes rect, g, circle and path. Not read.
// Format: "Scalable Vector Graphics (SVG) 1.1", W3C.

#pragma once

#include "betamesh/curves.h"

#include <filesystem>
#include <string>
#include <vector>

namespace betamesh {

/// Layers of a drawing, from the bottom up.
enum class Layer {
    discs,      ///< union of the discs, and isolated discs with their outlines
    particles,  ///< particles as dots
    alpha,      ///< alpha mesh, black
    before,     ///< curves before smoothing, dotted, with hollow dots for vertices
    beta,       ///< curves, red
    vertices    ///< vertices of the curves: pure beta vertices red, alphabeta vertices blue
};

/// The data of all layers; lengths in world units. pure has one row per vertex of `before` and of `beta`.
struct PlaneDrawing {
    std::vector<Vec3> particles;
    double radius = 0;
    Curves alpha, before, beta;
    std::vector<std::uint8_t> pure;  ///< 1 for pure beta vertices
    std::vector<Vec3> apart;         ///< centres of isolated discs, which are not part of the curves
};

/// A rectangle in the xy plane; z is ignored.
struct PlaneBounds {
    Vec3 low{0, 0, 0}, high{0, 0, 0};
    bool operator==(const PlaneBounds&) const = default;
};

/// Writes an .svg 1000 pixels wide, less if it would be more than 4000 high. The file appears under its name only when
/// it is complete.
///
/// in      bounds: the part that is drawn; low == high: all discs
void writeSvg(const std::filesystem::path& path, const PlaneDrawing& drawing, const std::vector<Layer>& layers,
              const PlaneBounds& bounds = {});

/// Whether the extension is .svg, in upper or lower case.
bool isSvg(const std::filesystem::path& path);

}  // namespace betamesh
