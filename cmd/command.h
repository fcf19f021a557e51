// The commands of the program. Each file here adds one: its flags, a call of the library, an exit code.

#pragma once

#include <CLI/CLI.hpp>

#include <memory>

namespace betamesh {

/// A command and what the command line says to it.
template <typename Arguments>
struct Command {
    CLI::App* app;
    std::shared_ptr<Arguments> arguments;  ///< lives as long as the program does
};

/// When the command is given, exit_code becomes run(arguments).
template <typename Arguments>
Command<Arguments> addCommand(CLI::App& program, int& exit_code, const char* name, const char* description,
                              int (*run)(const Arguments&)) {
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* app = program.add_subcommand(name, description);
    app->callback([=, &exit_code] { exit_code = run(*arguments); });
    return {app, arguments};
}

/// Adds the command to the program. When the command was run, exit_code holds what main() returns.
void addMeshCommand(CLI::App& program, int& exit_code);
void addRunCommand(CLI::App& program, int& exit_code);
void addSampleCommand(CLI::App& program, int& exit_code);
void addInfoCommand(CLI::App& program, int& exit_code);
void addCheckCommand(CLI::App& program, int& exit_code);
void addCoherenceCommand(CLI::App& program, int& exit_code);
void addRenderCommand(CLI::App& program, int& exit_code);
void addCompareCommand(CLI::App& program, int& exit_code);
void addConfigCommand(CLI::App& program, int& exit_code);
void addSubmitCommand(CLI::App& program, int& exit_code);
void addReportCommand(CLI::App& program, int& exit_code);
void addManualCommand(CLI::App& program, int& exit_code);

}  // namespace betamesh
