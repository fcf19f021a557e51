// In which of a set of fixed directions a ball's sphere is exposed, and how far those are from the rim of its exposed
// part.

#pragma once

#include "base/icosphere.h"
#include "base/index.h"
#include "skin/exposed_region.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// One of a set of directions in which a ball's sphere is exposed.
struct ExposedDirection {
    std::uint32_t direction;  ///< index in the set
    std::uint32_t nearest;    ///< the ball whose cap is nearest by rim distance; kInvalidIndex if it is not exposed
    float rim_distance;       ///< from the rim of the exposed part, see FacePoints
};

/// Finds which of a set of directions are exposed on a ball. One object serves many balls in turn.
class ExposedDirections {
public:
    explicit ExposedDirections(const std::vector<Vec3>& directions);

    /// Appends the exposed directions of a ball of this radius, ascending. region: constructed from these neighbours,
    /// which are all whose spheres meet its own. ExposedDirection::nearest is a row of SnappedParticles here,
    /// kInvalidIndex where there is no cap.
    ///
    /// cost    O(directions · bounding neighbours + exposed directions · neighbours), in single precision
    void find(const ExposedRegion& region, const std::vector<Neighbour>& neighbours, std::int64_t radius,
              std::vector<ExposedDirection>& exposed);

private:
    DirectionColumns all_, candidates_;
    std::vector<float> rim_distance_, nearest_cap_;
    std::vector<float> cosine_, scale_;  // of each cap, see setScales()
    std::vector<std::uint32_t> candidate_number_;
    std::size_t directions_;
};

}  // namespace betamesh
