// Standard input and output in place of files: `-`.

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace betamesh {

inline constexpr const char* kStandardStream = "-";

/// Files that stand for stdin and stdout while a command runs, in a temporary folder that the process which made them
/// removes. Formats need files: their readers know the size and some read twice.
class StandardStreams {
public:
    StandardStreams() = default;
    ~StandardStreams();
    StandardStreams(const StandardStreams&) = delete;
    StandardStreams& operator=(const StandardStreams&) = delete;

    /// Copies stdin to a file whose extension is that of its contents. Returns its path.
    ///
    /// errors  stdin is a terminal, of no known format, or was copied before; no space for the copy
    std::string fileOfStdin();

    /// The path of the file to write instead of stdout. extension: with its dot.
    ///
    /// errors  stdout is a terminal
    std::string fileForStdout(const std::string& extension);

    /// Writes the file to stdout, in the process that made these files. Does nothing in a process forked from it.
    /// Returns whether it was written; if not, std::cout has failed, which the program reports at its end.
    bool writeStdout() const;

private:
    std::filesystem::path folder();

    std::filesystem::path folder_, stdin_file_, stdout_file_;
    pid_t owner_ = -1;
};

}  // namespace betamesh
