// Options of previews, shared by `render` and `compare`, and rendering them one after the other.

#pragma once

#include "batch/config/config.h"
#include "batch/job/input_frames.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/worker.h"
#include "render/picture.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace betamesh {

struct PreviewOptions {
    std::string input;
    std::vector<std::string> outputs;
    std::map<std::string, std::string> values;  ///< key -> value given by its option
    std::vector<std::string> assignments;       ///< KEY=VALUE of each --set, in order
    std::string pipeline;                       ///< pipeline file; empty: none
    std::string contact_sheet;                  ///< file to write; empty: none
    int sheet_pictures = 12;                    ///< at most, on the contact sheet
    int sheet_width = 600;                      ///< pixels per preview on the contact sheet
    int sheet_columns = 0;                      ///< 0: about as many as rows
    std::string movie;                          ///< file to write; empty: none
    bool overwrite = false;
    bool skip_existing = false;
    bool quiet = false;
};

/// Adds the options of the configuration keys that are wanted and those of a single run, such as --overwrite. `options`
/// must outlive the command.
void addPreviewOptions(CLI::App& command, PreviewOptions& options, const std::function<bool(const ConfigKey&)>& wanted);

/// One preview, written to one or more files.
struct PreviewTask {
    int frame = 0;
    std::string input;
    std::vector<std::string> outputs;
    bool keep = false;  ///< all outputs exist and stay as they are
};

/// The previews to render, planned before anything is written.
struct PreviewJob {
    Config config;
    std::vector<PreviewTask> tasks;  ///< ascending frames, at least one
    InputFrames input;               ///< of the sequence
    PreviewOptions options;
};

/// The worker process that renders. If a damaged file ends it, another one continues.
struct PreviewWorker {
    const WorkerEvents& events;
    const JobHistory& history;
    SignalWatch& signals;
};

/// The result of one task.
struct Rendering {
    std::vector<std::string> files;  ///< bytes of each output
    Image image;                     ///< for the contact sheet and the movie
};

/// in      kind: what is rendered; mesh: meshes, or particles where there are none
///         defaults: the configuration that options and pipeline file change
/// errors  no frames; an output exists and neither overwrite nor skip_existing is set; a movie is wanted and ffmpeg is
///         not installed
PreviewJob planPreviews(const PreviewOptions& options, FileKind kind, const Config& defaults = {});

/// Calls work() in a worker process, on as many threads as the job may use.
///
/// out     exit code of work(), or of the supervisor if workers were lost
int inPreviewWorker(const PreviewJob& job, const std::function<int(const PreviewWorker&)>& work);

/// Renders and writes one preview after the other, then the contact sheet and the movie. If a frame fails, the others
/// are still rendered.
///
/// out     exit code
int writePreviews(const PreviewJob& job, const PreviewWorker& worker,
                  const std::function<Rendering(const PreviewTask&)>& render);

}  // namespace betamesh
