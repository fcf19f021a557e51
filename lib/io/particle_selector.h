// Chooses the particles of a file block by block, and records what the file contains.

#pragma once

#include "io/attribute_expression.h"
#include "io/file_contents.h"
#include "io/particle_input.h"

#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// What has to be finite in the blocks: an error names the first particle that is not. Where particles are chosen,
/// those that are not chosen are not checked; where bad particles are dropped, nothing is an error.
enum class Checks { none, positions, velocities };

/// Applies the choice of a ParticleInput to the blocks of one file, in their order.
class ParticleSelector {
public:
    /// errors  input.where is no condition
    ParticleSelector(const ParticleInput& input, std::string file);

    void check(Checks checks) { checks_ = checks; }

    /// Whether some particles may be left out: a condition, a box, groups or bad particles choose.
    bool mayLeaveOut() const;
    /// Whether blocks need their attributes for the choice.
    bool needsAttributes() const;
    /// Whether the input names the attribute: in its condition, or as the velocity.
    bool needs(const std::string& attribute) const;

    /// Removes the points that are not chosen from the next block of the file. Costs nothing if none may be left out
    /// and nothing is checked.
    ///
    /// errors  those of AttributeExpression; a group that does not exist; a particle that is not finite
    void choose(FileContents& points);

    /// kept: all chosen points, with their attributes; rest: what else the reader has found in the file.
    InputSummary summary(const FileContents& kept, const FileContents& rest) const;

private:
    using RowIndices = std::vector<std::uint32_t>;

    void keepMembers(const FileContents& points, RowIndices& rows) const;
    void keepInside(const FileContents& points, RowIndices& rows) const;
    void keepFinite(const FileContents& points, RowIndices& rows, std::size_t first_row);

    const ParticleInput& input_;
    std::string file_;
    std::optional<AttributeExpression> where_;
    Checks checks_ = Checks::none;
    std::size_t row_ = 0;  // in the file, of the first point of the next block
    std::uint64_t dropped_ = 0;
    std::string first_dropped_;
    std::vector<LostNumber> lost_numbers_;
};

/// Removes particles whose position or velocity is not finite. Returns a sentence about them; empty if there are none.
std::string dropBadParticles(const std::string& file, FileContents& contents);

}  // namespace betamesh
