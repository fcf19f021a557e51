// Checks of option values. Their messages name the value that was given and the values that are valid.

#pragma once

#include "command.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace betamesh {

/// A whole number from least to most.
CLI::Validator wholeNumber(std::int64_t least, std::int64_t most = std::numeric_limits<std::int64_t>::max());

/// A finite number above 0.
CLI::Validator numberAboveZero();

/// A finite number of at least 0.
CLI::Validator numberFromZero();

/// One of several words.
CLI::Validator oneOf(const std::vector<std::string>& words);

}  // namespace betamesh
