// One frame of a job: what is to be done with it, how it ended, and the paths of its files.

#pragma once

#include "betamesh/io.h"

#include <cstdint>
#include <string>

namespace betamesh {

/// What is planned for a frame.
enum class FrameAction {
    mesh,            ///< read, skin, write
    draw,            ///< the mesh is up to date: make its preview alone
    write_empty,     ///< the input is missing; run.on_missing is empty
    skip_missing,    ///< the input is missing; run.on_missing is skip
    fail_missing,    ///< the input is missing; run.on_missing is error
    fail_lost,       ///< the frame ended an earlier worker process
    skip_existing,   ///< the output exists and is up to date
    refuse_existing  ///< an output exists and must not be replaced; only in plans of a dry run
};

/// Whether files of the frame are written.
bool isWritten(FrameAction action);

/// As --dry-run prints it.
const char* actionName(FrameAction action);

struct FrameTask {
    int frame = 0;
    std::string input;
    std::string output;
    FrameAction action = FrameAction::mesh;
    std::string preview{};      ///< path; empty: no preview
    std::string why{};          ///< why an existing output is made again, or why the frame was lost
    std::uint64_t memory = 0;   ///< estimated peak memory of the frame, with that of a level set, bytes
    bool near_surface = false;  ///< the frame does not fit: load only the particles near its surface
};

/// The options for writing the files of a frame.
WriteOptions writeOptions(const WriteOptions& of_sequence, int frame);

/// How a frame ended.
enum class FrameStatus {
    ok,
    empty,    ///< an empty mesh was written because there were no particles
    skipped,  ///< nothing was written, as requested
    failed    ///< the mesh or its preview could not be made, see error
};

/// "ok", "empty", "skipped" or "failed".
const char* nameOf(FrameStatus status);

/// The path of the manifest beside an output: "o.0001.ply" -> "o.0001.ply.json".
std::string manifestPath(const std::string& output);

/// The path of the spheres beside an output: "o.0001.ply" -> "o.0001.spheres.ply". .ply if the format of the output
/// cannot store a radius.
std::string spheresPath(const std::string& output);

}  // namespace betamesh
