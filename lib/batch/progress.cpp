#include "batch/progress.h"

#include "batch/log.h"
#include "core/error.h"

#include <unistd.h>

#include <cstdio>

namespace betamesh {
namespace {

constexpr std::size_t kBarCells = 30;

std::string secondsText(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f s", seconds);
    return text;
}

/// What a person wants to know of one frame.
std::string frameLine(const FrameReport& report) {
    const std::string name = "frame " + std::to_string(report.frame) + ": ";
    switch (report.status) {
        case FrameStatus::skipped:
            return name + "skipped (" + report.output + ')';
        case FrameStatus::failed:
            return name + "failed";
        case FrameStatus::empty:
            return name + "no particles, empty mesh -> " + report.output;
        case FrameStatus::ok:
            break;
    }
    const std::size_t particles = report.plane ? report.plane->skin.particles : report.skin.particles;
    const std::string surface =
        report.plane ? std::to_string(report.plane->edges) + " edges" : std::to_string(report.triangles) + " triangles";
    return name + std::to_string(particles) + " particles, " + surface + ", " + secondsText(report.seconds.total) +
           " -> " + report.output;
}

std::string detailLine(const FrameReport& report) {
    const StageSeconds& seconds = report.seconds;
    return "frame " + std::to_string(report.frame) + ": read " + secondsText(seconds.read) + ", structure " +
           secondsText(seconds.structure) + ", tessellate " + secondsText(seconds.tessellate) + ", smooth " +
           secondsText(seconds.smooth) + ", velocity " + secondsText(seconds.velocity) + ", write " +
           secondsText(seconds.write) + "; peak " + std::to_string(report.peak_bytes >> 20) + " MiB";
}

}  // namespace

ProgressKind progressKind(std::string_view word) {
    if (word == "auto") return ProgressKind::automatic;
    if (word == "bar") return ProgressKind::bar;
    if (word == "none") return ProgressKind::none;
    if (word == "openjd") return ProgressKind::openjd;
    if (word == "tractor") return ProgressKind::tractor;
    throw Error("progress '" + std::string(word) + "': expected one of auto bar none openjd tractor");
}

Progress::Progress(ProgressKind kind, std::size_t frames, bool stdout_is_taken)
    : kind_(kind), frames_(frames), farm_(stdout_is_taken ? stderr : stdout) {
    if (kind_ == ProgressKind::automatic) kind_ = isatty(STDERR_FILENO) != 0 ? ProgressKind::bar : ProgressKind::lines;
}

Progress::~Progress() {
    if (kind_ == ProgressKind::bar) setLogFooter("");
}

void Progress::frameEnded(const FrameReport& report) {
    ++ended_;
    if (report.status == FrameStatus::failed) ++failed_;
    const std::size_t percent = frames_ == 0 ? 100 : 100 * ended_ / frames_;
    const std::string count = std::to_string(ended_) + " of " + std::to_string(frames_) + " frames" +
                              (failed_ > 0 ? ", " + std::to_string(failed_) + " failed" : "");
    switch (kind_) {
        case ProgressKind::automatic:
        case ProgressKind::none:
            break;
        case ProgressKind::lines:
            logInfo(frameLine(report) + " (" + count + ')');
            break;
        case ProgressKind::bar: {
            const std::size_t cells = kBarCells * ended_ / std::max<std::size_t>(frames_, 1);
            setLogFooter('[' + std::string(cells, '=') + std::string(kBarCells - cells, ' ') + "] " + count);
            break;
        }
        case ProgressKind::openjd:
            std::fprintf(farm_, "openjd_progress: %zu\nopenjd_status: %s\n", percent, count.c_str());
            std::fflush(farm_);
            break;
        case ProgressKind::tractor:
            std::fprintf(farm_, "TR_PROGRESS %03zu%%\n", percent);
            std::fflush(farm_);
            break;
    }
    if (report.status == FrameStatus::ok) logDetail(detailLine(report));
}

void Progress::jobFailed(const std::string& why) {
    if (kind_ != ProgressKind::openjd) return;
    std::fprintf(farm_, "openjd_fail: %s\n", why.c_str());
    std::fflush(farm_);
}

}  // namespace betamesh
