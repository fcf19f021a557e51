// How much a place belongs to particles that have no others near them.

#pragma once

#include "base/cell_order.h"
#include "base/dual.h"

#include <vector>

namespace betamesh {

class LoneParticles {
public:
    /// particles: all of them. A particle is alone where discs of the wide radius, which is the larger one, do not meet
    /// its own, and is not where those of the other radius do; between the two it is more or less so.
    LoneParticles(const std::vector<Moving>& particles, double radius, double wide_radius);

    /// 1 where all particles near are alone, 0 where none is, or where there are none; continuous.
    Rate at(const Moving& x) const;

private:
    std::vector<Moving> particles_;
    double reach_;
    CellOrder cells_;
    std::vector<Rate> alone_;
};

}  // namespace betamesh
