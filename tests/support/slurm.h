// A Slurm of our own on this host: a controller, a node with four processors, munge. Nothing outside its folder is
// used.

#pragma once

#include "support/temporary_folder.h"

#include <string>
#include <vector>

#include <sys/types.h>

namespace betamesh {

class Slurm {
public:
    /// Starts it; where that cannot be done, whyNot() tells.
    Slurm();
    ~Slurm();
    Slurm(const Slurm&) = delete;
    Slurm& operator=(const Slurm&) = delete;

    /// Empty when it runs.
    const std::string& whyNot() const { return why_not_; }

    /// NAME=value, for commands of Slurm and programs that call them.
    std::vector<std::string> environment() const { return {"SLURM_CONF=" + folder_ / "slurm.conf"}; }

    /// stdout of one of Slurm's commands.
    std::string command(const std::string& words) const;

    /// Waits until no task of a job is pending or running; false if that takes longer than some minutes.
    bool ended(const std::string& job) const;

private:
    void start();
    void daemon(const std::vector<std::string>& words);

    TemporaryFolder folder_;
    std::vector<pid_t> daemons_;
    std::string why_not_;
};

}  // namespace betamesh
