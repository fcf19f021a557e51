// Options of pictures, shared by `render` and `compare`, and drawing them one after the other.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/worker.h"
#include "render/picture.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace betamesh {

struct PictureOptions {
    std::string input;
    std::vector<std::string> outputs;
    std::map<std::string, std::string> values;  ///< key -> value given by its option
    std::vector<std::string> assignments;       ///< KEY=VALUE of each --set, in order
    std::string pipeline;                       ///< pipeline file; empty: none
    std::string contact_sheet;                  ///< file to write; empty: none
    int sheet_pictures = 12;                    ///< at most, on the contact sheet
    int sheet_width = 600;                      ///< pixels per picture on the contact sheet
    int sheet_columns = 0;                      ///< 0: about as many as rows
    std::string movie;                          ///< file to write; empty: none
    bool overwrite = false;
    bool skip_existing = false;
    bool quiet = false;
};

/// Adds the options of the configuration keys that are wanted and those of a single run, such as --overwrite. `options`
/// must outlive the command.
void addPictureOptions(CLI::App& command, PictureOptions& options, const std::function<bool(const ConfigKey&)>& wanted);

/// One picture, written to one or more files.
struct PictureTask {
    int frame = 0;
    std::string input;
    std::vector<std::string> outputs;
    bool keep = false;  ///< all outputs exist and stay as they are
};

/// The pictures to draw, planned before anything is written.
struct PictureJob {
    Config config;
    std::vector<PictureTask> tasks;      ///< ascending frames, at least one
    std::map<int, std::string> on_disk;  ///< frame -> file, all inputs of the sequence
    PictureOptions options;
};

/// The worker process that draws. If a damaged file ends it, another one continues.
struct PictureWorker {
    const WorkerEvents& events;
    const JobHistory& history;
    SignalWatch& signals;
};

/// The result of one task.
struct Drawn {
    std::vector<std::string> files;  ///< bytes of each output
    Image image;                     ///< for the contact sheet and the movie
};

/// in      defaults: the configuration that options and pipeline file change
/// errors  no frames; an output exists and neither overwrite nor skip_existing is set; a movie is wanted and ffmpeg is
///         not installed
PictureJob planPictures(const PictureOptions& options, const Config& defaults = {});

/// Calls work() in a worker process, on as many threads as the job may use.
///
/// out     exit code of work(), or of the supervisor if workers were lost
int inPictureWorker(const PictureJob& job, const std::function<int(const PictureWorker&)>& work);

/// Draws and writes one picture after the other, then the contact sheet and the movie. If a frame fails, the others are
/// still drawn.
///
/// out     exit code
int writePictures(const PictureJob& job, const PictureWorker& worker,
                  const std::function<Drawn(const PictureTask&)>& draw);

}  // namespace betamesh
