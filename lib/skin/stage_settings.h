// What the parameters of a frame mean for each stage.

#pragma once

#include "base/icosphere.h"
#include "betamesh/skin_params.h"
#include "skin/arcs.h"
#include "skin/retract.h"
#include "skin/smooth_coherent.h"

#include <optional>

namespace betamesh {

/// Is the surface the complete tessellation, for which all stages exist?
bool isComplete(const SkinParams& params);
/// Does the surface leave the boundary of the union of balls for a skin?
bool hasSkin(const SkinParams& params);
/// Does any smoothing move the vertices, with a skin or without?
bool isSmoothed(const SkinParams& params);
/// Passes of coherent smoothing: 0 with another method.
int coherentPasses(const SkinParams& params);

/// Directions in which points inside faces are sought; none where the surface has no such points.
Icosphere faceDirections(const SkinParams& params);
/// How the complete tessellation cuts arcs.
ArcSubdivision arcSubdivision(const SkinParams& params);
CoherentSmoothing coherentSmoothing(const SkinParams& params);
SkinLengths skinLengths(const SkinParams& params);
/// May triangles be so long, for the depth of the skin, that particles are left outside?
bool facetsMayCutOffParticles(const SkinParams& params);
/// Widest kernel of the skin's sphere fits, and farthest displacement by its smoothing; particle spacings.
double widestSkinFit(const SkinParams& params);
double farthestSkinSmoothing(const SkinParams& params);

/// Checks the parameters for particles of different sizes.
///
/// errors  a factor that is not above 0; a rate without radii; radii with the paper's tessellation or floating
///         predicates
void requireSizes(const SkinParams& params);

/// Checks the walls.
///
/// errors  walls of another surface than the complete tessellation; a normal that is not of unit length; an offset that
///         is not finite
void requireWalls(const SkinParams& params);

/// The box of the parameters, rounded to floats.
///
/// errors  a box of another surface than the complete tessellation; one that is not finite or has no inside
std::optional<Box> clippingBox(const SkinParams& params);

/// errors  the paper's smoothing with another tessellation than the paper's; filled bubbles with another tessellation
///         than the complete one; what requireScale(), requireSizes(), requireSkin(), requireWalls(), clippingBox() and
///         requireDistinctNames() throw
void requireConsistent(const SkinParams& params);

}  // namespace betamesh
