#include "batch/job/job.h"
#include "batch/report/log.h"
#include "betamesh/version.h"
#include "command.h"
#include "help.h"
#include "usage_error.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace {

constexpr const char* kExitCodes =
    "Exit codes:\n"
    "  0    everything was done\n"
    "  1    some frames failed, the others were written; or check or coherence found a fault\n"
    "  2    wrong usage or configuration; nothing was written\n"
    "  33   out of memory\n"
    "  130  interrupted by SIGINT, 143 by SIGTERM; finished frames stay, and no file is half-written\n"
    "`betamesh COMMAND --help` explains a command.";

struct NamedCommand {
    std::string_view name;
    void (*add)(CLI::App& program, int& exit_code);
};

constexpr std::array kCommands = std::to_array<NamedCommand>({
    {"mesh", betamesh::addMeshCommand},
    {"run", betamesh::addRunCommand},
    {"convert", betamesh::addConvertCommand},
    {"sample", betamesh::addSampleCommand},
    {"info", betamesh::addInfoCommand},
    {"check", betamesh::addCheckCommand},
    {"coherence", betamesh::addCoherenceCommand},
    {"render", betamesh::addRenderCommand},
    {"compare", betamesh::addCompareCommand},
    {"config", betamesh::addConfigCommand},
    {"submit", betamesh::addSubmitCommand},
    {"report", betamesh::addReportCommand},
    {"manual", betamesh::addManualCommand},
});

bool isCommand(std::string_view name) {
    return std::any_of(kCommands.begin(), kCommands.end(), [&](const NamedCommand& c) { return c.name == name; });
}

/// Adds only the given command, because adding all of them takes a tenth of the startup time; adds all of them for help
/// and for the manual.
void addCommands(CLI::App& program, int& exit_code, std::string_view name) {
    const bool all = name == "manual" || !isCommand(name);
    for (const NamedCommand& command : kCommands)
        if (all || command.name == name) command.add(program, exit_code);
}

/// The words of the command line. `help COMMAND` means `COMMAND --help`, as in other programs; of what is no command,
/// it means the error.
std::vector<std::string> wordsOf(int argc, char** argv) {
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (words.empty() || words[0] != "help") return words;
    words.erase(words.begin());
    if (words.empty() || isCommand(words[0])) words.emplace_back("--help");
    return words;
}

/// Ends the program without destructors of static objects: the system frees memory faster, and in a worker process the
/// destructor of OpenVDB's log would wait for threads that a fork does not copy.
int leave(int exit_code) {
#if defined(__SANITIZE_THREAD__)
    return exit_code;  // ThreadSanitizer reports at a normal exit
#endif
#if defined(__SANITIZE_ADDRESS__)
    __lsan_do_leak_check();
#endif
    std::cout.flush();
    std::fflush(nullptr);
    std::quick_exit(exit_code);
}

int run(int argc, char** argv) {
    using namespace betamesh;
    CLI::App program("Turns particles of liquid simulations into closed triangle meshes with the beta mesh method.",
                     "betamesh");
    program.formatter(helpFormatter());  // commands inherit this, the group and the help flags
    program.group("Commands");
    program.set_help_flag("-h,--help", "Show this help.");
    program.set_help_all_flag("--help-all", "Show this help with all options.");
    program.set_version_flag("-V,--version", std::string("betamesh ") + version(), "Show the version of the program.");
    program.require_subcommand(1);
    program.footer(kExitCodes);
    std::signal(SIGXFSZ, SIG_IGN);  // a file beyond `ulimit -f` is an error of that file and does not end the process
    int exit_code = kAllWritten;
    const std::vector<std::string> words = wordsOf(argc, argv);
    addCommands(program, exit_code, words.empty() ? "" : words[0]);
    try {
        program.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 wants the last one first
        std::cout.flush();
        if (!std::cout && exit_code == kAllWritten) {
            logError("stdout cannot be written. Is the disk full or the pipe closed?");
            return kSomeFailed;
        }
        return exit_code;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return program.exit(error);  // --help and --version are not errors
        logError(usageError(program, words, error));
        return kWrongUsage;
    } catch (const std::bad_alloc&) {
        logError("out of memory");
        return kOutOfMemory;
    } catch (const std::exception& error) {
        logError(error.what());
        return kWrongUsage;
    }
}

}  // namespace

int main(int argc, char** argv) { return leave(run(argc, argv)); }
