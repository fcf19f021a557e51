// The door of spdlog.

#include "batch/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <mutex>

namespace betamesh {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

struct Log {
    std::mutex mutex;
    std::string footer;
    spdlog::logger logger{"betamesh", std::make_shared<spdlog::sinks::stderr_color_sink_st>()};

    Log() { logger.set_pattern("%H:%M:%S %^%l%$: %v"); }

    void line(spdlog::level::level_enum level, const std::string& text) {
        const std::scoped_lock lock(mutex);
        if (!logger.should_log(level)) return;
        if (!footer.empty()) std::fputs(kEraseLine, stderr);
        logger.log(level, spdlog::string_view_t(text));
        drawFooter();
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
    theLog().logger.set_level(level == LogLevel::quiet     ? spdlog::level::err
                              : level == LogLevel::verbose ? spdlog::level::debug
                                                           : spdlog::level::info);
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
