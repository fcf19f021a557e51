// Awkward clouds, which every stage has to handle. Each has a name for SCOPED_TRACE.

#pragma once

#include "base/random.h"
#include "betamesh/particles.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace betamesh {

/// All clouds have id = row and a velocity of up to one radius per second, which differs from particle to particle,
/// also among duplicates.
struct Cloud {
    std::string name;
    Particles particles;
    double radius = 0;  ///< of the balls, in the unit of the positions
};

/// Empty, tiny, degenerate, flat, thin, dense, huge and random clouds. Where exact ties matter (contact at 2r, r-balls
/// through four or more points) coordinates and radius are exact in float32. Most have fewer than 400 particles, a few
/// about 2,000.
std::vector<Cloud> awkwardClouds();

/// 3 to 40 particles in a box with mean spacing dx and r/dx from 0.6 to 3. A third of the clouds is snapped to a small
/// integer grid with a radius that gives exact ties, some are flattened to a plane or a line, some have exact
/// duplicates.
Cloud randomCloud(std::uint64_t seed);

/// Calls check for all awkward clouds and for random ones from seed 0 on, with the cloud's name as trace, until a check
/// fails.
void forEveryCloud(std::uint64_t random_clouds, const std::function<void(const Cloud&)>& check);

/// How the radii of balls vary, relative to the largest.
enum class RadiusPattern {
    two,            ///< 1 or a half
    twentieth,      ///< any from 1/20 to 1
    powers_of_two,  ///< 1, 1/2, 1/4 or 1/8, so that ties stay exact
    wave,           ///< slowly varying in x, from 1/4 to 1
};
inline constexpr RadiusPattern kRadiusPatterns[] = {RadiusPattern::two, RadiusPattern::twentieth,
                                                    RadiusPattern::powers_of_two, RadiusPattern::wave};
/// The radius of a ball relative to the largest. p: its centre, in radii of the largest.
double relativeRadius(RadiusPattern pattern, const Vec3& p, Random& random);
/// Radii for the particles of a cloud, up to the cloud's.
std::vector<double> radiiFor(const Cloud& cloud, RadiusPattern pattern, std::uint64_t seed);

/// The same particles in another order: all arrays permuted alike.
Particles shuffled(const Particles& particles, std::uint64_t seed);

/// n particles on a sphere around the origin, to rounding: all spheres of the same radius around them pass close to the
/// origin.
Particles spiralOnSphere(std::size_t n, double radius);

}  // namespace betamesh
