#include "io/convert_file.h"

#include "batch/job/frames.h"
#include "batch/job/input_frames.h"
#include "batch/job/job.h"
#include "batch/job/left_out.h"
#include "batch/job/output_files.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/machine.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "each_file.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "io/usd_clips.h"
#include "job_options.h"
#include "standard_streams.h"
#include "value_checks.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

/// The configuration keys whose options this command has.
constexpr std::array<std::string_view, 6> kKeys{
    "input.grid", "input.on_bad_particle", "input.up_axis", "output.up_axis", "output.fps", "output.meters_per_unit"};

struct ConvertArguments {
    std::string input, output;
    std::string frames = "all";
    LevelSetOptions level_set{};
    std::map<std::string, std::string> values;  // of the keys of kKeys
    bool overwrite = false;
    bool quiet = false;
    std::string format;  ///< of stdout; empty: that of the input
};

struct ConversionTask {
    FileFrame input;
    std::string output;
    ConversionOptions options{};
};

ConversionOptions conversionOptions(const ConvertArguments& arguments) {
    Config config;
    for (const KeyValue& given : keyValuesOf({}, arguments.values))
        setConfigKey(config, given.path, given.value, given.where);
    const auto ifGiven = [&](const char* key, const auto& value) {
        return arguments.values.contains(key) ? std::optional(value) : std::nullopt;
    };
    ConversionOptions options;
    options.write.level_set = arguments.level_set;
    options.write.level_set.memory_limit = availableMemory();
    options.units.frames_per_second = ifGiven("output.fps", config.output.frames_per_second);
    options.units.up_axis = ifGiven("output.up_axis", config.output.up_axis);
    options.units.meters_per_unit = ifGiven("output.meters_per_unit", config.output.meters_per_unit);
    options.input_up_axis = ifGiven("input.up_axis", config.input.up_axis);
    options.grids = config.input.grid;
    options.on_bad_particle = config.input.on_bad_particle;
    return options;
}

std::vector<ConversionTask> tasksOf(const ConvertArguments& arguments) {
    const FramePattern output = framePattern(arguments.output);
    const ConversionOptions options = conversionOptions(arguments);
    Config::Input named;
    named.path = arguments.input;
    named.grid = options.grids;
    const InputFrames input = inputFrames(named, FileKind::mesh);
    const std::vector<int> frames = chosenFrames(arguments.frames, input, !output.numbered);
    requirePlaceholder(frames.size(), output);
    if (arguments.frames == "all") {
        warnOfLeftOut({arguments.input});
        for (const std::string& warning : leftOutOfFile(input, frames)) logWarning(warning);
    }
    std::vector<ConversionTask> tasks;
    for (const int frame : frames) {
        tasks.push_back({fileFrame(input, frame), frameName(output, frame), options});
        if (output.numbered) tasks.back().options.write.frame = frame;
        tasks.back().options.frame = tasks.back().input.sample();
    }
    return tasks;
}

/// errors  an extension that nothing is written with
void requireOutputFormat(const std::string& output) {
    const auto canWrite = [&](FileKind kind) { return canHold(output, kind, Access::write); };
    if (!canWrite(FileKind::particles) && !canWrite(FileKind::curves)) formatOf(output, FileKind::mesh, Access::write);
}

/// Throws Error before anything is written.
void requireOutputs(const std::vector<ConversionTask>& tasks, const ConvertArguments& arguments) {
    for (const auto& [input, output, options] : tasks) {
        std::error_code ignored;
        if (input.file == output || fs::equivalent(input.file, output, ignored))
            throw Error(output + " is both input and output. Choose another output");
        if (!arguments.overwrite && fs::exists(fs::symlink_status(output, ignored)))
            throw Error(output + " already exists. Use --overwrite to replace it.");
    }
}

std::string describe(const Conversion& done) {
    std::string text = std::to_string(done.points) + (done.kind == FileKind::particles ? " particles" : " vertices");
    if (done.kind == FileKind::mesh) text += ", " + std::to_string(done.triangles) + " triangles";
    if (done.kind == FileKind::curves) text += ", " + std::to_string(done.edges) + " edges";
    return text;
}

int convertFiles(const ConvertArguments& arguments) {
    requireOutputFormat(arguments.output);
    const std::vector<ConversionTask> tasks = tasksOf(arguments);
    requireOutputs(tasks, arguments);
    requireOwnSequenceLayer(framePattern(arguments.output));
    std::vector<std::string> outputs;
    for (const ConversionTask& task : tasks) outputs.push_back(task.output);
    std::set<std::string> folders;
    for (const std::string& output : outputs) folders.insert(folderOf(output));
    requireWritableFolders(folders);
    makeFoldersOf(outputs);
    std::set<std::string> warned;  // each loss is named once, not for each frame
    const auto convertTask = [&](std::size_t i) {
        const auto& [input, output, options] = tasks[i];
        const Conversion done = convertFile(input.file, output, options);
        for (const std::string& warning : done.warnings)
            if (warned.insert(warning).second) logWarning(input.file + ": " + warning);
        logInfo(input.text() + " -> " + output + ": " + describe(done));
        return true;
    };
    const int exit_code = forEachFile(
        tasks.size(),
        [&](std::size_t i) {
            return NamedFile{tasks[i].input.file, tasks[i].input.number()};
        },
        convertTask, [](std::size_t, const std::string&) {});
    // The frames know the units of the input, of which this process may have read nothing.
    WriteOptions of_layer;
    for (auto task = tasks.rbegin(); task != tasks.rend(); ++task) copyUsdUnits(task->output, of_layer);
    writeSequenceLayer(framePattern(arguments.output), of_layer);
    return exit_code;
}

int convert(const ConvertArguments& given) {
    ConvertArguments arguments = given;
    setLogLevel(arguments.quiet ? LogLevel::quiet : LogLevel::normal);
    StandardStreams streams;
    if (!arguments.format.empty() && arguments.output != kStandardStream)
        throw Error("--format is for OUT '-' only; the extension of " + arguments.output + " selects its format.");
    if (arguments.input == kStandardStream) arguments.input = streams.fileOfStdin();
    if (arguments.output == kStandardStream) {
        const std::string extension =
            arguments.format.empty() ? splitExtension(arguments.input).second : '.' + arguments.format;
        arguments.output = streams.fileForStdout(extension);
    }
    const int exit_code = convertFiles(arguments);
    if (exit_code == kAllWritten) streams.writeStdout();
    return exit_code;
}

}  // namespace

void addConvertCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "convert",
                   "Converts particles, meshes or curves from one file format to another.", convert);
    command->footer(
        "Particles stay particles, and meshes meshes. A warning lists once what the output format cannot hold.\n"
        "Frame rate, up axis and unit of length are those of IN where both formats store them, unless options say\n"
        "otherwise. The geometry is rotated only where --output-up-axis differs from the up axis of IN.\n"
        "IN and OUT may be - for stdin (a file that its contents identify) and stdout.\n"
        "`betamesh manual man` lists the formats.\n"
        "Exit codes: 0 every file converted; 1 some were not; 2 wrong usage, or an output that exists already.\n"
        "Examples:\n"
        "  betamesh convert splash.0012.bgeo.sc splash.0012.ply\n"
        "  betamesh convert splash.0012.ply splash.0012.vdb --voxel 0.01\n"
        "  betamesh convert 'sim/splash.####.vdb' 'csv/splash.####.csv' --frames 1-24\n"
        "  betamesh convert - - --format csv < splash.0012.ply > splash.0012.csv");
    command
        ->add_option("IN", arguments->input,
                     "Files to read (" + readableExtensions() + "). Write the frame number of a sequence as ####.")
        ->required();
    command
        ->add_option("OUT", arguments->output,
                     "Files to write: particles (" + extensionsFor(FileKind::particles, Access::write) + "), meshes (" +
                         extensionsFor(FileKind::mesh, Access::write) + "); with a frame number if IN has one.")
        ->required();
    command
        ->add_option("--format", arguments->format,
                     "Format on stdout (OUT -): an extension without its dot. Without it, that of IN.")
        ->type_name("EXT");
    command->add_option("--frames", arguments->frames, "Frames to convert, such as 1-24. all: every frame on disk.")
        ->type_name("FRAMES")
        ->capture_default_str();
    command
        ->add_option(
            "--voxel", arguments->level_set.voxel,
            "Voxel size of level sets, which .vdb files of meshes are, in world units. 0: the median length of "
            "the edges of the mesh.")
        ->type_name("LENGTH")
        ->check(numberFromZero())
        ->capture_default_str();
    command->add_option("--band", arguments->level_set.band, "Half width of the narrow band of level sets, in voxels.")
        ->type_name("N")
        ->check(CLI::Range(1.0, 100.0))
        ->capture_default_str();
    command->add_flag("--velocity-grid", arguments->level_set.velocity,
                      "Write the grid v of velocities beside a level set.");
    addKeyOptions(*command, arguments->values,
                  [](const ConfigKey& key) { return std::find(kKeys.begin(), kKeys.end(), key.path) != kKeys.end(); });
    command->add_flag("--overwrite", arguments->overwrite, "Replace outputs that already exist.");
    command->add_flag("-q,--quiet", arguments->quiet, "Print only errors.");
}

}  // namespace betamesh
