// What `mesh` and `run` share: the options of a job, and running it.

#pragma once

#include "batch/config/config.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace betamesh {

struct JobOptions {
    std::map<std::string, std::string> values;  ///< by key; what the command line says
    std::vector<std::string> assignments;       ///< of --set, in order
    std::string chunk = "1/1";
    std::string progress = "auto";
    std::string log_file;
    bool overwrite = false;
    bool skip_existing = false;
    bool dry_run = false;
    bool json = false;
    bool quiet = false;
    bool verbose = false;
};

/// Adds an option for every wanted key that has one; it puts what it is told into values, which must outlive it.
void addKeyOptions(CLI::App& command, std::map<std::string, std::string>& values,
                   const std::function<bool(const ConfigKey&)>& wanted);

/// What the command line says of keys, in the order in which it counts: --set, then the options.
std::vector<KeyValue> keyValuesOf(const std::vector<std::string>& assignments,
                                  const std::map<std::string, std::string>& values = {});

/// Adds an option for every key that shapes a job and has one, and those that are about this one run. The options must
/// outlive the command.
void addJobOptions(CLI::App& command, JobOptions& options);

/// Plans and runs the job.
///
/// in      pipeline, a file; empty: none
///         given, by the command line in other ways than options
int runWithOptions(const std::string& pipeline, std::vector<KeyValue> given, const JobOptions& options);

}  // namespace betamesh
