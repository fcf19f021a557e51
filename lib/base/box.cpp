
#include "base/box.h"

#include "base/simd.h"

namespace betamesh {

BETAMESH_EVERY_CPU
void squaredDistances(const Box& box, const double* x, const double* y, const double* z, std::size_t n,
                      double* squared) {
    const auto distanceAlongAxis = [](double at, double low, double high) {
        const double below = low - at, above = at - high, farther = below > above ? below : above;
        return farther > 0 ? farther : 0;
    };
    for (std::size_t k = 0; k < n; ++k) {
        const double dx = distanceAlongAxis(x[k], box.min.x, box.max.x),
                     dy = distanceAlongAxis(y[k], box.min.y, box.max.y),
                     dz = distanceAlongAxis(z[k], box.min.z, box.max.z);
        squared[k] = dx * dx + dy * dy + dz * dz;
    }
}

}  // namespace betamesh
