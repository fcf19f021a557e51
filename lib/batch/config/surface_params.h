// The parameters of the surface from its configuration. Needs no pipeline file, so that other callers than jobs can use
// the same keys.

#pragma once

#include "batch/config/config.h"
#include "skin/spacing.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// Ball radius and particle spacing in world units.
struct ResolvedRadius {
    double radius = 0;
    double spacing = 0;
    std::string source;  ///< where the spacing comes from, for the log: "as given", "measured in a.0001.vdb"
    std::vector<std::string> advice;  ///< for the log: settings that would suit the particles better
    std::vector<std::string> warnings;
};

/// Radius and spacing as far as the configuration alone tells them: nullopt if the spacing has to be measured.
std::optional<ResolvedRadius> givenRadius(const Config& config);

/// A particle spacing that was measured.
struct MeasuredSpacing {
    std::optional<SpacingEstimate> estimate;  ///< nullopt: no frame told a spacing
    std::size_t most_particles = 0;           ///< in one of the frames
    std::string where;                        ///< for messages: "a.0001.vdb", "frames 1, 50 and 99"
};

/// Radius and spacing from the configuration, or from a measurement where the configuration does not tell them.
///
/// out     nullopt if neither tells a spacing
/// errors  a radius of more than 50 measured spacings, or 10 if a frame has more than 5,000 particles, unless a spacing
///         is given as well
std::optional<ResolvedRadius> measuredRadius(const Config& config, const MeasuredSpacing& measured);

/// The wall of a text such as "x>0" or "0.6x+0.8y<2", which tells where the liquid lies; nullopt if the text is
/// anything else or the plane has no direction.
std::optional<Wall> wallOf(std::string_view text);

/// Makes keys that depend on each other consistent: the paper's smoothing needs its tessellation, and bubbles are
/// filled and normals fitted where the surface allows it. Adds a warning where a value that was given is replaced.
void reconcileSurface(Config& config, std::vector<std::string>& warnings);

/// The parameters without lengths. The configuration has passed reconcileSurface().
SkinParams skinParams(const Config& config);

/// Checks the surface as far as possible before the spacing is measured. Adds a warning about a deprecated key.
///
/// errors  a skin that is not below the radius, or that the surface cannot have; both surface.skin and surface.inset;
///         radii of particles, walls or a box that the surface cannot have
void checkSkin(const Config& config, std::vector<std::string>& warnings);

/// The parameters with all lengths, in world units.
///
/// errors  those of checkSkin() and requireScale(); lengths that 32-bit floats cannot store
SkinParams withLengths(SkinParams params, const Config& config, const ResolvedRadius& resolved);

/// How radius and spacing suit the particles of one frame.
struct FrameSpacing {
    std::optional<double> own;         ///< the frame's own spacing, world units
    std::optional<std::string> drift;  ///< warning: the frame's own spacing differs by more than a quarter
    std::optional<std::string> scale;  ///< warning otherwise: the radius is outside 0.8 to 3 of the own spacing
};

/// Particles with sizes of their own have no common spacing and cannot drift; their sizes are compared with their local
/// spacings.
///
/// in      params: as used, in world units
/// cost    O(n log n), under 1 % of skinning the frame
/// errors  those of particleSizes()
FrameSpacing compareSpacing(const Particles& particles, const SkinParams& params, int dimension);

}  // namespace betamesh
