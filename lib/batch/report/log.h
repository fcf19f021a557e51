// The log: lines with a time on stderr, and in a file if one is set. Every message is one line; control characters in
// it are escaped, see printable(). Colours only on a terminal, and not if NO_COLOR is set in the environment.

#pragma once

#include <cstddef>
#include <string>

namespace betamesh {

enum class LogLevel {
    quiet,   ///< errors only
    normal,  ///< also warnings and progress
    verbose  ///< also details of every frame
};

void setLogLevel(LogLevel level);

inline constexpr std::size_t kMaxLogFileBytes = 10'000'000;
inline constexpr std::size_t kOldLogFiles = 5;

/// From now on, also appends all messages, including details, to a file. At kMaxLogFileBytes the file is renamed to
/// NAME.1.EXT, the previous NAME.1.EXT to NAME.2.EXT and so on; kOldLogFiles of them are kept.
///
/// errors  the file cannot be written
void setLogFile(const std::string& file);

/// The name that a log file has after it has been renamed `times` times, times >= 1.
std::string oldLogFile(const std::string& file, std::size_t times);

void logDetail(const std::string& text);
void logInfo(const std::string& text);
void logWarning(const std::string& text);
void logError(const std::string& text);

/// Shows a line below all others on a terminal, such as a progress bar; empty: none.
void setLogFooter(const std::string& text);

}  // namespace betamesh
