#include "command.h"
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
    const auto [command, arguments] =
        addCommand(program, exit_code, "mesh", "Skins one frame or a sequence, without a pipeline file.", run);
    command->footer(
        "Examples:\n"
        "  betamesh mesh splash.0012.bgeo splash.0012.ply\n"
        "  betamesh mesh flip.0012.vdb flip.0012.ply --preset flip\n"
        "  betamesh mesh sim/splash.####.vdb mesh/splash.####.ply --radius 0.03 --frames 1-240 --skip-existing");
    command
        ->add_option(
            "IN", arguments->input,
            "Particles (.vdb .bgeo .bgeo.gz .ply); #### @@@@ %04d $F4 $F stand for the frame number. Quote $F4: shells "
            "read it otherwise.")
        ->required();
    command
        ->add_option("OUT", arguments->output,
                     "Meshes (.ply .bgeo .bgeo.gz .obj), with a frame number where IN has several frames.")
        ->required();
    addJobOptions(*command, arguments->options);
}

}  // namespace betamesh
