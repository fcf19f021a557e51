// The lengths that define the skin.

#pragma once

#include "base/dual.h"
#include "skin/constants.h"

namespace betamesh {

/// Radius of the rolling ball of SkinLengths: it touches balls of radius `skin` around two particles and the midpoint
/// between these, if the balls of radius `joining` just touch there. Lengths in any unit.
constexpr double rollingRadius(double joining, double skin) { return (joining * joining - skin * skin) / (2 * skin); }

/// The lengths that define a skin, all in particle spacings.
///
/// Balls of radius `joining` decide which particles are connected. The skin is the boundary of the region that a ball
/// of radius rolling() cannot enter when it rolls over balls of radius `skin`; it is `skin` away from the outermost
/// particles. Since outer()² = joining² + rolling()², two balls of the joining radius touch exactly when the skins
/// around both meet, and the hole between three balls closes exactly when the skin closes there.
struct SkinLengths {
    double joining = 1.5;      ///< > 0
    double skin = 0.55;        ///< > 0, < joining
    bool volume_true = false;  ///< threads and drops are a little thicker than `skin`, which makes their volume true
    double edge_factor = 1;    ///< >= 1: scales the edge lengths at which the mesh is refined

    double rolling() const { return rollingRadius(joining, skin); }
    double outer() const { return skin + rolling(); }
    /// Whether the mesh is to be coarse, for which fewer steps do.
    bool isCoarse() const { return edge_factor > 1; }
};

/// What is added to squared distances from a part of the outer boundary where the rolling ball has only just entered a
/// cavity: a smaller ball rolls there, or none within reach. Lengths in particle spacings.
///
/// arc: mean length of arc there; it grows from 0
inline Dual entranceOffset(Dual arc, double rolling) {
    const double reach = rolling + kReachFade;
    return (1 - smoothStep(arc / kEntranceArc)) * (reach * reach);
}

}  // namespace betamesh
