// Exit codes of the program.

#pragma once

namespace betamesh {

/// Exit codes of all commands.
enum ExitCode {
    kAllWritten = 0,
    kSomeFailed = 1,
    kWrongUsage = 2,
    kOutOfMemory = 33,
    kSignalBase = 128  ///< plus the number of the signal: 130 SIGINT, 143 SIGTERM
};

}  // namespace betamesh
