#include "batch/config/config.h"
#include "batch/config/presets.h"
#include "batch/job/plan.h"
#include "command.h"
#include "job_options.h"

#include <algorithm>
#include <iostream>
#include <memory>

namespace betamesh {

void addConfigCommand(CLI::App& program, int&) {
    CLI::App* command = program.add_subcommand("config", "Explains and checks pipeline files, and lists presets.");
    command->footer("Exit codes: 0 printed, and valid; 2 wrong usage, or a key or value that is not valid.");
    command->require_subcommand(1);
    struct ConfigArguments {
        std::string file;
        std::vector<std::string> assignments;
        std::map<std::string, std::string> values;
    };
    const auto arguments = std::make_shared<ConfigArguments>();

    CLI::App* print =
        command->add_subcommand("print", "Prints every key with its value, explanation, valid values and unit.");
    print->add_option("FILE", arguments->file, "A pipeline file. Without it, the defaults are printed.");
    print->add_option("--set", arguments->assignments, "Set any key, as for `betamesh run`.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
    addKeyOptions(*print, arguments->values, [](const ConfigKey& key) { return key.path == "preset"; });
    print->callback([arguments] {
        std::cout << printConfig(readConfig(arguments->file, keyValuesOf(arguments->assignments, arguments->values)));
    });

    CLI::App* check = command->add_subcommand(
        "check", "Checks a pipeline file, but not its input; if it is invalid, prints why and exits with 2.");
    check->add_option("FILE", arguments->file, "The pipeline file.")->required();
    check->callback([arguments] { checkConfig(readConfig(arguments->file)); });

    command->add_subcommand("presets", "Lists the presets and what they are for.")->callback([] {
        std::size_t longest = 0;
        for (const Preset& preset : presets()) longest = std::max(longest, preset.name.size());
        for (const Preset& preset : presets())
            std::cout << preset.name << std::string(longest + 2 - preset.name.size(), ' ') << descriptionOf(preset)
                      << '\n';
    });
}

}  // namespace betamesh
