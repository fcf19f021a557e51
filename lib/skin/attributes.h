// Attributes of the particles, interpolated to the vertices of the surface.

#pragma once

#include "base/dual.h"
#include "betamesh/particles.h"

#include <string>
#include <vector>

namespace betamesh {

/// The attribute of that name; null if there are no particles, since files without particles often have no attributes.
///
/// errors  particles without such an attribute; the message lists those they have
const Attribute* attributeOf(const Particles& particles, const std::string& name);

/// errors  a name that carriedAttributes() would refuse
void requireAttributesNamed(const Particles& particles, const std::vector<std::string>& names);

/// Radii of balls and, at vertices, those of the balls there.
struct LocalRadii {
    double largest = 0;                    ///< of all balls, world units
    std::vector<float> ball_scale = {};    ///< radius of each ball over the largest; empty: all 1
    std::vector<float> vertex_scale = {};  ///< local radius at each vertex over the largest; empty: all 1
};

/// The named attributes of the particles, interpolated to the vertices of a mesh or of curves. A ball reaches as far as
/// its radius plus the local one at the vertex, which is two radii where all are equal. Real numbers are means over the
/// balls that reach the vertex, weighted by (1 - d²/reach²)²; integers are copied from the ball with the largest
/// weight. Where no ball reaches the vertex, the values are zero. Accelerations (`accel`, `acceleration`) are always
/// included, because curved motion blur needs them.
///
/// in      n positions; balls and the rows of their particles; scales > 0; names of attributes, each once. If there are
///         no particles, unknown names are skipped
/// out     one attribute of n rows per name, in the order of the names, then accelerations
/// same    bytes for any thread count and particle order
/// cost    O(n · balls that reach a vertex)
/// errors  a name that the particles do not have; the message lists those they have
std::vector<Attribute> carriedAttributes(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                         const std::vector<DualVec3>& balls, const LocalRadii& radii,
                                         const std::vector<std::string>& names, const std::vector<Vec3>& position);

/// The named attributes, and accelerations, of some particles, in the order of the rows.
///
/// errors  as carriedAttributes()
std::vector<Attribute> attributesOf(const Particles& particles, const std::vector<std::uint32_t>& rows,
                                    const std::vector<std::string>& names);

}  // namespace betamesh
