#include "command.h"
#include "help.h"
#include "io/extension.h"
#include "job_options.h"

namespace betamesh {
namespace {

struct Arguments {
    std::string input, output;
    JobOptions options;
};

int run(const Arguments& arguments) {
    return runWithOptions("", {{"input.path", arguments.input, "IN"}, {"output.path", arguments.output, "OUT"}},
                          arguments.options);
}

}  // namespace

void addMeshCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] = addCommand(
        program, exit_code, "mesh", "Meshes one frame or a sequence of particle files, without a pipeline file.", run);
    command->footer(
        "Examples:\n"
        "  betamesh mesh splash.0012.bgeo splash.0012.ply\n"
        "  betamesh mesh flip.0012.vdb flip.0012.ply --preset flip\n"
        "  betamesh mesh sim/splash.####.vdb mesh/splash.####.ply --radius 0.03 --frames 1-240 --skip-existing");
    command
        ->add_option(
            "IN", arguments->input,
            "Particle files (" + extensionsFor(FileKind::particles, Access::read) +
                "). Write the frame number as ####, @@@@, %04d, '$F4' or '$F'; the last two need quotes in a shell.")
        ->required();
    command
        ->add_option("OUT", arguments->output,
                     "Mesh files to write (" + extensionsFor(FileKind::mesh, Access::write) +
                         "), with a frame number if IN has one.")
        ->required();
    addJobOptions(*command, arguments->options);
    showInShortHelp(*command, {"--preset", "--frames", "--radius", "--spacing", "--dimension", "--skin", "--passes",
                               "--attributes", "--threads", "--overwrite", "--skip-existing", "--dry-run"});
}

}  // namespace betamesh
