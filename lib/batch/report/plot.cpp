
#include "batch/report/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace betamesh {
namespace {

constexpr double kWidth = 960, kHeight = 480;                         // of the picture, pixels
constexpr double kLeft = 76, kRight = 936, kTop = 56, kBottom = 424;  // of the axes
constexpr double kMostMarked = 120;                                   // values that get a dot each
constexpr double kMostRungsNumbered = 11;
constexpr int kTicks = 8;

std::string text(double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.6g", x);
    return buffer;
}

std::string pixel(double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.1f", x);
    return buffer;
}

std::string written(double x, double y, const char* anchor, const std::string& what, const char* style = "") {
    return "<text x='" + pixel(x) + "' y='" + pixel(y) + "' text-anchor='" + anchor + "'" + style + ">" +
           escaped(what) + "</text>\n";
}

std::string ruled(double x1, double y1, double x2, double y2) {
    return "<path d='M" + pixel(x1) + " " + pixel(y1) + "L" + pixel(x2) + " " + pixel(y2) + "'/>\n";
}

bool isDrawn(double value, bool logarithmic) { return std::isfinite(value) && (value > 0 || !logarithmic); }

/// Between marks on an axis: 1, 2 or 5 times a power of ten.
double stepOf(double length) {
    const double wanted = length / kTicks, power = std::pow(10, std::floor(std::log10(wanted)));
    for (const double digit : {1.0, 2.0, 5.0})
        if (digit * power >= wanted) return digit * power;
    return 10 * power;
}

/// The marks from low to high, both included.
std::vector<double> marks(double low, double high, double step) {
    std::vector<double> all;
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
        all.push_back(k * step + 0.0);  // and not -0
    return all;
}

/// Where values stand in the picture.
struct Axes {
    double first = 0, last = 1;  // across
    double low = 0, high = 1;    // up; decades where logarithmic
    bool logarithmic = true;

    explicit Axes(const Plot& plot) : logarithmic(plot.logarithmic) {
        if (!plot.at.empty()) first = plot.at.front(), last = plot.at.back();
        if (!(last > first)) first -= 0.5, last += 0.5;
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const PlotLine& line : plot.lines)
            for (const double value : line.value)
                if (isDrawn(value, logarithmic)) least = std::min(least, value), most = std::max(most, value);
        if (most < least) return;
        if (logarithmic) {
            low = std::floor(std::log10(least)), high = std::ceil(std::log10(most));
            if (high == low) ++high;
        } else {
            if (least > 0 && least < most / 2) least = 0;  // what is small beside the rest is shown from nothing
            const double step = stepOf(most > least ? most - least : std::max(1.0, std::abs(most)));
            low = std::floor(least / step) * step, high = std::ceil(most / step) * step;
            if (high == low) high += step;
        }
    }
    double x(double at) const { return kLeft + (kRight - kLeft) * (at - first) / (last - first); }
    double y(double value) const {
        return kBottom - (kBottom - kTop) * ((logarithmic ? std::log10(value) : value) - low) / (high - low);
    }
    std::vector<double> rungs() const {
        std::vector<double> all = marks(low, high, logarithmic ? 1 : stepOf(high - low));
        if (logarithmic)
            for (double& rung : all) rung = std::pow(10, rung);
        return all;
    }
};

std::string gridOf(const Plot& plot, const Axes& axes) {
    std::string lines = "<g stroke='#e2e5e9'>\n", numbers = "<g fill='#5b6470'>\n";
    const std::vector<double> rungs = axes.rungs();
    const auto every = static_cast<std::size_t>(std::ceil(static_cast<double>(rungs.size()) / kMostRungsNumbered));
    for (std::size_t i = 0; i < rungs.size(); ++i) {
        const double y = axes.y(rungs[i]);
        lines += ruled(kLeft, y, kRight, y);
        if (i % every == 0) numbers += written(kLeft - 8, y + 4, "end", text(rungs[i]));
    }
    for (const double mark : marks(axes.first, axes.last, stepOf(axes.last - axes.first))) {
        lines += ruled(axes.x(mark), kTop, axes.x(mark), kBottom);
        numbers += written(axes.x(mark), kBottom + 18, "middle", text(mark));
    }
    numbers += written(kRight, kBottom + 38, "end", plot.across) + written(kLeft, kTop - 10, "start", plot.up);
    return lines + "</g>\n" + numbers + "</g>\n";
}

std::string drawn(const Plot& plot, const PlotLine& line, const Axes& axes) {
    std::string path, dots;
    bool down = false;  // the pen
    for (std::size_t i = 0; i < plot.at.size(); ++i) {
        if (!isDrawn(line.value[i], plot.logarithmic)) {
            down = false;
            continue;
        }
        const std::string x = pixel(axes.x(plot.at[i])), y = pixel(axes.y(line.value[i]));
        path += (down ? "L" : "M") + x + " " + y;
        down = true;
        if (static_cast<double>(plot.at.size()) <= kMostMarked)
            dots += "<circle cx='" + x + "' cy='" + y + "' r='2.5' stroke='none'/>\n";
    }
    return "<g stroke='" + line.colour + "' fill='" + line.colour + "'>\n<path d='" + path +
           "' fill='none' stroke-width='1.8' stroke-linejoin='round'/>\n" + dots + "</g>\n";
}

}  // namespace

std::string escaped(const std::string& plain) {
    std::string out;
    for (const char c : plain) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
    return out;
}

std::string svgOf(const Plot& plot) {
    const Axes axes(plot);
    std::string svg = "<svg xmlns='http://www.w3.org/2000/svg' width='" + pixel(kWidth) + "' height='" +
                      pixel(kHeight) + "' viewBox='0 0 " + pixel(kWidth) + " " + pixel(kHeight) +
                      "' font-family='Helvetica, Arial, sans-serif' font-size='12'>\n"
                      "<rect width='100%' height='100%' fill='white'/>\n";
    svg += written(kLeft, 24, "start", plot.title, " font-size='15' font-weight='bold' fill='#20262e'");
    svg += gridOf(plot, axes);
    double legend = kRight;
    for (auto line = plot.lines.rbegin(); line != plot.lines.rend(); ++line) {
        svg += drawn(plot, *line, axes);
        svg += written(legend, kTop - 10, "end", line->name, (" fill='" + line->colour + "'").c_str());
        legend -= 8.0 * static_cast<double>(line->name.size()) + 16;
    }
    return svg + "</svg>\n";
}

}  // namespace betamesh
