// What `render` and `compare` share: the options of pictures, and making them one after the other.

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
    std::map<std::string, std::string> values;  ///< by key; what the command line says
    std::vector<std::string> assignments;       ///< of --set, in order
    std::string pipeline;                       ///< a file; empty: none
    std::string contact_sheet;                  ///< a file; empty: none
    int sheet_pictures = 12;
    int sheet_width = 600;  ///< pixels, of a picture
    int sheet_columns = 0;  ///< 0: about as many as rows
    std::string movie;      ///< a file; empty: none
    bool overwrite = false;
    bool skip_existing = false;
    bool quiet = false;
};

/// Adds options for the wanted keys and those that are about this one run. The options must outlive the command.
void addPictureOptions(CLI::App& command, PictureOptions& options, const std::function<bool(const ConfigKey&)>& wanted);

/// One picture, under one name or several.
struct PictureTask {
    int frame = 0;
    std::string input;
    std::vector<std::string> outputs;
    bool exists = false;  ///< and is to be left as it is
};

/// What to draw, decided before anything is written.
struct PictureJob {
    Config config;
    std::vector<PictureTask> tasks;      ///< ascending frames, at least one
    std::map<int, std::string> on_disk;  ///< every input of the sequence
    PictureOptions options;
};

/// Where pictures are made: a process that a damaged file may end, after which another goes on.
struct PictureWorker {
    const WorkerEvents& notes;
    const JobHistory& history;
    SignalWatch& signals;
};

/// What becomes of one task.
struct Drawn {
    std::vector<std::string> files;  ///< the bytes of each output
    Image image;                     ///< for the contact sheet and the movie
};

/// usual: what the options change.
///
/// errors  no frame; an output that exists while neither overwrite nor skip_existing is set; a movie without ffmpeg
PictureJob planPictures(const PictureOptions& options, const Config& usual = {});

/// Calls work() in a worker, on as many threads as the job may use.
///
/// out     an exit code, that of work() where no worker was lost
int inPictureWorker(const PictureJob& job, const std::function<int(const PictureWorker&)>& work);

/// Draws and writes one picture after the other, then the contact sheet and the movie. A frame that fails does not keep
/// the others from being drawn.
///
/// out     an exit code
int writePictures(const PictureJob& job, const PictureWorker& worker,
                  const std::function<Drawn(const PictureTask&)>& draw);

}  // namespace betamesh
