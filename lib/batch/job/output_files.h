// Checks the files that a job reads and writes before it begins.

#pragma once

#include "batch/job/output_plan.h"

#include <map>
#include <set>
#include <span>
#include <string>

namespace betamesh {

/// in      on_disk: the inputs of all frames
/// errors  a file that would be both read and written, or written twice; a file in the place of a layer that plays a
///         sequence
void requireDistinctFiles(std::span<const Plan> outputs, const std::map<int, std::string>& on_disk);

/// errors  an output folder, or the folder in which it has to be created, that cannot be written to
void requireWritableFolders(std::span<const Plan> outputs);

/// errors  one of these folders, or the folder in which it has to be created, that cannot be written to
void requireWritableFolders(const std::set<std::string>& folders);

/// Refuses a log file that the job reads or writes for something else.
///
/// in      pipeline: path of the pipeline file; empty: none
/// errors  the log file, or a name that it gets when it has grown, is the pipeline file, an input or an output
void requireDistinctLog(const std::string& log_file, const std::string& pipeline, const Config& config);

}  // namespace betamesh
