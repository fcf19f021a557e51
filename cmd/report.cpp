#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/report/log.h"
#include "batch/report/report_page.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/output_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
    std::vector<std::string> manifests;
    std::string output;
    std::string frames;
    std::string coherence;
    std::vector<std::string> previews;
    std::string title;
};

std::string bytesOf(const std::string& file) {
    requireRegularFile(file);
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Error(file + ": cannot be read. Give previews (.png) to --previews.");
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The files that an argument stands for. A pattern without any is an output whose frames all failed if it is known
/// which ones are expected.
std::vector<std::string> manifestsNamed(const std::string& argument, const ReportArguments& arguments) {
    const FramePattern pattern = framePattern(argument);
    const bool none = pattern.numbered && !fs::exists(argument) && framesOnDisk(pattern).empty();
    return none && !arguments.frames.empty() ? std::vector<std::string>{} : filesNamed({argument});
}

/// The outputs that manifests are of, in the order of the arguments: those of a pattern are of one output.
std::vector<ReportOutput> outputsOf(const ReportArguments& arguments) {
    std::vector<ReportOutput> outputs;
    for (const std::string& argument : arguments.manifests) {
        const bool is_pattern = framePattern(argument).numbered;
        const auto outputNamed = [&](const std::string& name) -> ReportOutput& {
            const auto at = std::find_if(outputs.begin(), outputs.end(), [&](const auto& o) { return o.name == name; });
            return at != outputs.end() ? *at : outputs.emplace_back(ReportOutput{name, {}, {}, {}});
        };
        const std::string of_pattern = fs::path(argument).replace_extension().string();
        if (is_pattern) outputNamed(of_pattern);
        for (const std::string& file : manifestsNamed(argument, arguments)) {
            const auto report = readManifest(file);
            if (!report && !fs::exists(file))
                throw Error(file + ": no such file. Give NAME.json files, or a pattern such as NAME.####.ply.json.");
            if (!report)
                throw Error(file +
                            ": this is not the manifest of a frame. Give the NAME.json files that are written beside "
                            "the meshes.");
            outputNamed(is_pattern ? of_pattern : sequenceName(report->output, report->frame))
                .frames.push_back(*report);
        }
    }
    return outputs;
}

/// Sorts the frames of an output, and lists those that are expected and not there.
void completeFrames(ReportOutput& output, const std::vector<int>& expected) {
    std::sort(output.frames.begin(), output.frames.end(),
              [](const FrameResult& a, const FrameResult& b) { return a.frame < b.frame; });
    std::vector<int> found;
    for (const FrameResult& result : output.frames) found.push_back(result.frame);
    std::set_difference(expected.begin(), expected.end(), found.begin(), found.end(),
                        std::back_inserter(output.missing));
}

ReportPage pageOf(const ReportArguments& arguments) {
    ReportPage page;
    page.title = arguments.title.empty() ? fs::path(arguments.output).stem().string() : arguments.title;
    page.outputs = outputsOf(arguments);
    const std::vector<int> expected = arguments.frames.empty() ? std::vector<int>{} : parseFrames(arguments.frames);
    for (ReportOutput& output : page.outputs) completeFrames(output, expected);
    if (!arguments.coherence.empty())
        for (const CoherenceReport& jump : readCoherence(arguments.coherence)) {
            const int frame = jump.to_frame.value_or(frameInName(jump.to));
            // The jump belongs to the output with a mesh of that name, to the first if there is none.
            const auto writes = [&](const ReportOutput& output) {
                return fs::path(output.name).filename() == fs::path(sequenceName(jump.to, frame)).filename();
            };
            const auto output = std::find_if(page.outputs.begin(), page.outputs.end(), writes);
            (output == page.outputs.end() ? page.outputs.front() : *output).jump[frame] = jump.distance.max;
        }
    for (const std::string& pattern : arguments.previews) {
        ReportPreviews& previews = page.previews.emplace_back(ReportPreviews{pattern, {}});
        for (const auto& [frame, file] : framesOnDisk(framePattern(pattern))) previews.png[frame] = bytesOf(file);
    }
    return page;
}

/// errors  the page is a file that it is made from
void requireDistinctFiles(const ReportArguments& arguments) {
    DistinctFiles files;
    for (const std::string& argument : arguments.manifests)
        for (const std::string& file : manifestsNamed(argument, arguments)) files.read(file, "a manifest");
    if (!arguments.coherence.empty()) files.read(arguments.coherence, "the file of --coherence");
    for (const std::string& pattern : arguments.previews)
        for (const auto& [frame, file] : framesOnDisk(framePattern(pattern))) files.read(file, "a preview");
    files.written(arguments.output, "the page");
}

int report(const ReportArguments& arguments) {
    if (splitExtension(arguments.output).second != ".html")
        throw Error("--output: " + arguments.output +
                    " does not end in .html, the format of the page. Give a FILE.html.");
    requireDistinctFiles(arguments);
    const ReportPage page = pageOf(arguments);
    makeFoldersOf({arguments.output});
    writeFile(arguments.output, htmlOf(page));
    bool complete = true;
    for (const ReportOutput& output : page.outputs) {
        const std::string of = page.outputs.size() > 1 ? " of " + output.name : "";
        logInfo(std::to_string(output.frames.size()) + " frames" + of + " -> " + arguments.output);
        if (output.missing.empty()) continue;
        complete = false;
        logError("There are no manifests of frames " + printFrames(output.missing) + of +
                 ". Run the job again with --skip-existing.");
    }
    return complete ? kAllWritten : kSomeFailed;
}

}  // namespace

void addReportCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "report", "Makes an HTML page of a whole job, with plots over time.", report);
    command->footer(
        "Exit codes: 0 written; 1 written, but manifests of some --frames are missing; 2 wrong usage.\n"
        "Example:\n"
        "  betamesh report 'mesh/splash.####.ply.json' -o splash.html --frames 1-240");
    command
        ->add_option("MANIFEST", arguments->manifests,
                     "Manifests of frames, which are written beside the meshes as NAME.json. A pattern with a frame "
                     "number (####) stands for every frame on disk. The page shows each output of a job that has "
                     "several.")
        ->required();
    command->add_option("-o,--output", arguments->output, "The page to write. It needs no other files and no network.")
        ->type_name("FILE.html")
        ->required();
    command
        ->add_option("--frames", arguments->frames,
                     "Frames that must be present, such as 1-240; missing ones are listed.")
        ->type_name("FRAMES");
    command
        ->add_option("--coherence", arguments->coherence,
                     "Output of `betamesh coherence --json` for the meshes, to plot how far the surface moved.")
        ->type_name("FILE");
    command
        ->add_option("--previews", arguments->previews,
                     "Previews of the frames (.png), with a frame number (####) in the name, to include in the page. "
                     "May be repeated.")
        ->type_name("FILES")
        ->expected(1)
        ->allow_extra_args(false)
        ->take_all();
    command->add_option("--title", arguments->title, "Title of the page. Without it, the name of the file.")
        ->type_name("TEXT");
}

}  // namespace betamesh
