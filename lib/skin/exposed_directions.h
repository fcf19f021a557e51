// In which directions a ball's sphere is exposed, and how far from the rim of what is.

#pragma once

#include "base/icosphere.h"
#include "base/index.h"
#include "skin/ball_boundary.h"
#include "skin/exposed_region.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// Finds out which of fixed directions are exposed. One object serves for many balls in turn.
class ExposedDirections {
public:
    ExposedDirections(const std::vector<Vec3>& directions, std::int64_t radius);

    /// Appends those of a ball with these neighbours, of which the region was made, ascending. Until balls have numbers
    /// of their own `nearest` is a row of SnappedParticles; kInvalidIndex where there is no cap.
    ///
    /// cost    O(directions · bounding neighbours + exposed ones · neighbours), in single precision
    void find(const ExposedRegion& region, const std::vector<Neighbour>& neighbours,
              std::vector<ExposedDirection>& exposed);

private:
    DirectionColumns all_, left_;
    std::vector<float> clearance_, cap_;
    std::vector<float> cosine_, scale_;  // of caps
    std::vector<std::uint32_t> number_;
    std::size_t directions_;
    double per_diameter_;
};

}  // namespace betamesh
