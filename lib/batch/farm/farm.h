// A job in the words of the farm engines that are to run it.

#pragma once

#include "batch/job/plan.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

enum class Farm { slurm, openjd, opencue, deadline, tractor };

/// slurm, openjd, opencue, deadline, tractor; throws Error for another word.
Farm farmOf(std::string_view word);

/// A pipeline as tasks for several machines. All share a file system.
struct FarmJob {
    std::string name;
    std::string folder;            ///< where relative paths of the pipeline start, absolute
    std::vector<std::string> run;  ///< words of the command that meshes frames, but for --frames and what is after it
    std::vector<std::string> report;       ///< words of the command at the end of it all; none: no such task
    std::vector<std::vector<int>> pieces;  ///< the frames of each task, ascending
    double task_seconds = 300;             ///< about how long a task is to take
    int threads = 0;                       ///< of a task; 0: what the farm gives
    std::uint64_t memory = 0;              ///< a task is likely to take, bytes
};

/// Frames in contiguous pieces that take about equally long.
///
/// in      tasks in ascending frames, at least one
/// seconds that a piece should take, guessed from the sizes of input files
/// most    pieces; >= 1
std::vector<std::vector<int>> piecesOfEqualCost(const std::vector<FrameTask>& tasks, int threads, double seconds,
                                                std::size_t most);

/// Components of so many frames, the last one maybe of fewer.
std::vector<std::vector<int>> piecesOfFrames(const std::vector<FrameTask>& tasks, std::size_t frames);

/// A batch script whose array has a task for each piece. Tasks go back to the queue when a node fails.
std::string slurmArray(const FarmJob& job);

/// A batch script for the end of it all.
std::string slurmReport(const FarmJob& job);

/// An Open Job Description template, version 2023-09 with TASK_CHUNKING.
/// errors  words with {{, which would be taken for a reference
std::string openJobTemplate(const FarmJob& job);

/// The command of a layer of frames, with OpenCue's token.
std::string openCueCommand(const FarmJob& job);

/// A deadlinecommand that submits the job.
std::string deadlineCommand(const FarmJob& job);

/// A job script for tractor-spool.
std::string tractorJob(const FarmJob& job);

/// Words that a shell reads back as they are.
std::string shellWords(const std::vector<std::string>& words);

/// Submits with sbatch, first the array, then the report after it. further: words for sbatch, of the array.
///
/// out     what was submitted, for people; ok: whether all that sbatch waited for went well
/// errors  sbatch that is not there or refuses
struct Submitted {
    std::string array_job, report_job;  ///< ids; report_job is empty where there is none
    bool ok = true;
};
Submitted submitToSlurm(const FarmJob& job, const std::vector<std::string>& further);

/// How many tasks Slurm takes in one array.
std::size_t slurmMostTasks();

}  // namespace betamesh
