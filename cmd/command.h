// The commands of the program. Each file here adds one: its flags, a call of the library, an exit code.

#pragma once

#include <CLI/CLI.hpp>

namespace betamesh {

/// Adds the command to the program. When the command was run, exit_code holds what main() returns.
void addMeshCommand(CLI::App& program, int& exit_code);
void addRunCommand(CLI::App& program, int& exit_code);
void addSampleCommand(CLI::App& program, int& exit_code);
void addInfoCommand(CLI::App& program, int& exit_code);
void addCheckCommand(CLI::App& program, int& exit_code);
void addCoherenceCommand(CLI::App& program, int& exit_code);
void addConfigCommand(CLI::App& program, int& exit_code);

}  // namespace betamesh
