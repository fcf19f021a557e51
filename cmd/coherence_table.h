// The table that `coherence` prints on stdout.

#pragma once

#include "batch/report/report.h"

#include <cstddef>
#include <string>
#include <vector>

namespace betamesh {

/// A number with four significant digits.
std::string shortText(double x);

/// Prints the column headings, and a row for the first moment.
void printTableHead(const std::string& first_moment, bool with_particles);

/// Prints the row of a pair of moments and, below it, up to `max_places` places with jumps.
void printTableRow(const CoherenceReport& report, bool with_particles, std::size_t max_places);

/// Prints the pair whose surfaces are farthest apart, or why there is none.
void printLargest(const std::vector<CoherenceReport>& reports);

}  // namespace betamesh
