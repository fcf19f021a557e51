#include "batch/job/plan.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "help.h"
#include "io/extension.h"
#include "job_options.h"
#include "standard_streams.h"
#include "value_checks.h"

#include <filesystem>
#include <sstream>
#include <string_view>

namespace betamesh {
namespace {

struct MeshArguments {
    std::string input, output;
    std::string format;  ///< of stdout; empty: that of the input
    JobOptions options;
};

/// The formats of meshes on stdout: extensions without their dots.
std::vector<std::string> streamFormats() {
    std::istringstream in(extensionsFor(FileKind::mesh, Access::write));
    std::vector<std::string> names;
    for (std::string extension; in >> extension;) names.push_back(extension.substr(1));
    return names;
}

/// The extension of the mesh on stdout: --format, or that of the input if meshes can have it.
std::string extensionForStdout(const MeshArguments& arguments, const std::string& input) {
    if (!arguments.format.empty()) return '.' + arguments.format;
    const FileFormat& format = formatOf(input, FileKind::particles, Access::read);
    const std::string_view extensions =
        format.write_mesh != nullptr && !format.is_volume ? format.write_extensions : ".ply";
    return std::string(extensions.substr(0, extensions.find(' ')));
}

int meshFiles(const MeshArguments& arguments) {
    StandardStreams streams;
    std::string input = arguments.input, output = arguments.output;
    JobOptions options = arguments.options;
    if (!arguments.format.empty() && output != kStandardStream)
        throw Error("--format is for OUT '-' only; the extension of " + output + " selects its format.");
    if (input == kStandardStream) input = streams.fileOfStdin();
    if (output == kStandardStream) {
        if (options.json || options.dry_run)
            throw Error(std::string(options.json ? "--json" : "--dry-run") +
                        " prints on stdout, where OUT '-' writes the mesh. Use a file as OUT.");
        output = streams.fileForStdout(extensionForStdout(arguments, input));
        options.stdout_is_taken = true;
    }
    const int exit_code = runWithOptions("", {{"input.path", input, "IN"}, {"output.path", output, "OUT"}}, options);
    if (exit_code == 0 && streams.writeStdout() && std::filesystem::exists(spheresPath(output)))
        logWarning("the spheres beside the mesh are left out, because stdout holds one file. Give a file as OUT.");
    return exit_code;
}

}  // namespace

void addMeshCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "mesh",
                   "Meshes one frame or a sequence of particle files, without a pipeline file.", meshFiles);
    command->footer(
        "IN and OUT may be - for stdin (a file that its contents identify) and stdout. A mesh on\n"
        "stdout has no manifest and no spheres beside it.\n"
        "Examples:\n"
        "  betamesh mesh splash.0012.bgeo splash.0012.ply\n"
        "  betamesh mesh flip.0012.vdb flip.0012.ply --preset flip\n"
        "  betamesh mesh sim/splash.####.vdb mesh/splash.####.ply --radius 0.03 --frames 1-240 --skip-existing\n"
        "  betamesh mesh - - --format bgeo < splash.0012.ply > splash.0012.bgeo");
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
    std::string formats;
    for (const std::string& format : streamFormats()) formats += (formats.empty() ? "" : "|") + format;
    command
        ->add_option("--format", arguments->format,
                     "Format of the mesh on stdout (OUT -). Without it, that of IN, or ply if meshes cannot have it.")
        ->type_name(formats)
        ->check(oneOf(streamFormats()))
        ->group("Output");
    showInShortHelp(*command, {"--preset", "--frames", "--radius", "--spacing", "--dimension", "--skin", "--passes",
                               "--attributes", "--threads", "--overwrite", "--skip-existing", "--dry-run"});
}

}  // namespace betamesh
