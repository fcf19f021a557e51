// What a job says to the person who watches it: lines on stderr, with the time.

#pragma once

#include <string>

namespace betamesh {

enum class LogLevel {
    quiet,   ///< errors
    normal,  ///< warnings and what is being done
    verbose  ///< details of every frame
};

void setLogLevel(LogLevel level);

/// From here on everything, details too, goes into this file as well, after what is there. At 10 MB it becomes
/// NAME.1.EXT, and that NAME.2.EXT and so on; five are kept.
///
/// errors  a file that cannot be written
void setLogFile(const std::string& file);

void logDetail(const std::string& text);
void logInfo(const std::string& text);
void logWarning(const std::string& text);
void logError(const std::string& text);

/// A line that stays below all others on a terminal; empty: none.
void setLogFooter(const std::string& text);

}  // namespace betamesh
