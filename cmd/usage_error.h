// What is wrong with a command line, in a sentence.

#pragma once

#include "command.h"

#include <string>
#include <vector>

namespace betamesh {

/// Explains an error of CLI11: what was typed, what is known, what was probably meant, and what to do.
///
/// in      program: after the attempt to parse
///         words: the command line without the name of the program
std::string usageError(const CLI::App& program, const std::vector<std::string>& words, const CLI::ParseError& error);

}  // namespace betamesh
