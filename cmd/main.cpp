#include "batch/job/job.h"
#include "batch/report/log.h"
#include "batch/version.h"
#include "command.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <string_view>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace {

constexpr const char* kExitCodes =
    "Exit codes:\n"
    "  0 all done; 1 some frame failed, the others are written; 2 wrong usage or configuration, nothing written;\n"
    "  33 out of memory; 143 ended by SIGTERM, 130 by SIGINT: finished frames stay, nothing is half-written.";

constexpr std::size_t kHelpColumns = 84;  // right of the names

/// Breaks the words of long descriptions into lines.
class LineBreakingFormatter : public CLI::Formatter {
public:
    std::string make_option_desc(const CLI::Option* option) const override {
        std::istringstream words(CLI::Formatter::make_option_desc(option));
        std::string text;
        std::size_t column = 0;
        for (std::string word; words >> word; column += word.size() + 1) {
            if (column > 0 && column + word.size() > kHelpColumns) {
                text += '\n';
                column = 0;
            } else if (column > 0) {
                text += ' ';
            }
            text += word;
        }
        return text;
    }
};

struct NamedCommand {
    std::string_view name;
    void (*add)(CLI::App& program, int& exit_code);
};

constexpr std::array kCommands = std::to_array<NamedCommand>({
    {"mesh", betamesh::addMeshCommand},
    {"run", betamesh::addRunCommand},
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

/// The one that is asked for: what the options of all others are takes a tenth of the start. All of them for help, and
/// for the manual.
void addCommands(CLI::App& program, int& exit_code, std::string_view asked) {
    const auto isAsked = [&](const NamedCommand& command) { return command.name == asked; };
    const bool all = asked == "manual" || std::none_of(kCommands.begin(), kCommands.end(), isAsked);
    for (const NamedCommand& command : kCommands)
        if (all || isAsked(command)) command.add(program, exit_code);
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
    CLI::App program("Turns frames of simulated particles into closed triangle meshes: the beta mesh method.",
                     "betamesh");
    program.formatter(std::make_shared<LineBreakingFormatter>());  // commands take it over
    program.set_version_flag("--version", std::string("betamesh ") + version());
    program.require_subcommand(1);
    program.footer(kExitCodes);
    int exit_code = kAllWritten;
    addCommands(program, exit_code, argc > 1 ? argv[1] : "");
    try {
        program.parse(argc, argv);
        std::cout.flush();
        if (!std::cout && exit_code == kAllWritten) {
            logError("stdout cannot be written");
            return kSomeFailed;
        }
        return exit_code;
    } catch (const CLI::ParseError& error) {
        return program.exit(error) == 0 ? kAllWritten : kWrongUsage;  // --help and --version are no errors
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
