#include "preview_options.h"

#include "base/lower_case.h"
#include "base/parallel.h"
#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "batch/job/job.h"
#include "batch/job/left_out.h"
#include "batch/job/movie_file.h"
#include "batch/job/output_files.h"
#include "batch/job/plan.h"
#include "batch/job/render_frames.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "job_options.h"
#include "render/contact_sheet.h"
#include "render/exr_file.h"
#include "render/png_file.h"
#include "value_checks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

bool exists(const std::string& file) {
    std::error_code ignored;  // that a folder cannot be read is said when it is written to
    return fs::exists(file, ignored);
}

bool allExist(const std::vector<std::string>& files) { return std::ranges::all_of(files, exists); }

void refuseExisting(const std::vector<std::string>& outputs) {
    for (const std::string& output : outputs)
        if (!output.empty() && exists(output))
            throw Error(output + " already exists. Use --overwrite to replace it or --skip-existing to keep it.");
}

/// errors  a contact sheet or movie whose name says that it has another format
void requireFormats(const PreviewOptions& options) {
    const auto require = [](const std::string& file, const char* extension, const char* what) {
        if (!file.empty() && lowerCase(fs::path(file).extension().string()) != extension)
            throw Error(file + ": " + what + " are written as " + extension + ". Use a name that ends in " + extension);
    };
    require(options.contact_sheet, ".png", "contact sheets");
    require(options.movie, ".mp4", "movies");
}

/// errors  a folder of previews that are going to be written, of the contact sheet or of the movie
void checkFolders(const PreviewJob& job) {
    std::set<std::string> folders;
    for (const PreviewTask& task : job.tasks)
        for (const std::string& output : task.outputs)
            if (!task.keep) folders.insert(folderOf(output));
    for (const std::string& file : {job.options.contact_sheet, job.options.movie})
        if (!file.empty()) folders.insert(folderOf(file));
    requireWritableFolders(folders);
}

void warnOfSheetOptions(const PreviewOptions& options) {
    const PreviewOptions defaults;
    const bool given = options.sheet_pictures != defaults.sheet_pictures ||
                       options.sheet_width != defaults.sheet_width || options.sheet_columns != defaults.sheet_columns;
    if (given && options.contact_sheet.empty())
        logWarning("--sheet-pictures, --sheet-width and --sheet-columns have no effect without --contact-sheet");
}

/// errors  a file that would be both read and written, or written twice
void requireDistinctFiles(const PreviewJob& job) {
    DistinctFiles files;
    if (!job.options.pipeline.empty()) files.read(job.options.pipeline, "the pipeline file");
    for (const auto& [frame, file] : job.input.files) files.read(file, "the input of frame " + std::to_string(frame));
    for (const PreviewTask& task : job.tasks) {
        const std::string of_frame = " of frame " + std::to_string(task.frame);
        files.read(task.input, "the input" + of_frame);
        for (std::size_t i = 0; i < task.outputs.size(); ++i)
            files.written(task.outputs[i], (i == 0 ? "the preview" : "the second preview") + of_frame);
    }
    if (!job.options.contact_sheet.empty()) files.written(job.options.contact_sheet, "the contact sheet");
    if (!job.options.movie.empty()) files.written(job.options.movie, "the movie");
}

void writeWhole(const std::string& file, std::string_view bytes) {
    makeFoldersOf({file});
    writeFile(file, bytes);
}

Image readImage(const std::string& file) {
    const Bytes bytes = readWholeFile(file);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return isExr(file) ? toneMapped(decodeExr(text, file)) : decodePng(text, file);
}

/// Collects the previews for the contact sheet and the movie.
class Collection {
public:
    Collection(const PreviewOptions& options, double fps, std::size_t previews)
        : options_(options), fps_(fps), previews_(previews) {}

    bool isWanted() const { return !options_.contact_sheet.empty() || !options_.movie.empty(); }
    void add(std::size_t i, int frame, const Image& image) {
        if (!options_.movie.empty()) {
            if (!movie_) {
                makeFoldersOf({options_.movie});
                movie_.emplace(options_.movie, image.width, image.height, fps_);
            }
            movie_->add(image);
        }
        if (!options_.contact_sheet.empty() && isOnSheet(i)) {
            const int width = std::min(options_.sheet_width, image.width);
            cells_.push_back({shrunk(image, width, std::max(1, image.height * width / image.width)),
                              "frame " + std::to_string(frame)});
        }
    }
    void finish() {
        if (movie_) movie_->finish();
        if (cells_.empty()) return;
        const auto square = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(cells_.size()))));
        const int columns = options_.sheet_columns > 0 ? options_.sheet_columns : square;
        writeWhole(options_.contact_sheet, encodePng(contactSheet(cells_, columns)));
    }

private:
    /// Whether preview i is one of the evenly chosen ones, which include the first and the last.
    bool isOnSheet(std::size_t i) const {
        const auto cells = static_cast<std::size_t>(options_.sheet_pictures);
        if (previews_ <= cells) return true;
        if (cells == 1) return i == 0;
        const std::size_t cell = (i * (cells - 1) + (previews_ - 1) / 2) / (previews_ - 1);
        return (cell * (previews_ - 1) + (cells - 1) / 2) / (cells - 1) == i;
    }

    const PreviewOptions& options_;
    double fps_;
    std::size_t previews_;
    std::vector<CaptionedImage> cells_;
    std::optional<Movie> movie_;
};

}  // namespace

void addPreviewOptions(CLI::App& command, PreviewOptions& options,
                       const std::function<bool(const ConfigKey&)>& wanted) {
    addKeyOptions(command, options.values, wanted);
    command
        .add_option("--pipeline", options.pipeline,
                    "Also use the keys of this pipeline file, except its paths and frames. Options win.")
        ->type_name("FILE.yaml")
        ->group("Running");
    command
        .add_option(
            "--set", options.assignments,
            "Set any key of a pipeline file, as in --set preview.samples=32; may be repeated. An option for the "
            "same key wins over --set.")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all()
        ->group("Running");
    command
        .add_option("--contact-sheet", options.contact_sheet,
                    "Also write small previews of the sequence side by side on one sheet.")
        ->type_name("FILE.png")
        ->group("Sequence");
    command
        .add_option("--sheet-pictures", options.sheet_pictures,
                    "Largest number of previews on the contact sheet, chosen evenly from the sequence.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(1, 1000))
        ->group("Sequence");
    command
        .add_option("--sheet-width", options.sheet_width, "Largest width of a preview on the contact sheet, in pixels.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(16, 16384))
        ->group("Sequence");
    command
        .add_option("--sheet-columns", options.sheet_columns,
                    "Number of columns of the contact sheet. Without it, about as many as there are rows.")
        ->type_name("N")
        ->check(wholeNumber(1, 1000))
        ->group("Sequence");
    command.add_option("--movie", options.movie, "Also write the sequence as a movie at --fps; requires ffmpeg.")
        ->type_name("FILE.mp4")
        ->group("Sequence");
    command.add_flag("--overwrite", options.overwrite, "Replace outputs that already exist.")->group("Running");
    command.add_flag("--skip-existing", options.skip_existing, "Skip frames whose previews already exist.")
        ->group("Running");
    command.add_flag("-q,--quiet", options.quiet, "Print only errors.")->group("Running");
}

PreviewJob planPreviews(const PreviewOptions& options, FileKind kind, const Config& defaults) {
    setLogLevel(options.quiet ? LogLevel::quiet : LogLevel::normal);
    if (options.overwrite && options.skip_existing)
        throw Error("--overwrite and --skip-existing contradict each other. Use one of them.");
    std::vector<KeyValue> given{{"frames", Config{}.frames, ""}};  // instead of the frames of the pipeline
    const auto from_options = keyValuesOf(options.assignments, options.values);
    given.insert(given.end(), from_options.begin(), from_options.end());
    const Config base = options.pipeline.empty() ? defaults : Config{};
    PreviewJob job{outputConfigs(readConfig(options.pipeline, given, base)).front(), {}, {}, options};
    job.config.input.path = options.input;
    job.input = inputFrames(job.config.input, kind);
    job.config.input.is_one_file = job.input.is_one_file;
    std::vector<FramePattern> outputs;
    for (const std::string& output : options.outputs) outputs.push_back(framePattern(output));
    const bool one_output = !std::ranges::all_of(outputs, &FramePattern::numbered);
    const std::vector<int> frames = chosenFrames(job.config.frames, job.input, one_output);
    if (job.config.frames == "all") {
        warnOfLeftOut({options.input});
        for (const std::string& warning : leftOutOfFile(job.input, frames)) logWarning(warning);
    }
    for (const FramePattern& output : outputs) requirePlaceholder(frames.size(), output);
    for (const int frame : frames) {
        PreviewTask task{frame, fileOfFrame(job.input.pattern, job.input.files, frame), {}, false};
        for (const FramePattern& output : outputs) task.outputs.push_back(frameName(output, frame));
        task.keep = options.skip_existing && allExist(task.outputs);
        if (!options.skip_existing && !options.overwrite) refuseExisting(task.outputs);
        job.tasks.push_back(std::move(task));
    }
    if (!options.skip_existing && !options.overwrite) refuseExisting({options.contact_sheet, options.movie});
    requireDistinctFiles(job);
    requireFormats(options);
    if (!options.movie.empty()) Movie::requireEncoder();
    checkFolders(job);
    warnOfSheetOptions(options);
    return job;
}

int inPreviewWorker(const PreviewJob& job, const std::function<int(const PreviewWorker&)>& work) {
    rememberSignals();
    const Supervision watched = superviseWorkers(isVdb(job.config.input.path), job.config.run.timeout);
    if (!watched.is_worker) return watched.exit_code;
    SignalWatch signals;
    int exit_code = kAllWritten;
    withThreads(threadsOf(job.config), [&] { exit_code = work({watched.events, watched.history, signals}); });
    return exit_code;
}

int writePreviews(const PreviewJob& job, const PreviewWorker& worker,
                  const std::function<Rendering(const PreviewTask&)>& render) {
    Collection collection(job.options, job.config.preview.fps, job.tasks.size());
    const JobHistory& history = worker.history;
    bool any_failed = history.failed > 0;
    const auto write = [&](std::size_t i) {
        const PreviewTask& task = job.tasks[i];
        if (task.keep || history.ended.contains(task.frame)) {
            if (collection.isWanted() && allExist(task.outputs))
                collection.add(i, task.frame, readImage(task.outputs.front()));
            return;
        }
        if (const auto lost = history.lost.find(task.frame); lost != history.lost.end())
            throw Error(task.input + ": " + lost->second);
        fileFrame(job.input, task.frame);  // throws if it is not there
        const auto begin = std::chrono::steady_clock::now();
        const Rendering rendering = render(task);
        const SignalWatch::Writing writing(worker.signals);
        for (std::size_t k = 0; k < rendering.files.size(); ++k) writeWhole(task.outputs[k], rendering.files[k]);
        if (collection.isWanted()) collection.add(i, task.frame, rendering.image);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        char time[32];
        std::snprintf(time, sizeof time, "%.2f s", seconds.count());
        logInfo(fileFrame(job.input, task.frame).text() + " -> " + task.outputs.front() + " in " + time);
    };
    for (std::size_t i = 0; i < job.tasks.size(); ++i) {
        const int frame = job.tasks[i].frame;
        if (caughtSignal() != 0) return kSignalBase + caughtSignal();
        const WorkerEvents::FrameInProgress at_work(worker.events, frame);
        FrameStatus status = FrameStatus::ok;
        try {
            write(i);
        } catch (const Interrupted&) {
            continue;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            const std::string& file = job.tasks[i].input;
            const std::string advice = adviceOnStars(file), text = error.what();
            const bool names_file = text.find(file) != std::string::npos ||
                                    std::ranges::any_of(job.tasks[i].outputs, [&](const auto& output) {
                                        return text.find(output) != std::string::npos;
                                    });
            logError("frame " + std::to_string(frame) + ": " + (names_file ? "" : file + ": ") + text +
                     (advice.empty() ? "" : '.' + advice));
            status = FrameStatus::failed;
            any_failed = true;
        }
        worker.events.ended(frame, status);
    }
    try {
        collection.finish();
    } catch (const Error& error) {
        logError(error.what());
        any_failed = true;
    }
    return history.out_of_memory ? kOutOfMemory : any_failed ? kSomeFailed : kAllWritten;
}

}  // namespace betamesh
