// In which directions a ball's sphere is exposed, and how far from the rim of what is.

#pragma once

#include "core/ball_boundary.h"
#include "core/icosphere.h"
#include "exact/snapped_particles.h"

#include <span>

namespace betamesh {

/// What other balls hide of a sphere, each a cap of it. The clearance of a direction from one of them, as of
/// FacePoints, is (cosine - direction · axis) · scale. One object serves for many balls in turn.
struct Caps {
    std::vector<float> x, y, z;  ///< axes
    std::vector<float> cosine, scale;

    /// Those that neighbours within 2R cut out of a ball.
    void set(const std::vector<Neighbour>& neighbours, std::int64_t radius);

    /// The least clearance of a direction from all of them, or any that is too little, and from which; no cap's number
    /// without any.
    std::pair<double, std::uint32_t> nearest(const Vec3& direction, double too_little) const;
};

/// Finds out which of fixed directions are exposed. One object serves for many balls in turn.
class ExposedDirections {
public:
    explicit ExposedDirections(const std::vector<Vec3>& directions);

    /// Appends those in which a ball with these neighbours is, ascending; nearest: a row of SnappedParticles. bounding:
    /// the places of some neighbours, whose caps hide most of what is hidden.
    /// cost    O(directions · bounding + exposed ones · neighbours), in single precision
    void find(const std::vector<Neighbour>& neighbours, std::int64_t radius, std::span<const std::uint32_t> bounding,
              std::vector<ExposedDirection>& exposed);

private:
    DirectionColumns all_, left_;
    std::vector<float> clearance_, cap_;
    std::vector<std::uint32_t> number_;
    std::size_t directions_;
    Caps caps_;
};

}  // namespace betamesh
