// The particle spacing dx, estimated from the particles themselves.

#pragma once

#include "betamesh/vec3.h"

#include <optional>
#include <vector>

namespace betamesh {

/// The particle spacing of a liquid, world units.
struct SpacingEstimate {
    double spacing = 0;
    double low = 0, high = 0;  ///< 5 and 95 % of the particles have a smaller local spacing
    /// Share of the particles that have another one nearer than half the mean distance to their six nearest: at most
    /// 0.05 on jittered lattices and in SPH, 0.15 or more where particles are seeded at random in cells, as in FLIP.
    double clumped = 0;
};

/// Estimates the particle spacing of a sequence from a few of its frames.
///
/// The local spacing of a particle is the mean distance to its six nearest neighbours, divided by what that is in a
/// regular arrangement of spacing 1 that extends as these neighbours do: 2 along a line, 1.12 in a sheet, 1 in a
/// volume. So a row of particles, a layer and a block have the same spacing. Local spacings are sampled, and their most
/// frequent value is the spacing of the liquid: spray, walls, clumps and near-duplicates have no influence as long as
/// each of them has fewer particles.
///
/// Where the median over all particles of the first frame's mean distances agrees with that to a twentieth, it is the
/// estimate: it needs no sample. It is 0.84 to 1.01 of the nominal spacing on SPH, FLIP and jittered lattices; the
/// nearest neighbour alone gives 0.50 to 0.78.
class SpacingEstimator {
public:
    /// dimension: 3; or 2, where the spacing is the mean distance to the six nearest in a plane, 1.12 times as long.
    explicit SpacingEstimator(int dimension = 3) : dimension_(dimension) {}

    /// Adds a frame. Returns false if it has fewer than seven distinct particles, which tell nothing.
    ///
    /// same    estimate for any thread count and particle order
    /// cost    O(n log n); less for all frames but the first
    bool add(std::vector<Vec3f> positions);

    /// Nothing if no frame told a spacing.
    std::optional<SpacingEstimate> estimate() const;

private:
    int dimension_;
    std::optional<double> first_median_;  // of the mean distance to the six nearest, in the first frame
    std::vector<double> local_;           // sampled local spacings of all frames
    std::size_t clumped_ = 0;             // number of these particles that have another one very near
};

/// The particle spacing of one frame; nothing if it has fewer than seven distinct particles.
std::optional<SpacingEstimate> spacingOf(std::vector<Vec3f> positions, int dimension = 3);

/// The local spacings of about a thousand particles, chosen by a hash of their positions, or of all if there are fewer.
/// See SpacingEstimator.
///
/// out     in no particular order; none if there are fewer than seven distinct particles
/// cost    O(n log n), about a third of SpacingEstimator::add()
std::vector<double> localSpacings(std::vector<Vec3f> positions, int dimension = 3);

/// The local spacings of about a thousand particles, each divided by the particle's own size.
///
/// in      size: of each particle, > 0
/// out     as localSpacings()
std::vector<double> spacingsInSizes(const std::vector<Vec3f>& positions, const std::vector<double>& size,
                                    int dimension = 3);

/// The most frequent among at least one local spacing: the median of those around the densest place.
double typicalSpacing(std::vector<double> local);

/// The median over distinct particles of the mean distance to their six nearest; nothing for fewer than seven.
std::optional<double> medianSixNearest(std::vector<Vec3f> positions);

}  // namespace betamesh
