
#include "batch/report/progress.h"

#include "base/nearest_word.h"
#include "batch/report/log.h"
#include "betamesh/error.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace betamesh {
namespace {

constexpr std::size_t kBarCells = 30;

constexpr std::array<std::pair<std::string_view, ProgressKind>, 6> kKinds{{{"auto", ProgressKind::automatic},
                                                                           {"bar", ProgressKind::bar},
                                                                           {"none", ProgressKind::none},
                                                                           {"openjd", ProgressKind::openjd},
                                                                           {"tractor", ProgressKind::tractor},
                                                                           {"json", ProgressKind::json}}};

std::string secondsText(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f s", seconds);
    return text;
}

/// One line about a frame for people.
std::string frameLine(const FrameResult& result) {
    const std::string name = "frame " + std::to_string(result.frame) + ": ";
    switch (result.status) {
        case FrameStatus::skipped:
            return name +
                   (result.input_missing ? "skipped, as there is no input (" + result.input
                                         : "skipped (" + result.output) +
                   ')';
        case FrameStatus::failed:
            return name + "failed";
        case FrameStatus::empty:
            return name + "no particles; empty mesh -> " + result.output;
        case FrameStatus::ok:
            break;
    }
    const std::string surface =
        result.plane ? std::to_string(result.plane->edges) + " edges" : std::to_string(result.triangles) + " triangles";
    return name + std::to_string(result.particles()) + (result.particles() == 1 ? " particle, " : " particles, ") +
           surface + ", " + secondsText(result.seconds.total) + " -> " + result.output;
}

/// Timings and memory of a frame.
std::string detailLine(const FrameResult& result) {
    const StageSeconds& seconds = result.seconds;
    std::string text;
    forStages([&](Stage stage) {
        if (seconds[stage] > 0)
            text += (text.empty() ? "" : ", ") + std::string(nameOf(stage)) + ' ' + secondsText(seconds[stage]);
    });
    return "frame " + std::to_string(result.frame) + ": " + text + "; peak " + std::to_string(result.peak_bytes >> 20) +
           " MiB";
}

/// ", 350k particles/s, 1:05 left"
std::string paceText(const JobProgress& job) {
    char text[64];
    std::string pace;
    if (job.seconds > 0 && job.particles > 0) {
        const double rate = static_cast<double>(job.particles) / job.seconds;
        const bool millions = rate >= 1e6;
        std::snprintf(text, sizeof text, ", %.3g%s particles/s", rate / (millions ? 1e6 : 1e3), millions ? "M" : "k");
        pace += text;
    }
    if (job.seconds_left && job.ended < job.frames) {
        const long seconds = std::lround(*job.seconds_left);
        const bool hours = seconds >= 3600;
        std::snprintf(text, sizeof text, hours ? ", %ld:%02ld:%02ld left" : ", %ld:%02ld left",
                      hours ? seconds / 3600 : seconds / 60, hours ? seconds / 60 % 60 : seconds % 60, seconds % 60);
        pace += text;
    }
    return pace;
}

}  // namespace

ProgressKind progressNamed(std::string_view name) {
    for (const auto& [kind_name, kind] : kKinds)
        if (kind_name == name) return kind;
    std::vector<std::string> names;
    for (const auto& entry : kKinds) names.emplace_back(entry.first);
    throw Error("--progress: '" + std::string(name) + "' is not valid. Use one of " + progressNames(", ") + '.' +
                didYouMean(name, names));
}

std::string progressNames(std::string_view separator) {
    std::string names;
    for (const auto& entry : kKinds) {
        if (!names.empty()) names += separator;
        names += entry.first;
    }
    return names;
}

Progress::Progress(ProgressKind kind, const JobProgress& so_far, bool stdout_is_taken)
    : kind_(kind), job_(so_far), farm_stream_(stdout_is_taken ? stderr : stdout) {
    if (kind_ == ProgressKind::automatic) kind_ = isatty(STDERR_FILENO) != 0 ? ProgressKind::bar : ProgressKind::lines;
}

Progress::~Progress() {
    if (kind_ == ProgressKind::bar) setLogFooter("");
}

void Progress::frameEnded(const std::vector<FrameResult>& outputs) {
    const auto any = [&](FrameStatus status) {
        return std::any_of(outputs.begin(), outputs.end(), [&](const FrameResult& r) { return r.status == status; });
    };
    std::size_t particles = 0;
    for (const FrameResult& result : outputs)
        if (result.status == FrameStatus::ok) particles = std::max(particles, result.particles());
    ++job_.ended;
    if (any(FrameStatus::failed)) ++job_.failed;
    if (any(FrameStatus::failed) || any(FrameStatus::ok) || any(FrameStatus::empty)) ++processed_;
    job_.particles += particles;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin_;
    job_.seconds = since.count();
    if (processed_ > 0)
        job_.seconds_left =
            job_.seconds / static_cast<double>(processed_) * static_cast<double>(job_.frames - job_.ended);
    const std::size_t percent = job_.frames == 0 ? 100 : 100 * job_.ended / job_.frames;
    const std::string count = std::to_string(job_.ended) + " of " + std::to_string(job_.frames) + " frames" +
                              (job_.failed > 0 ? ", " + std::to_string(job_.failed) + " failed" : "");
    switch (kind_) {
        case ProgressKind::automatic:
        case ProgressKind::none:
            break;
        case ProgressKind::lines:
            for (const FrameResult& result : outputs) logInfo(frameLine(result) + " (" + count + ')');
            break;
        case ProgressKind::bar: {
            const std::size_t cells = kBarCells * job_.ended / std::max<std::size_t>(job_.frames, 1);
            setLogFooter('[' + std::string(cells, '=') + std::string(kBarCells - cells, ' ') + "] " + count +
                         paceText(job_));
            break;
        }
        case ProgressKind::openjd:
            std::fprintf(farm_stream_, "openjd_progress: %zu\nopenjd_status: %s%s\n", percent, count.c_str(),
                         paceText(job_).c_str());
            std::fflush(farm_stream_);
            break;
        case ProgressKind::tractor:
            std::fprintf(farm_stream_, "TR_PROGRESS %03zu%%\n", percent);
            std::fflush(farm_stream_);
            break;
        case ProgressKind::json:
            std::fprintf(farm_stream_, "%s\n", progressJson(job_).c_str());
            std::fflush(farm_stream_);
            break;
    }
    for (const FrameResult& result : outputs)
        if (result.status == FrameStatus::ok) logDetail(detailLine(result));
}

void Progress::jobFailed(const std::string& reason) {
    if (kind_ != ProgressKind::openjd) return;
    std::fprintf(farm_stream_, "openjd_fail: %s\n", reason.c_str());
    std::fflush(farm_stream_);
}

}  // namespace betamesh
