#include "command.h"
#include "job_options.h"

#include <memory>

namespace betamesh {

void addRunCommand(CLI::App& program, int& exit_code) {
    CLI::App* command = program.add_subcommand("run", "Runs the batch job of a pipeline file.");
    command->footer(
        "Examples:\n"
        "  betamesh run pipelines/dambreak.yaml\n"
        "  betamesh run splash.yaml --frames 1-240 --chunk 3/8 --set surface.radius=1.4dx\n"
        "`betamesh config print` explains every key. Relative paths of input and output start at the\n"
        "current folder; those of include at the pipeline file's folder.");
    struct Arguments {
        std::string pipeline;
        JobOptions options;
    };
    const auto arguments = std::make_shared<Arguments>();
    command->add_option("PIPELINE", arguments->pipeline, "The pipeline file (.yaml).")->required();
    addJobOptions(*command, arguments->options);
    command->callback(
        [arguments, &exit_code] { exit_code = runWithOptions(readConfig(arguments->pipeline), arguments->options); });
}

}  // namespace betamesh
