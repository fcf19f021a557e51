// A job as farm engines get it.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace betamesh {

/// A pipeline divided into tasks for several machines, which share a file system.
struct FarmJob {
    std::string name;
    std::string folder;            ///< absolute path in which tasks start, so that relative paths of the pipeline work
    std::vector<std::string> run;  ///< command line that meshes frames, without --frames and what follows it
    std::vector<std::string> report;          ///< that of the task after all others, alike; empty: no such task
    std::vector<std::vector<int>> chunks;     ///< the frames of each task, ascending
    double task_seconds = 300;                ///< intended duration of a task; 0: the chunks are not to be changed
    double longest_task_seconds = 0;          ///< estimated duration of the longest task
    int threads = 0;                          ///< threads per task; 0: what the farm grants
    std::uint64_t memory = 0;                 ///< estimated memory per task in bytes; 0: unknown
    std::vector<std::string> sbatch_options;  ///< additional options of sbatch, for the array and the report
    std::vector<std::string> input_files;     ///< absolute paths of all files that tasks read
    std::vector<std::string> output_folders;  ///< absolute paths of all folders that tasks write to
};

/// A file to be written for an engine.
struct FarmFile {
    std::string name;  ///< without folders
    std::string text;
};

}  // namespace betamesh
