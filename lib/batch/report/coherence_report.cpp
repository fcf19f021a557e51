#include "batch/report/report.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

double CoherenceReport::expectedAt(const JumpSite& place) const {
    const double displacement = particles ? particles->max : 0;
    return place.events.empty() ? displacement : std::sqrt(displacement * radius);
}

double CoherenceReport::largestExpectedRatio() const {
    double largest = 0;
    for (const JumpSite& place : places) largest = std::max(largest, place.jump / expectedAt(place));
    return largest;
}

}  // namespace betamesh
