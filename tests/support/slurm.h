// A private Slurm cluster on this host: a controller, a node with four processors, munge. It uses nothing outside its
// folder.

#pragma once

#include "support/temporary_folder.h"

#include <string>
#include <vector>

#include <sys/types.h>

namespace betamesh {

class Slurm {
public:
    /// Starts the cluster. If that fails, whyNot() has the reason.
    Slurm();
    ~Slurm();
    Slurm(const Slurm&) = delete;
    Slurm& operator=(const Slurm&) = delete;

    /// Empty if the cluster is running.
    const std::string& whyNot() const { return why_not_; }

    /// Environment (NAME=value) for Slurm commands and for programs that call them.
    std::vector<std::string> environment() const { return {"SLURM_CONF=" + folder_ / "slurm.conf"}; }

    /// Runs a Slurm command and returns its stdout.
    std::string command(const std::string& words) const;

    /// Waits until no task of a job is pending or running. Returns false after a few minutes.
    bool ended(const std::string& job) const;

private:
    void start();
    void daemon(const std::vector<std::string>& words);

    TemporaryFolder folder_;
    std::vector<pid_t> daemons_;
    std::string why_not_;
};

}  // namespace betamesh
