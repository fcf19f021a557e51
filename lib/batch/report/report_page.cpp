
#include "batch/report/report_page.h"

#include "batch/job/frames.h"
#include "batch/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

namespace betamesh {
namespace {

constexpr const char* kStyle =
    "body{font:14px Helvetica,Arial,sans-serif;color:#20262e;margin:24px;max-width:1500px}"
    "h1{font-size:20px}table{border-collapse:collapse;font-variant-numeric:tabular-nums}"
    "th,td{padding:2px 10px;text-align:right;border-bottom:1px solid #e2e5e9}th{position:sticky;top:0;background:white}"
    "td.text{text-align:left;max-width:40em}.failed td,.missing td{background:#fde8e8}.empty td{color:#5b6470}"
    ".plots{display:flex;flex-wrap:wrap;gap:8px}.plots svg{width:48%;height:auto;min-width:560px;flex:1}"
    ".previews{display:flex;flex-wrap:wrap;gap:8px}.previews figure{margin:0}.previews img{width:240px;height:auto}"
    "figcaption{text-align:center;color:#5b6470}";

constexpr std::array<const char*, 8> kColours{"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                              "#ff7f0e", "#17a2b8", "#8c564b", "#7f7f7f"};

using Value = std::function<double(const FrameReport&)>;

struct Curve {
    std::string name;
    Value value;
};

std::string number(double x) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", x);
    return text.data();
}

std::string cell(const std::string& text) { return "<td>" + escaped(text) + "</td>"; }
std::string cell(std::size_t count) { return cell(std::to_string(count)); }

/// A plot over all frames. Missing frames have the value NaN, so that lines are interrupted there.
std::string plotOf(const ReportPage& page, const std::string& title, const std::string& unit,
                   const std::vector<Curve>& curves, bool logarithmic) {
    Plot plot{title, "frame", unit, {}, {}, logarithmic};
    std::map<int, const FrameReport*> report_at;
    for (const int frame : page.missing) report_at[frame] = nullptr;
    for (const FrameReport& report : page.frames) report_at[report.frame] = &report;
    for (const auto& entry : report_at) plot.at.push_back(entry.first);
    for (std::size_t i = 0; i < curves.size(); ++i) {
        PlotLine line{curves[i].name, kColours[i % kColours.size()], {}};
        for (const auto& [frame, report] : report_at)
            line.value.push_back(report == nullptr ? std::numeric_limits<double>::quiet_NaN()
                                                   : curves[i].value(*report));
        plot.lines.push_back(std::move(line));
    }
    return svgOf(plot);
}

/// A count as a value to plot.
Value count(std::size_t (*of)(const FrameReport&)) {
    return [of](const FrameReport& report) { return static_cast<double>(of(report)); };
}

std::string plots(const ReportPage& page) {
    std::string text = "<div class=\"plots\">\n";
    text += plotOf(page, "Particles and triangles", "",
                   {{"particles", count([](const FrameReport& r) { return r.skin.particles; })},
                    {"triangles", count([](const FrameReport& r) { return r.triangles; })}},
                   true);
    std::vector<Curve> stages{{"total", [](const FrameReport& r) { return r.seconds.total; }}};
    forStages([&](Stage stage) {
        const auto seconds = [stage](const FrameReport& r) { return r.seconds[stage]; };
        if (std::any_of(page.frames.begin(), page.frames.end(), [&](const auto& r) { return seconds(r) > 0; }))
            stages.push_back({std::string(nameOf(stage)), seconds});
    });
    text += plotOf(page, "Time by stage", "seconds", stages, true);
    text +=
        plotOf(page, "Peak memory of the process", "MiB",
               {{"peak", [](const FrameReport& r) { return static_cast<double>(r.peak_bytes) / (1 << 20); }}}, false);
    text += plotOf(page, "Volume", "world units cubed",
                   {{"volume", [](const FrameReport& r) { return r.measure.volume; }}}, false);
    text += plotOf(page, "Components", "",
                   {{"components", count([](const FrameReport& r) { return r.measure.components; })}}, false);
    text += plotOf(page, "Retries and warnings", "",
                   {{"retries", [](const FrameReport& r) { return static_cast<double>(r.skin.perturbation_retries); }},
                    {"warnings", count([](const FrameReport& r) { return r.warnings.size(); })}},
                   false);
    if (!page.jump.empty())
        text += plotOf(page, "Distance from the surface of the previous frame", "world units",
                       {{"largest distance",
                         [&](const FrameReport& r) {
                             const auto jump = page.jump.find(r.frame);
                             return jump == page.jump.end() ? std::numeric_limits<double>::quiet_NaN() : jump->second;
                         }}},
                       true);
    return text + "</div>\n";
}

std::string rowOf(const FrameReport& report, const ReportPage& page) {
    const std::string status = nameOf(report.status);
    std::string notes = report.error;
    for (const std::string& warning : report.warnings) notes += (notes.empty() ? "" : "; ") + warning;
    const auto jump = page.jump.find(report.frame);
    return "<tr class=\"" + status + "\">" + cell(std::to_string(report.frame)) + cell(status) +
           cell(report.skin.particles) + cell(report.vertices) + cell(report.triangles) +
           cell(report.measure.components) + cell(number(report.measure.volume)) + cell(number(report.measure.area)) +
           cell(number(report.seconds.total)) + cell(number(static_cast<double>(report.peak_bytes >> 20))) +
           cell(std::to_string(report.skin.perturbation_retries)) +
           (page.jump.empty() ? "" : cell(jump == page.jump.end() ? "" : number(jump->second))) +
           "<td class=\"text\">" + escaped(notes) + "</td></tr>\n";
}

std::string table(const ReportPage& page) {
    std::string text =
        "<table>\n<thead><tr><th>frame<th>status<th>particles<th>vertices<th>triangles<th>components<th>volume<th>area"
        "<th>seconds<th>MiB<th>retries";
    text += page.jump.empty() ? "" : "<th>jump";
    text += "<th>notes</tr></thead>\n<tbody>\n";
    std::map<int, std::string> rows;
    for (const int frame : page.missing)
        rows[frame] = "<tr class=\"missing\">" + cell(std::to_string(frame)) +
                      "<td>missing</td><td colspan=\"11\" class=\"text\">no manifest</td></tr>\n";
    for (const FrameReport& report : page.frames) rows[report.frame] = rowOf(report, page);
    for (const auto& row : rows) text += row.second;
    return text + "</tbody>\n</table>\n";
}

std::string summary(const ReportPage& page) {
    double seconds = 0;
    std::size_t particles = 0, warnings = 0;
    std::uint64_t peak = 0;
    for (const FrameReport& report : page.frames) {
        seconds += report.seconds.total;
        particles += report.skin.particles;
        warnings += report.warnings.size();
        peak = std::max(peak, report.peak_bytes);
    }
    std::string text =
        "<p>" + std::to_string(page.frames.size()) + " frames, " + std::to_string(page.missing.size()) + " missing";
    if (!page.missing.empty()) text += " (" + printFrames(page.missing) + ")";
    return text + ", " + std::to_string(warnings) + " warnings; " + number(seconds) + " seconds in all frames, " +
           number(seconds > 0 ? static_cast<double>(particles) / seconds : 0) + " particles per second; peak memory " +
           number(static_cast<double>(peak >> 20)) + " MiB</p>\n";
}

/// Source: RFC 4648.
std::string base64(const std::string& bytes) {
    constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63U] : '=';
    }
    return text;
}

std::string previews(const ReportPage& page) {
    if (page.preview_png.empty()) return "";
    std::string text = "<div class=\"previews\">\n";
    for (const auto& [frame, png] : page.preview_png)
        text += "<figure><img alt=\"frame " + std::to_string(frame) + "\" src=\"data:image/png;base64," + base64(png) +
                "\"><figcaption>" + std::to_string(frame) + "</figcaption></figure>\n";
    return text + "</div>\n";
}

}  // namespace

std::string htmlOf(const ReportPage& page) {
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>" + escaped(page.title) +
           "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + escaped(page.title) + "</h1>\n" +
           summary(page) + plots(page) + previews(page) + table(page) + "</body>\n</html>\n";
}

}  // namespace betamesh
