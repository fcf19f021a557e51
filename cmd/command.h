// The commands of the program. Each command has a file: its options, a call of the library, an exit code.

#pragma once

#include <CLI/CLI.hpp>

#include <memory>

namespace betamesh {

/// A command and the arguments that its options fill in.
template <typename Arguments>
struct Command {
    CLI::App* app;
    std::shared_ptr<Arguments> arguments;  ///< kept alive by the callback of the command
};

/// Adds a command that calls run(arguments) and stores its result in exit_code.
template <typename Arguments>
Command<Arguments> addCommand(CLI::App& program, int& exit_code, const char* name, const char* description,
                              int (*run)(const Arguments&)) {
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* app = program.add_subcommand(name, description);
    app->callback([=, &exit_code] { exit_code = run(*arguments); });
    return {app, arguments};
}

/// Each function adds a command to the program; running the command stores the exit code of main() in exit_code.
void addMeshCommand(CLI::App& program, int& exit_code);
void addRunCommand(CLI::App& program, int& exit_code);
void addConvertCommand(CLI::App& program, int& exit_code);
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
