// The only file that uses spdlog.

#include "batch/report/log.h"

#include "batch/report/printable.h"
#include "betamesh/error.h"
#include "io/bytes.h"

#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <cstdlib>
#include <mutex>

namespace betamesh {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

struct Log {
    std::mutex mutex;
    std::string footer;
    std::shared_ptr<spdlog::sinks::stderr_color_sink_st> terminal =
        std::make_shared<spdlog::sinks::stderr_color_sink_st>();
    spdlog::logger logger{"betamesh", terminal};

    Log() {
        logger.set_level(spdlog::level::debug);
        terminal->set_level(spdlog::level::info);
        logger.set_pattern("%H:%M:%S %^%l%$: %v");
        // source  no-color.org; without it, spdlog uses colours if stderr is a terminal that has them
        const char* const no_color = std::getenv("NO_COLOR");
        if (no_color != nullptr && *no_color != '\0') terminal->set_color_mode(spdlog::color_mode::never);
    }

    void line(spdlog::level::level_enum level, const std::string& text) {
        const std::scoped_lock lock(mutex);
        const bool shown = terminal->should_log(level);
        if (shown && !footer.empty()) std::fputs(kEraseLine, stderr);
        logger.log(level, spdlog::string_view_t(printable(text)));
        if (shown) drawFooter();
    }

    void drawFooter() {
        if (!footer.empty()) std::fputs(footer.c_str(), stderr);
        std::fflush(stderr);
    }
};

Log& theLog() {
    static Log log;
    return log;
}

}  // namespace

void setLogLevel(LogLevel level) {
    theLog().terminal->set_level(level == LogLevel::quiet     ? spdlog::level::err
                                 : level == LogLevel::verbose ? spdlog::level::debug
                                                              : spdlog::level::info);
}

void setLogFile(const std::string& file) {
    Log& log = theLog();
    requireRegularFile(file);  // it is renamed when it grows
    try {
        auto sink = std::make_shared<spdlog::sinks::rotating_file_sink_st>(file, kMaxLogFileBytes, kOldLogFiles);
        sink->set_pattern("%Y-%m-%d %H:%M:%S.%e %l: %v");
        const std::scoped_lock lock(log.mutex);
        log.logger.sinks().push_back(std::move(sink));
        log.logger.flush_on(spdlog::level::debug);
    } catch (const spdlog::spdlog_ex& error) {
        throw Error(file + ": the log file cannot be written: " + error.what());
    }
}

std::string oldLogFile(const std::string& file, std::size_t times) {
    return spdlog::sinks::rotating_file_sink_st::calc_filename(file, times);
}

void logDetail(const std::string& text) { theLog().line(spdlog::level::debug, text); }
void logInfo(const std::string& text) { theLog().line(spdlog::level::info, text); }
void logWarning(const std::string& text) { theLog().line(spdlog::level::warn, text); }
void logError(const std::string& text) { theLog().line(spdlog::level::err, text); }

void setLogFooter(const std::string& text) {
    Log& log = theLog();
    const std::scoped_lock lock(log.mutex);
    if (!log.footer.empty()) std::fputs(kEraseLine, stderr);
    log.footer = text;
    log.drawFooter();
}

}  // namespace betamesh
