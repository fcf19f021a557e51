
#include "batch/report/report_page.h"

#include "batch/job/frames.h"
#include "batch/report/plot.h"
#include "batch/report/printable.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <limits>
#include <set>

namespace betamesh {
namespace {

// A preview is the target of its own link, which shows it over the whole window.
constexpr const char* kStyle =
    "body{font:14px/1.4 Helvetica,Arial,sans-serif;color:#20262e;margin:24px auto;padding:0 24px;max-width:1500px}"
    "h1{font-size:22px}h2{font-size:17px;margin-top:32px}h1,h2,p,dd{overflow-wrap:anywhere}"
    "dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 16px;margin:12px 0}dt{color:#5b6470}dd{margin:0}"
    ".plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,520px),1fr));gap:8px}"
    ".plots svg{width:100%;height:auto;border:1px solid #e2e5e9;box-sizing:border-box}"
    ".frames{overflow:auto;max-height:85vh;margin-top:16px;border:1px solid #e2e5e9}"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums;width:100%}"
    "th,td{padding:2px 10px;text-align:right;border-bottom:1px solid #e2e5e9;white-space:nowrap}"
    "th{position:sticky;top:0;background:#f3f5f7}"
    "td.text,th.text{text-align:left;white-space:normal;min-width:16em;overflow-wrap:anywhere}"
    ".failed td,.missing td{background:#fde8e8}.empty td{color:#5b6470}"
    ".previews{display:flex;flex-wrap:wrap;gap:8px;max-height:340px;overflow:auto}.previews figure{margin:0}"
    ".previews img{width:240px;height:auto;display:block;cursor:zoom-in}"
    "figcaption{text-align:center;color:#5b6470}figure nav{display:none}"
    "figure:target{position:fixed;inset:0;z-index:1;display:flex;flex-direction:column;align-items:center;"
    "justify-content:center;gap:8px;background:#14181e}"
    "figure:target img{width:auto;max-width:98vw;max-height:88vh;cursor:default}"
    "figure:target figcaption{color:white}figure:target nav{display:flex;gap:24px}figure nav a{color:white}";

constexpr std::array<const char*, 8> kColours{"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                              "#ff7f0e", "#17a2b8", "#8c564b", "#7f7f7f"};
constexpr double kPlotWidth = 640, kPlotHeight = 340;  // pixels; about the size at which the page shows plots
constexpr double kLeastSeconds = 1e-3;                 // stages that take less are not drawn

using Value = std::function<double(const FrameResult&)>;

struct Curve {
    std::string name;
    Value value;
};

std::string number(double x) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", x);
    return text.data();
}

/// Text from files and paths as HTML.
std::string shown(const std::string& text) { return escaped(printable(text)); }

std::string cell(const std::string& text) { return "<td>" + shown(text) + "</td>"; }
std::string cell(std::size_t count) { return cell(std::to_string(count)); }

bool isPlane(const ReportOutput& output) { return !output.frames.empty() && output.frames.front().plane.has_value(); }

/// The curves of a frame; those of a frame with a surface have no edges.
PlaneFrameResult planeOf(const FrameResult& result) { return result.plane.value_or(PlaneFrameResult{}); }

double mebibytesOf(const FrameResult& result) { return static_cast<double>(result.peak_bytes >> 20); }

/// A plot over all frames. Missing frames have the value NaN, so that lines are interrupted there.
std::string plotOf(const ReportOutput& output, const std::string& title, const std::string& unit,
                   const std::vector<Curve>& curves, bool logarithmic) {
    const bool is_whole = unit == "count" || unit == "MiB";
    Plot plot{title, "frame", unit, {}, {}, logarithmic, true, is_whole, kPlotWidth, kPlotHeight};
    std::map<int, const FrameResult*> report_at;
    for (const int frame : output.missing) report_at[frame] = nullptr;
    for (const FrameResult& result : output.frames) report_at[result.frame] = &result;
    for (const auto& entry : report_at) plot.at.push_back(entry.first);
    for (std::size_t i = 0; i < curves.size(); ++i) {
        PlotLine line{curves[i].name, kColours[i % kColours.size()], {}};
        for (const auto& [frame, result] : report_at)
            line.value.push_back(result == nullptr ? std::numeric_limits<double>::quiet_NaN()
                                                   : curves[i].value(*result));
        plot.lines.push_back(std::move(line));
    }
    return svgOf(plot);
}

/// A count as a value to plot.
template <typename Count>
Value count(const Count& of) {
    return [of](const FrameResult& result) { return static_cast<double>(of(result)); };
}

/// Seconds as a value to plot; NaN, which is left out, if they are too few for a logarithmic axis.
double plottedSeconds(double seconds) {
    return seconds < kLeastSeconds ? std::numeric_limits<double>::quiet_NaN() : seconds;
}

/// Plots of what is measured on curves in two dimensions.
std::string planePlots(const ReportOutput& output) {
    return plotOf(output, "Particles and edges", "count",
                  {{"particles", count([](const auto& r) { return r.particles(); })},
                   {"edges", count([](const auto& r) { return planeOf(r).edges; })}},
                  true) +
           plotOf(output, "Enclosed area", "world units squared",
                  {{"area", [](const auto& r) { return planeOf(r).measure.area; }}}, false) +
           plotOf(output, "Curves", "count",
                  {{"curves", count([](const auto& r) { return planeOf(r).measure.curves; })}}, false);
}

/// Plots of what is measured on surfaces.
std::string surfacePlots(const ReportOutput& output) {
    return plotOf(output, "Particles and triangles", "count",
                  {{"particles", count([](const auto& r) { return r.particles(); })},
                   {"triangles", count([](const auto& r) { return r.triangles; })}},
                  true) +
           plotOf(output, "Volume", "world units cubed", {{"volume", [](const auto& r) { return r.measure.volume; }}},
                  false) +
           plotOf(output, "Components", "count",
                  {{"components", count([](const auto& r) { return r.measure.components; })}}, false);
}

std::string plots(const ReportOutput& output) {
    std::string text = "<div class=\"plots\">\n" + (isPlane(output) ? planePlots(output) : surfacePlots(output));
    std::vector<Curve> stages{{"total", [](const FrameResult& r) { return plottedSeconds(r.seconds.total); }}};
    forStages([&](Stage stage) {
        const auto seconds = [stage](const FrameResult& r) { return r.seconds[stage]; };
        if (std::any_of(output.frames.begin(), output.frames.end(), [&](const auto& r) { return seconds(r) > 0; }))
            stages.push_back(
                {std::string(nameOf(stage)), [=](const FrameResult& r) { return plottedSeconds(seconds(r)); }});
    });
    text += plotOf(output, "Time by stage, from a millisecond", "seconds", stages, true);
    text += plotOf(output, "Peak memory of the process", "MiB", {{"peak", mebibytesOf}}, false);
    text += plotOf(output, "Retries and warnings", "count",
                   {{"retries", count([](const auto& r) { return r.skin.perturbation_retries; })},
                    {"warnings", count([](const auto& r) { return r.warnings.size(); })}},
                   false);
    if (!output.jump.empty())
        text += plotOf(output, "Distance from the surface of the previous frame", "world units",
                       {{"largest distance",
                         [&](const FrameResult& r) {
                             const auto jump = output.jump.find(r.frame);
                             return jump == output.jump.end() ? std::numeric_limits<double>::quiet_NaN() : jump->second;
                         }}},
                       true);
    return text + "</div>\n";
}

std::string rowOf(const FrameResult& result, const ReportOutput& output) {
    const std::string status = nameOf(result.status);
    std::string notes = result.error;
    for (const std::string& warning : result.warnings) notes += (notes.empty() ? "" : "; ") + warning;
    const PlaneFrameResult plane = planeOf(result);
    const std::string shape = isPlane(output)
                                  ? cell(plane.edges) + cell(plane.measure.curves) + cell(number(plane.measure.area)) +
                                        cell(number(plane.measure.length))
                                  : cell(result.triangles) + cell(result.measure.components) +
                                        cell(number(result.measure.volume)) + cell(number(result.measure.area));
    const auto jump = output.jump.find(result.frame);
    return "<tr class=\"" + status + "\">" + cell(std::to_string(result.frame)) + cell(status) +
           cell(result.particles()) + cell(result.vertices) + shape + cell(number(result.seconds.total)) +
           cell(number(mebibytesOf(result))) + cell(std::to_string(result.skin.perturbation_retries)) +
           (output.jump.empty() ? "" : cell(jump == output.jump.end() ? "" : number(jump->second))) +
           "<td class=\"text\">" + shown(notes) + "</td></tr>\n";
}

std::string table(const ReportOutput& output) {
    std::vector<std::string> names{"frame", "status", "particles", "vertices"};
    if (isPlane(output))
        names.insert(names.end(), {"edges", "curves", "area", "length"});
    else
        names.insert(names.end(), {"triangles", "components", "volume", "area"});
    names.insert(names.end(), {"seconds", "MiB", "retries"});
    if (!output.jump.empty()) names.emplace_back("jump");
    std::string text = "<div class=\"frames\"><table>\n<thead><tr>";
    for (const std::string& name : names) text += "<th>" + name + "</th>";
    text += "<th class=\"text\">notes</th></tr></thead>\n<tbody>\n";
    std::map<int, std::string> rows;
    for (const int frame : output.missing)
        rows[frame] = "<tr class=\"missing\">" + cell(std::to_string(frame)) + "<td>missing</td><td colspan=\"" +
                      std::to_string(names.size() - 1) + "\" class=\"text\">no manifest</td></tr>\n";
    for (const FrameResult& result : output.frames) rows[result.frame] = rowOf(result, output);
    for (const auto& row : rows) text += row.second;
    return text + "</tbody>\n</table></div>\n";
}

/// The different texts of all frames; the first ones if there are many.
std::string valuesOf(const ReportOutput& output, const std::function<std::string(const FrameResult&)>& text) {
    std::set<std::string> values;
    for (const FrameResult& result : output.frames) values.insert(text(result));
    return firstNames({values.begin(), values.end()});
}

/// A length of all frames, or the least and the largest, in world units and in spacings; empty if it is 0.
std::string lengthOf(const ReportOutput& output, double FrameResult::*length) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const FrameResult& result : output.frames)
        least = std::min(least, result.*length), most = std::max(most, result.*length);
    if (!(most > 0)) return "";
    const std::string text = number(least) + (most > least ? " to " + number(most) : "") + " world units";
    const double spacing = output.frames.front().spacing;
    if (length == &FrameResult::spacing || !(spacing > 0) || most > least) return text;
    std::array<char, 32> spacings{};
    std::snprintf(spacings.data(), spacings.size(), " (%.3g spacings)", most / spacing);
    return text + spacings.data();
}

/// Names joined by "and"; "none" if there are none.
std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : " and ") + name;
    return text.empty() ? "none" : text;
}

/// What the frames of an output have in common.
std::string settings(const ReportOutput& output) {
    std::string text = "<dl>\n";
    const auto row = [&](const char* name, const std::string& value) {
        if (!value.empty()) text += std::string("<dt>") + name + "</dt><dd>" + shown(value) + "</dd>\n";
    };
    row("Input", valuesOf(output, [](const auto& r) { return sequenceName(r.input, r.frame); }));
    row("Output", output.name);
    std::vector<int> frames;
    for (const FrameResult& result : output.frames) frames.push_back(result.frame);
    if (!frames.empty()) row("Frames", printFrames(frames));
    if (!output.missing.empty()) row("Missing frames", printFrames(output.missing));
    if (frames.empty()) return text + "</dl>\n";
    row("Preset", valuesOf(output, [](const auto& r) { return listed(r.preset); }));
    row("Radius", lengthOf(output, &FrameResult::radius));
    row("Spacing", lengthOf(output, &FrameResult::spacing));
    const std::string skin = lengthOf(output, &FrameResult::skin_depth);
    row("Skin", skin.empty() ? "none" : skin);
    row("Dimension", valuesOf(output, [](const auto& r) { return r.plane ? "2" : "3"; }));
    row("Program", valuesOf(output, [](const auto& r) {
            return "betamesh " + (r.provenance ? r.provenance->version : std::string("of unknown version"));
        }));
    return text + "</dl>\n";
}

std::string summary(const ReportOutput& output) {
    double seconds = 0, peak = 0;
    std::size_t particles = 0, warnings = 0;
    for (const FrameResult& result : output.frames) {
        seconds += result.seconds.total;
        particles += result.particles();
        warnings += result.warnings.size();
        peak = std::max(peak, mebibytesOf(result));
    }
    return "<p>" + std::to_string(output.frames.size()) + " frames, " + std::to_string(output.missing.size()) +
           " missing, " + std::to_string(warnings) + " warnings; " + number(seconds) + " seconds in all frames, " +
           std::to_string(std::llround(seconds > 0 ? static_cast<double>(particles) / seconds : 0)) +
           " particles per second; peak memory " + number(peak) + " MiB</p>\n";
}

/// source  RFC 4648.
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

/// The previews of a sequence. A link opens each over the whole window, with links to the ones before and after.
std::string previews(const ReportPreviews& sequence, const std::string& id) {
    if (sequence.png.empty()) return "";
    const auto figureId = [&](int frame) { return id + "-frame-" + std::to_string(frame); };
    const auto link = [](const std::string& target, const char* text) {
        return "<a href=\"#" + target + "\">" + text + "</a>";
    };
    std::string text = "<p id=\"" + id + "\">" + shown(sequence.name) + "</p>\n<div class=\"previews\">\n";
    for (auto at = sequence.png.begin(); at != sequence.png.end(); ++at) {
        const std::string frame = std::to_string(at->first), target = figureId(at->first);
        text += "<figure id=\"" + target + "\"><a href=\"#" + target + "\"><img alt=\"frame " + frame +
                "\" src=\"data:image/png;base64," + base64(at->second) + "\" /></a><figcaption>" + frame +
                "</figcaption><nav>";
        if (at != sequence.png.begin()) text += link(figureId(std::prev(at)->first), "previous");
        text += link(id, "close");
        if (std::next(at) != sequence.png.end()) text += link(figureId(std::next(at)->first), "next");
        text += "</nav></figure>\n";
    }
    return text + "</div>\n";
}

}  // namespace

std::string sequenceName(const std::string& file, int frame) {
    const auto isDigit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(file[i])) != 0; };
    for (std::size_t end = file.size(); end > 0 && file[end - 1] != '/'; --end) {
        if (!isDigit(end - 1)) continue;
        std::size_t begin = end;
        while (begin > 0 && isDigit(begin - 1)) --begin;
        if (std::strtoll(file.substr(begin, end - begin).c_str(), nullptr, 10) == std::abs(static_cast<long>(frame))) {
            if (frame < 0 && begin > 0 && file[begin - 1] == '-') --begin;
            return file.substr(0, begin) + "####" + file.substr(end);
        }
        end = begin + 1;
    }
    return file;
}

std::string htmlOf(const ReportPage& page) {
    const std::string title = shown(page.title);
    std::string text =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\" />\n"
        "<meta name=\"viewport\" content=\"width=device-width\" />\n<title>" +
        title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + title + "</h1>\n";
    for (std::size_t i = 0; i < page.previews.size(); ++i)
        text += previews(page.previews[i], "previews-" + std::to_string(i + 1));
    for (const ReportOutput& output : page.outputs) {
        if (page.outputs.size() > 1) text += "<h2>" + shown(output.name) + "</h2>\n";
        text += settings(output) + summary(output) + plots(output) + table(output);
    }
    return text + "</body>\n</html>\n";
}

}  // namespace betamesh
