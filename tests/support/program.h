// Runs the program as a user does: arguments in; exit code, stdout and stderr out.

#pragma once

#include "support/temporary_folder.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include <sys/types.h>

namespace betamesh {

struct Outcome {
    int exit_code = 0;  ///< the negative signal number if a signal killed it
    std::string out;
    std::string err;
};

/// The program running in a folder.
class RunningProgram {
public:
    RunningProgram(const std::vector<std::string>& words, const std::filesystem::path& folder,
                   const std::vector<std::string>& environment = {});
    ~RunningProgram();
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    /// The worker process; -1 if there is none.
    pid_t worker() const;
    void send(int signal);
    Outcome wait();

private:
    TemporaryFolder talk_;
    pid_t process_ = -1;
    pid_t orphan_ = -1;  ///< the worker of a process that was killed
};

/// environment: NAME=value, added to that of the test.
Outcome runProgram(const std::vector<std::string>& words, const std::filesystem::path& folder,
                   const std::vector<std::string>& environment = {});

/// Every line of --json output, parsed; lines that are not JSON become discarded values.
std::vector<nlohmann::json> jsonLines(const std::string& text);

}  // namespace betamesh
