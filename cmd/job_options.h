// Options of a job, shared by `mesh` and `run`, and running the job they describe.

#pragma once

#include "batch/config/config.h"
#include "batch/job/input_frames.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace betamesh {

struct JobOptions {
    std::map<std::string, std::string> values;  ///< key -> value given by its option
    std::vector<std::string> assignments;       ///< KEY=VALUE of each --set, in order
    std::string chunk = "1/1";
    std::string progress = "auto";
    std::string log_file;
    bool overwrite = false;
    bool skip_existing = false;
    bool dry_run = false;
    bool json = false;
    bool quiet = false;
    bool verbose = false;
    bool stdout_is_taken = false;  ///< by the mesh: progress for farm engines goes to stderr
};

/// Adds the options of all configuration keys that are wanted. They store their values in `values`, which must outlive
/// the command.
void addKeyOptions(CLI::App& command, std::map<std::string, std::string>& values,
                   const std::function<bool(const ConfigKey&)>& wanted);

/// Adds the options that say how particles are read: all keys of the section input.
void addParticleOptions(CLI::App& command, std::map<std::string, std::string>& values);

/// Adds --frames of commands that read files one by one, for framesIn().
void addFramesOption(CLI::App& command, std::string& frames);

/// Adds --output-up-axis for commands that compare meshes with particles.
void addMeshAxisOption(CLI::App& command, std::map<std::string, std::string>& values);

/// The input of --particles: one file for all meshes, or a file or time sample for each frame.
///
/// errors  an extension that particles do not have; a pattern without any file on disk; those of inputFrames()
InputFrames particleFrames(const std::string& path, const std::map<std::string, std::string>& values);

/// The particles of the frame of a mesh. The frame of a mesh file without a number is that of its manifest.
///
/// errors  no time sample at that frame
FileFrame particlesBeside(const FileFrame& mesh, const InputFrames& particles);

/// The particles of a frame, in the coordinates of a mesh, with these values of the options. An origin and an up axis
/// of the mesh that are not given are those of the mesh's manifest.
///
/// errors  those of readParticles()
Particles particlesOf(const std::string& mesh_file, const FileFrame& particles,
                      const std::map<std::string, std::string>& values);

/// The keys given on the command line in ascending precedence: --set, then options.
std::vector<KeyValue> keyValuesOf(const std::vector<std::string>& assignments,
                                  const std::map<std::string, std::string>& values = {});

/// Adds all options of a job: those of configuration keys and those of a single run, such as --overwrite. `options`
/// must outlive the command.
void addJobOptions(CLI::App& command, JobOptions& options);

/// Plans and runs the job.
///
/// in      pipeline: a pipeline file; empty: none
///         given: keys from arguments of the command, such as IN and OUT of `mesh`
/// out     exit code
int runWithOptions(const std::string& pipeline, std::vector<KeyValue> given, const JobOptions& options);

}  // namespace betamesh
