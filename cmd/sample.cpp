#include "sample/sample.h"

#include "batch/config/key_types.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/output_files.h"
#include "batch/job/usd_sequence.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/machine.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "value_checks.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDefaultFrames = "1-24";

struct SampleArguments {
    std::string output;
    std::string frames;
    SampleParams params;
    bool overwrite = false;
    bool skip_existing = false;
    bool quiet = false;
};

std::string listOfSamples() {
    std::string list =
        "Particles have the attributes v and id. The same program always writes the same bytes, on any number of\n"
        "threads. Another compiler or C library may round differently and so give a slightly different splash.\n"
        "Samples:\n";
    for (const SampleInfo& sample : samples()) {
        list += "  " + sample.name + std::string(sample.name.size() < 12 ? 12 - sample.name.size() : 1, ' ') +
                sample.description + " (" + std::to_string(sample.particles) + " particles)\n";
    }
    return list + "Example:\n  betamesh sample dambreak sim/dambreak.####.vdb --frames 1-48";
}

/// errors  more particles than fit into memory, before the system is busy with them
void requireMemory(std::size_t particles) {
    constexpr double kParticleBytes = 250;  // 110 of a lattice, 290 of a dam break, 375 of a rotating cube
    constexpr double kGibibyte = 0x1p30;
    const double needed = static_cast<double>(particles) * kParticleBytes;
    const auto available = static_cast<double>(availableMemory());
    if (needed <= available) return;
    const auto gibibytes = [](double bytes) { return shortNumber(std::round(bytes / kGibibyte * 10) / 10) + " GiB"; };
    throw Error("--particles " + std::to_string(particles) + " need about " + gibibytes(needed) + ", but there are " +
                gibibytes(available) + ". Use at most " +
                std::to_string(static_cast<std::uint64_t>(available / kParticleBytes)));
}

std::vector<int> framesOf(const SampleArguments& arguments, const FramePattern& pattern) {
    if (arguments.frames.empty()) {
        return pattern.numbered ? parseFrames(kDefaultFrames)
                                : std::vector<int>{std::max(1, frameInName(pattern.text))};
    }
    std::vector<int> frames = parseFrames(arguments.frames);
    requirePlaceholder(frames.size(), pattern);
    return frames;
}

int writeSample(const SampleArguments& arguments) {
    keepFreedMemory();
    setLogLevel(arguments.quiet ? LogLevel::quiet : LogLevel::normal);
    requireParticleExtension(arguments.output);
    if (arguments.overwrite && arguments.skip_existing) {
        throw Error("--overwrite and --skip-existing contradict each other. Use one of them.");
    }
    const FramePattern pattern = framePattern(arguments.output);
    std::vector<int> frames = framesOf(arguments, pattern);
    const auto exists = [&](int frame) {
        std::error_code ignored;  // that a folder cannot be read is said when it is written to
        return fs::exists(frameName(pattern, frame), ignored);
    };
    if (arguments.skip_existing) std::erase_if(frames, exists);
    for (const int frame : frames) {
        if (!arguments.overwrite && exists(frame)) {
            throw Error(frameName(pattern, frame) +
                        " already exists. Use --overwrite to replace it or --skip-existing to resume.");
        }
    }
    requireOwnSequenceLayer(pattern);
    requireMemory(arguments.params.particles);
    Sample sample(arguments.params);
    std::vector<std::string> files;
    for (const int frame : frames) files.push_back(frameName(pattern, frame));
    std::set<std::string> folders;
    for (const std::string& file : files) folders.insert(folderOf(file));
    requireWritableFolders(folders);
    makeFoldersOf(files);
    rememberSignals();
    std::size_t failed = 0;
    for (const int frame : frames) {
        if (caughtSignal() != 0) return kSignalBase + caughtSignal();
        const Particles particles = sample.frame(frame);
        try {
            writeParticles(frameName(pattern, frame), particles, {.frame = frame});
            logInfo("frame " + std::to_string(frame) + ": " + std::to_string(particles.size()) + " particles -> " +
                    frameName(pattern, frame));
        } catch (const Error& error) {
            logError("frame " + std::to_string(frame) + ": " + error.what());
            ++failed;
        }
    }
    bool layer_failed = false;
    try {
        writeSequenceLayer(pattern, {});
    } catch (const Error& error) {
        logError(error.what());
        layer_failed = true;
    }
    logInfo(std::to_string(frames.size() - failed) + " frames written; nominal particle spacing " +
            std::to_string(sample.spacing()));
    return failed > 0 || layer_failed ? kSomeFailed : kAllWritten;
}

}  // namespace

void addSampleCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] = addCommand(
        program, exit_code, "sample", "Writes an animated particle sequence to try betamesh with.", writeSample);
    command->footer(listOfSamples());
    command->add_option("NAME", arguments->params.name, "Name of the sample; listed below.")->required();
    command
        ->add_option("OUT", arguments->output,
                     "Particle files to write (" + extensionsFor(FileKind::particles, Access::write) +
                         "), such as sim/drop.####.vdb.")
        ->required();
    command
        ->add_option("--particles", arguments->params.particles,
                     "Approximate number of particles. Without it, the number listed below.")
        ->type_name("N")
        ->check(wholeNumber(1));
    command
        ->add_option("--frames", arguments->frames,
                     std::string("Frames to write, such as 1-100. Without it, ") + kDefaultFrames +
                         ", or the frame in the name of a single file.")
        ->type_name("FRAMES");
    command->add_option("--seed", arguments->params.seed, "Random seed; each seed gives another sequence.")
        ->type_name("S")
        ->capture_default_str()
        ->check(wholeNumber(0));
    command->add_flag("--overwrite", arguments->overwrite, "Replace files that already exist.");
    command->add_flag("--skip-existing", arguments->skip_existing, "Skip frames that already exist.");
    command->add_flag("-q,--quiet", arguments->quiet, "Print only errors.");
}

}  // namespace betamesh
