#include "command.h"
#include "help.h"
#include "job_options.h"

namespace betamesh {
namespace {

struct RunArguments {
    std::string pipeline;
    JobOptions options;
};

int runPipeline(const RunArguments& arguments) { return runWithOptions(arguments.pipeline, {}, arguments.options); }

}  // namespace

void addRunCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "run", "Meshes the frames of a pipeline file.", runPipeline);
    command->footer(
        "Examples:\n"
        "  betamesh run pipelines/dambreak.yaml\n"
        "  betamesh run splash.yaml --frames 1-240 --chunk 3/8 --set surface.radius=1.4dx\n"
        "`betamesh config print` explains every key of a pipeline file. Relative paths of input and output start in\n"
        "the current folder; those of `include` start in the folder of the pipeline file.");
    command->add_option("PIPELINE", arguments->pipeline, "The pipeline file (.yaml).")->required();
    addJobOptions(*command, arguments->options);
    showInShortHelp(*command, {"--set", "--preset", "--frames", "--chunk", "--threads", "--memory-limit", "--overwrite",
                               "--skip-existing", "--dry-run", "--json", "--progress", "--log-file"});
}

}  // namespace betamesh
