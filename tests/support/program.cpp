#include "support/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace betamesh {
namespace {

void sendTo(const std::string& file, int descriptor) {
    const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (opened < 0 || dup2(opened, descriptor) < 0) _exit(127);
    close(opened);
}

bool isAlive(pid_t process) {
    if (process <= 0) return false;
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    std::getline(file, line);
    const std::size_t name_end = line.rfind(')');
    return name_end != std::string::npos && line.substr(name_end).find_first_of("ZX") != 2;
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& words, const std::filesystem::path& folder,
                               const std::vector<std::string>& environment) {
    std::vector<std::string> all{BETAMESH_PROGRAM};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    for (std::string& word : all) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::vector<std::string> settings = environment;
    const std::string out = talk_ / "out", err = talk_ / "err";
    for (const std::string& file : {out, err}) write(file, "");  // exist even if the process is killed immediately
    process_ = fork();
    if (process_ != 0) return;
    if (chdir(folder.c_str()) != 0) _exit(127);
    for (std::string& setting : settings) putenv(setting.data());
    sendTo(out, STDOUT_FILENO);
    sendTo(err, STDERR_FILENO);
    execv(arguments[0], arguments.data());
    _exit(127);
}

RunningProgram::~RunningProgram() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
}

pid_t RunningProgram::worker() const {
    const std::string process = std::to_string(process_);
    std::ifstream children("/proc/" + process + "/task/" + process + "/children");
    pid_t child = -1;
    return children >> child ? child : -1;
}

void RunningProgram::send(int signal) {
    if (process_ <= 0) return;
    orphan_ = signal == SIGKILL ? worker() : -1;
    kill(process_, signal);
}

Outcome RunningProgram::wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    // A worker is killed shortly after the process that started it.
    for (int i = 0; i < 500 && isAlive(orphan_); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), contentsOf(talk_ / "out"),
            contentsOf(talk_ / "err")};
}

Outcome runProgram(const std::vector<std::string>& words, const std::filesystem::path& folder,
                   const std::vector<std::string>& environment) {
    return RunningProgram(words, folder, environment).wait();
}

std::vector<nlohmann::json> jsonLines(const std::string& text) {
    std::vector<nlohmann::json> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line, nullptr, false));
    return lines;
}

}  // namespace betamesh
