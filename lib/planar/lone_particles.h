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
    LoneParticles(const std::vector<DualVec3>& particles, double radius, double wide_radius);

    /// 1 where all particles near are alone, 0 where none is, or where there are none; continuous.
    Dual at(const DualVec3& x) const;

private:
    std::vector<DualVec3> particles_;
    double reach_;
    CellOrder cells_;
    std::vector<Dual> alone_;
};

}  // namespace betamesh
