#include "support/slurm.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <thread>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr int kSecondsToStart = 60;
constexpr int kSecondsOfAJob = 300;

/// A port that is currently unused.
int freePort() {
    const int probe = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    int port = 0;
    if (bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
        getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0)
        port = ntohs(address.sin_port);
    close(probe);
    return port;
}

bool within(int seconds, const std::function<bool()>& isTrue) {
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    while (!isTrue()) {
        if (std::chrono::steady_clock::now() > latest) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
}

std::string hostName() {
    std::array<char, 256> name{};
    gethostname(name.data(), name.size() - 1);
    const std::string whole(name.data());
    return whole.substr(0, whole.find('.'));
}

}  // namespace

Slurm::Slurm() {
    for (const char* program : {"/usr/sbin/munged", "/usr/sbin/slurmctld", "/usr/sbin/slurmd", "/usr/bin/sbatch"})
        if (!fs::exists(program)) why_not_ = std::string(program) + " is not installed (docker/test-packages.txt)";
    if (geteuid() != 0) why_not_ = "slurmd wants to be root";
    if (why_not_.empty()) start();
}

Slurm::~Slurm() {
    for (auto process = daemons_.rbegin(); process != daemons_.rend(); ++process) {
        kill(*process, SIGTERM);
        if (!within(10, [&] { return waitpid(*process, nullptr, WNOHANG) == *process; })) {
            kill(*process, SIGKILL);
            waitpid(*process, nullptr, 0);
        }
    }
}

void Slurm::daemon(const std::vector<std::string>& words) {
    const pid_t process = fork();
    if (process != 0) {
        daemons_.push_back(process);
        return;
    }
    std::vector<std::string> all = words;
    std::vector<char*> arguments;
    for (std::string& word : all) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int log = open((folder_ / "daemons.log").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    setsid();
    execv(arguments[0], arguments.data());
    _exit(127);
}

void Slurm::start() {
    const std::string host = hostName();
    fs::permissions(folder_.path(), fs::perms(0755));
    const std::string state = folder_ / "state", socket = folder_ / "munge.socket", key = folder_ / "munge.key";
    fs::create_directories(state);
    write(key, std::string(128, 'k'));
    fs::permissions(key, fs::perms(0400));
    write(
        folder_ / "slurm.conf",
        "ClusterName=test\nSlurmctldHost=" + host +
            "(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n"
            "AuthType=auth/munge\nCredType=cred/munge\n"
            "AuthInfo=socket=" +
            socket +
            ",cred_expire=5\n"  // also the delay before a requeued task starts
            "SlurmctldPort=" +
            std::to_string(freePort()) + "\nSlurmdPort=" + std::to_string(freePort()) + "\nStateSaveLocation=" + state +
            "\nSlurmdSpoolDir=" + (folder_ / "spool") + "\nSlurmctldPidFile=" + (folder_ / "slurmctld.pid") +
            "\nSlurmdPidFile=" + (folder_ / "slurmd.pid") + "\nSlurmctldLogFile=" + (folder_ / "slurmctld.log") +
            "\nSlurmdLogFile=" + (folder_ / "slurmd.log") +
            "\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
            "SelectTypeParameters=CR_Core\nReturnToService=2\nSwitchType=switch/none\nMpiDefault=none\n"
            "JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n"
            "SlurmdParameters=config_overrides\nSchedulerParameters=batch_sched_delay=0,sched_interval=2\nKillWait=10\n"
            "MaxArraySize=101\n"
            "NodeName=" +
            host +
            " NodeAddr=127.0.0.1 CPUs=4 RealMemory=100000 State=UNKNOWN\n"
            "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n");
    daemon({"/usr/sbin/munged", "--foreground", "--force", "--key-file=" + key, "--socket=" + socket,
            "--pid-file=" + (folder_ / "munged.pid"), "--log-file=" + (folder_ / "munged.log"),
            "--seed-file=" + (folder_ / "munged.seed")});
    if (!within(kSecondsToStart, [&] { return fs::exists(socket); })) {
        why_not_ = "munged does not start";
        return;
    }
    const std::string configuration = folder_ / "slurm.conf";
    daemon({"/usr/sbin/slurmctld", "-D", "-f", configuration});
    daemon({"/usr/sbin/slurmd", "-D", "-f", configuration, "-N", host});
    if (!within(kSecondsToStart, [&] { return command("sinfo -h -o %T").find("idle") == 0; }))
        why_not_ = "Slurm does not come up: " + contentsOf(folder_ / "daemons.log");
}

std::string Slurm::command(const std::string& words) const {
    std::string out;
    std::FILE* pipe = popen((environment().front() + ' ' + words + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return out;
    std::array<char, 4096> piece{};
    for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) out.append(piece.data(), n);
    pclose(pipe);
    return out;
}

bool Slurm::ended(const std::string& job) const {
    return within(kSecondsOfAJob, [&] { return command("squeue -h -j " + job).find(job) == std::string::npos; });
}

}  // namespace betamesh
