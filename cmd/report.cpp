#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/report/log.h"
#include "batch/report/report_page.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/bytes.h"
#include "io/output_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::vector<std::string> manifests;
    std::string output;
    std::string frames;
    std::string coherence;
    std::string previews;
    std::string title;
};

std::string bytesOf(const std::string& file) {
    requireRegularFile(file);
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Error(file + ": cannot be read. Give pictures (.png) to --previews.");
    return {std::istreambuf_iterator<char>(in), {}};
}

ReportPage pageOf(const Arguments& arguments) {
    ReportPage page;
    page.title = arguments.title.empty() ? fs::path(arguments.output).stem().string() : arguments.title;
    std::vector<int> found;
    for (const std::string& file : filesNamed(arguments.manifests)) {
        const auto report = readReport(file);
        if (!report)
            throw Error(
                file +
                ": this is not the manifest of a frame. Give the NAME.json files that are written beside the meshes.");
        page.frames.push_back(*report);
        found.push_back(report->frame);
    }
    std::sort(page.frames.begin(), page.frames.end(),
              [](const FrameReport& a, const FrameReport& b) { return a.frame < b.frame; });
    std::sort(found.begin(), found.end());
    if (!arguments.frames.empty()) {
        const std::vector<int> expected = parseFrames(arguments.frames);
        std::set_difference(expected.begin(), expected.end(), found.begin(), found.end(),
                            std::back_inserter(page.missing));
    }
    if (!arguments.coherence.empty())
        for (const CoherenceReport& jump : readCoherence(arguments.coherence))
            page.jump[singleFrame(framePattern(jump.to))] = jump.distance.max;
    if (!arguments.previews.empty())
        for (const auto& [frame, file] : framesOnDisk(framePattern(arguments.previews)))
            page.preview_png[frame] = bytesOf(file);
    return page;
}

/// errors  the page is a file that it is made from
void requireDistinctFiles(const Arguments& arguments) {
    DistinctFiles files;
    for (const std::string& file : filesNamed(arguments.manifests)) files.read(file, "a manifest");
    if (!arguments.coherence.empty()) files.read(arguments.coherence, "the file of --coherence");
    if (!arguments.previews.empty())
        for (const auto& [frame, file] : framesOnDisk(framePattern(arguments.previews))) files.read(file, "a preview");
    files.written(arguments.output, "the page");
}

int report(const Arguments& arguments) {
    requireDistinctFiles(arguments);
    const ReportPage page = pageOf(arguments);
    writeFile(arguments.output, htmlOf(page));
    logInfo(std::to_string(page.frames.size()) + " frames -> " + arguments.output);
    if (page.missing.empty()) return kAllWritten;
    logError("There are no manifests of frames " + printFrames(page.missing) +
             ". Run the job again with --skip-existing.");
    return kSomeFailed;
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
                     "number (####) "
                     "stands for every frame on disk.")
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
                     "Pictures of the frames (.png), with a frame number (####) in the name, to include in the page.")
        ->type_name("FILES");
    command->add_option("--title", arguments->title, "Title of the page. Without it, the name of the file.")
        ->type_name("TEXT");
}

}  // namespace betamesh
