
#include "batch/report/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace betamesh {
namespace {

constexpr double kWidth = 960, kHeight = 480;                         // of the picture, pixels
constexpr double kLeft = 76, kRight = 936, kTop = 56, kBottom = 424;  // of the axes, pixels
constexpr double kMaxDots = 120;                                      // lines with more values have no dots
constexpr double kMaxLabels = 11;                                     // on the vertical axis
constexpr int kTicks = 8;                                             // on a linear axis, about

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

std::string textAt(double x, double y, const char* anchor, const std::string& what, const char* style = "") {
    return "<text x='" + pixel(x) + "' y='" + pixel(y) + "' text-anchor='" + anchor + "'" + style + ">" +
           escaped(what) + "</text>\n";
}

std::string lineBetween(double x1, double y1, double x2, double y2) {
    return "<path d='M" + pixel(x1) + " " + pixel(y1) + "L" + pixel(x2) + " " + pixel(y2) + "'/>\n";
}

bool isDrawn(double value, bool logarithmic) { return std::isfinite(value) && (value > 0 || !logarithmic); }

/// The distance between ticks on an axis of this length: 1, 2 or 5 times a power of ten.
double tickStep(double length) {
    const double wanted = length / kTicks, power = std::pow(10, std::floor(std::log10(wanted)));
    for (const double digit : {1.0, 2.0, 5.0})
        if (digit * power >= wanted) return digit * power;
    return 10 * power;
}

/// The multiples of step from low to high, both included.
std::vector<double> ticksBetween(double low, double high, double step) {
    std::vector<double> all;
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
        all.push_back(k * step + 0.0);  // + 0.0 turns -0 into 0
    return all;
}

/// Maps values to pixels.
struct Axes {
    double first = 0, last = 1;  // ends of the horizontal axis
    double low = 0, high = 1;    // ends of the vertical axis; their decimal logarithms if logarithmic
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
            if (least > 0 && least < most / 2) least = 0;  // begin at 0 unless that would waste most of the axis
            const double step = tickStep(most > least ? most - least : std::max(1.0, std::abs(most)));
            low = std::floor(least / step) * step, high = std::ceil(most / step) * step;
            if (high == low) high += step;
        }
    }
    double x(double at) const { return kLeft + (kRight - kLeft) * (at - first) / (last - first); }
    double y(double value) const {
        return kBottom - (kBottom - kTop) * ((logarithmic ? std::log10(value) : value) - low) / (high - low);
    }
    std::vector<double> yTicks() const {
        std::vector<double> all = ticksBetween(low, high, logarithmic ? 1 : tickStep(high - low));
        if (logarithmic)
            for (double& tick : all) tick = std::pow(10, tick);
        return all;
    }
};

std::string gridOf(const Plot& plot, const Axes& axes) {
    std::string lines = "<g stroke='#e2e5e9'>\n", numbers = "<g fill='#5b6470'>\n";
    const std::vector<double> y_ticks = axes.yTicks();
    const auto every = static_cast<std::size_t>(std::ceil(static_cast<double>(y_ticks.size()) / kMaxLabels));
    for (std::size_t i = 0; i < y_ticks.size(); ++i) {
        const double y = axes.y(y_ticks[i]);
        lines += lineBetween(kLeft, y, kRight, y);
        if (i % every == 0) numbers += textAt(kLeft - 8, y + 4, "end", text(y_ticks[i]));
    }
    for (const double tick : ticksBetween(axes.first, axes.last, tickStep(axes.last - axes.first))) {
        lines += lineBetween(axes.x(tick), kTop, axes.x(tick), kBottom);
        numbers += textAt(axes.x(tick), kBottom + 18, "middle", text(tick));
    }
    numbers += textAt(kRight, kBottom + 38, "end", plot.x_label) + textAt(kLeft, kTop - 10, "start", plot.y_label);
    return lines + "</g>\n" + numbers + "</g>\n";
}

std::string curveOf(const Plot& plot, const PlotLine& line, const Axes& axes) {
    std::string path, dots;
    bool pen_down = false;
    for (std::size_t i = 0; i < plot.at.size(); ++i) {
        if (!isDrawn(line.value[i], plot.logarithmic)) {
            pen_down = false;
            continue;
        }
        const std::string x = pixel(axes.x(plot.at[i])), y = pixel(axes.y(line.value[i]));
        path += (pen_down ? "L" : "M") + x + " " + y;
        pen_down = true;
        if (static_cast<double>(plot.at.size()) <= kMaxDots)
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
    svg += textAt(kLeft, 24, "start", plot.title, " font-size='15' font-weight='bold' fill='#20262e'");
    svg += gridOf(plot, axes);
    double legend_x = kRight;
    for (auto line = plot.lines.rbegin(); line != plot.lines.rend(); ++line) {
        svg += curveOf(plot, *line, axes);
        svg += textAt(legend_x, kTop - 10, "end", line->name, (" fill='" + line->colour + "'").c_str());
        legend_x -= 8.0 * static_cast<double>(line->name.size()) + 16;
    }
    return svg + "</svg>\n";
}

}  // namespace betamesh
