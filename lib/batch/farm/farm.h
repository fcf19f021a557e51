// Describes a job to farm engines: Slurm, Open Job Description, AWS Deadline Cloud, OpenCue, Deadline and Tractor.

#pragma once

#include "batch/farm/farm_job.h"
#include "batch/job/frame_task.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

enum class Farm { slurm, openjd, deadline_cloud, opencue, deadline, tractor };

/// The engine of a name: slurm, openjd, deadline-cloud, opencue, deadline or tractor.
/// errors  any other name
Farm farmNamed(std::string_view name);

/// The names of all engines with a separator between them.
std::string farmNames(std::string_view separator);

/// Divides the frames into contiguous chunks that take about equally long. Durations are estimated from the sizes of
/// the input files. A frame whose input does not exist yet may take as long as a whole chunk, and gets one of its own
/// where there may be so many.
///
/// in      tasks: ascending frames, at least one
///         seconds: intended duration of a chunk
///         max_chunks: >= 1
std::vector<std::vector<int>> chunksOfEqualCost(const std::vector<FrameTask>& tasks, int threads, double seconds,
                                                std::size_t max_chunks);

/// The number of tasks whose inputs do not exist yet. How long they take and how much memory they need is not known.
std::size_t withoutInput(const std::vector<FrameTask>& tasks);

/// The estimated duration of the longest of these chunks of the tasks.
///
/// in      seconds: estimated duration of a frame whose input does not exist yet
double longestSeconds(const std::vector<FrameTask>& tasks, const std::vector<std::vector<int>>& chunks, int threads,
                      double seconds);

/// Divides the frames into contiguous chunks of `frames` frames each; the last chunk may have fewer.
std::vector<std::vector<int>> chunksOfSize(const std::vector<FrameTask>& tasks, std::size_t frames);

// Each of the following functions refuses words, such as folders, that its engine cannot express; what it accepts
// reaches the program unchanged.

/// A batch script for an array with one task per chunk. Tasks return to the queue when a node fails. The time limit is
/// many times the estimated duration, because a task that reaches it is ended.
/// errors  a control character in an option of sbatch
std::string slurmArray(const FarmJob& job);

/// A batch script for the report after the array.
std::string slurmReport(const FarmJob& job);

/// The scripts of a job, NAME.array.sh and NAME.report.sh, and NAME.submit.sh, which submits them in this order.
/// Without report the array alone.
std::vector<FarmFile> slurmFiles(const FarmJob& job);

/// An Open Job Description template, version 2023-09 with TASK_CHUNKING.
/// errors  a word that contains {{, which the template would take for a reference, or a control character, or is not
///         UTF-8; frames whose ranges are longer than a parameter may be
std::string openJobTemplate(const FarmJob& job);

/// A job bundle of AWS Deadline Cloud: a template as above in which the folder is a parameter, since workers may have
/// it elsewhere, the values of its parameters, and the files to transfer where machines share none.
///
/// errors  as above
/// source  AWS Deadline Cloud developer guide, Open Job Description templates for Deadline Cloud
std::vector<FarmFile> deadlineCloudBundle(const FarmJob& job);

/// The command of an OpenCue layer, with OpenCue's token for the frames.
/// errors  a word that contains a token of OpenCue
std::string openCueCommand(const FarmJob& job);

/// A deadlinecommand command line that submits the job to Deadline.
/// errors  a word that contains < before a capital letter, or a control character
std::string deadlineCommand(const FarmJob& job);

/// A job script for Tractor's tractor-spool.
/// errors  a word that contains a brace or a backslash
std::string tractorJob(const FarmJob& job);

/// The jobs that were submitted to Slurm.
struct SlurmJobs {
    std::string array_job, report_job;  ///< job ids; report_job is empty if there is no report
    bool ok = true;                     ///< false if sbatch waited for a job that failed
};

/// Submits the array with sbatch, then the report that starts after it.
///
/// errors  sbatch is not installed or refuses the job
SlurmJobs submitToSlurm(const FarmJob& job);

/// The largest number of tasks that Slurm accepts in one array.
std::size_t maxSlurmTasks();

}  // namespace betamesh
