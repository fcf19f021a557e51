// The log: lines with a time on stderr, and in a file if one is set.

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

void logDetail(const std::string& text);
void logInfo(const std::string& text);
void logWarning(const std::string& text);
void logError(const std::string& text);

/// Shows a line below all others on a terminal, such as a progress bar; empty: none.
void setLogFooter(const std::string& text);

}  // namespace betamesh
