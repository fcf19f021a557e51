#include "batch/config.h"
#include "command.h"

#include <iostream>
#include <memory>

namespace betamesh {

void addConfigCommand(CLI::App& program, int&) {
    CLI::App* command = program.add_subcommand("config", "Explains and checks pipeline files.");
    command->require_subcommand(1);
    struct Arguments {
        std::string file;
        std::vector<std::string> assignments;
    };
    const auto arguments = std::make_shared<Arguments>();

    CLI::App* print =
        command->add_subcommand("print", "Prints the merged configuration: every key with its unit, range and reason.");
    print->add_option("FILE", arguments->file, "A pipeline file; without one the defaults are printed.");
    print->add_option("--set", arguments->assignments, "As for `run`.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
    print->callback([arguments] {
        Config config = arguments->file.empty() ? Config{} : readConfig(arguments->file);
        for (const std::string& assignment : arguments->assignments) setConfigKey(config, assignment);
        std::cout << printConfig(config);
    });

    CLI::App* check =
        command->add_subcommand("check", "Exit code 0 if the file is right, 2 and the place if it is not.");
    check->add_option("FILE", arguments->file, "A pipeline file.")->required();
    check->callback([arguments] { readConfig(arguments->file); });
}

}  // namespace betamesh
