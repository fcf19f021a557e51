
#include "batch/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace betamesh {
namespace {

// Pixels.
constexpr double kLeftMargin = 76, kRightMargin = 24, kTopMargin = 56, kBottomMargin = 56;  // around the axes
constexpr double kTickDistance = 90;                                                        // horizontal, about
constexpr double kCharacterWidth = 7;                                                       // of the legend, at most

constexpr double kMaxDots = 120;     // lines with more values have no dots
constexpr double kMaxLabels = 11;    // on the vertical axis
constexpr double kValueTicks = 6;    // on a linear vertical axis, about
constexpr double kDenseDecades = 2;  // up to this length logarithmic axes have ticks at 2 and 5 times powers of ten

/// A number at a tick, with as many decimals as tell it from ticks at this distance; above 9999, unless it is a place
/// such as a frame, in thousands, millions and so on.
std::string tickText(double x, double step, bool is_place = false) {
    char buffer[48];
    constexpr std::array<const char*, 5> kSuffixes{"", "k", "M", "G", "T"};
    std::size_t suffix = 0;
    const auto next = [&] { return suffix == 0 ? 1e4 : std::pow(1e3, static_cast<double>(suffix + 1)); };
    while (!is_place && suffix + 1 < kSuffixes.size() && std::abs(x) >= next()) ++suffix;
    const double unit = std::pow(1e3, static_cast<double>(suffix));
    const int decimals = static_cast<int>(std::ceil(-std::log10(step / unit) - 1e-9));
    if (std::abs(x) < 1e15 && decimals <= 8)
        std::snprintf(buffer, sizeof buffer, "%.*f%s", std::max(0, decimals), x / unit, kSuffixes[suffix]);
    else
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

/// The distance between about `count` ticks on an axis of this length: 1, 2 or 5 times a power of ten, at least 1 for
/// whole numbers.
double tickStep(double length, double count, bool whole) {
    const double wanted = whole ? std::max(1.0, length / count) : length / count;
    const double power = std::pow(10, std::floor(std::log10(wanted)));
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

/// A position on an axis and its label.
struct Tick {
    double at = 0;
    std::string label;
};

std::vector<Tick> linearTicks(double low, double high, double step, bool are_places = false) {
    std::vector<Tick> ticks;
    for (const double at : ticksBetween(low, high, step)) ticks.push_back({at, tickText(at, step, are_places)});
    return ticks;
}

/// in      low, high: decimal logarithms
std::vector<Tick> logarithmicTicks(double low, double high) {
    std::vector<Tick> ticks;
    for (double power = std::floor(low); power <= high; ++power)
        for (const double digit : {1.0, 2.0, 5.0}) {
            const double at = digit * std::pow(10, power), place = std::log10(at);
            if ((digit > 1 && high - low > kDenseDecades) || place < low - 1e-9 || place > high + 1e-9) continue;
            ticks.push_back({at, tickText(at, std::pow(10, power))});
        }
    return ticks;
}

/// Maps values to pixels.
struct Axes {
    double left, right, top, bottom;  // pixels
    double first = 0, last = 1;       // ends of the horizontal axis
    double low = 0, high = 1;         // ends of the vertical axis; their decimal logarithms if logarithmic
    bool logarithmic;
    std::vector<Tick> x_ticks, y_ticks;

    explicit Axes(const Plot& plot)
        : left(kLeftMargin),
          right(plot.width - kRightMargin),
          top(kTopMargin),
          bottom(plot.height - kBottomMargin),
          logarithmic(plot.logarithmic) {
        if (!plot.at.empty()) first = plot.at.front(), last = plot.at.back();
        if (!(last > first)) first -= 0.5, last += 0.5;
        x_ticks = linearTicks(first, last, tickStep(last - first, (right - left) / kTickDistance, plot.whole_at), true);
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const PlotLine& line : plot.lines)
            for (const double value : line.value)
                if (isDrawn(value, logarithmic)) least = std::min(least, value), most = std::max(most, value);
        const bool any = least <= most;
        if (logarithmic) {
            if (any) low = std::floor(std::log10(least)), high = std::ceil(std::log10(most));
            if (high == low) ++high;
            y_ticks = logarithmicTicks(low, high);
        } else {
            if (any) low = least, high = most;
            // The axis begins at 0 unless that would waste most of it.
            if (low > 0 && (low < high / 2 || plot.whole_value)) low = 0;
            if (low == high && low == 0) high = 1;
            const double step = tickStep(high > low ? high - low : std::abs(high), kValueTicks, plot.whole_value);
            low = std::floor(low / step + 1e-9) * step, high = std::ceil(high / step - 1e-9) * step;
            if (high <= low) high = low + step;
            y_ticks = linearTicks(low, high, step);
        }
    }
    double x(double at) const { return left + (right - left) * (at - first) / (last - first); }
    double y(double value) const {
        return bottom - (bottom - top) * ((logarithmic ? std::log10(value) : value) - low) / (high - low);
    }
};

std::string gridOf(const Plot& plot, const Axes& axes) {
    std::string lines = "<g stroke='#e2e5e9'>\n", numbers = "<g fill='#5b6470'>\n";
    const auto every = static_cast<std::size_t>(std::ceil(static_cast<double>(axes.y_ticks.size()) / kMaxLabels));
    for (std::size_t i = 0; i < axes.y_ticks.size(); ++i) {
        const double y = axes.y(axes.y_ticks[i].at);
        lines += lineBetween(axes.left, y, axes.right, y);
        if (i % every == 0) numbers += textAt(axes.left - 8, y + 4, "end", axes.y_ticks[i].label);
    }
    for (const Tick& tick : axes.x_ticks) {
        lines += lineBetween(axes.x(tick.at), axes.top, axes.x(tick.at), axes.bottom);
        numbers += textAt(axes.x(tick.at), axes.bottom + 18, "middle", tick.label);
    }
    numbers += textAt(axes.right, axes.bottom + 38, "end", plot.x_label) +
               textAt(axes.left, axes.top - 10, "start", plot.y_label);
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
    const std::string width = pixel(plot.width), height = pixel(plot.height);
    std::string svg = "<svg xmlns='http://www.w3.org/2000/svg' width='" + width + "' height='" + height +
                      "' viewBox='0 0 " + width + " " + height +
                      "' font-family='Helvetica, Arial, sans-serif' font-size='12'>\n"
                      "<rect width='100%' height='100%' fill='white'/>\n";
    svg += textAt(axes.left, 24, "start", plot.title, " font-size='15' font-weight='bold' fill='#20262e'");
    svg += gridOf(plot, axes);
    double legend_x = axes.right;
    for (auto line = plot.lines.rbegin(); line != plot.lines.rend(); ++line) {
        if (std::none_of(line->value.begin(), line->value.end(),
                         [&](double value) { return isDrawn(value, plot.logarithmic); }))
            continue;
        svg += curveOf(plot, *line, axes);
        svg += textAt(legend_x, axes.top - 10, "end", line->name, (" fill='" + line->colour + "'").c_str());
        legend_x -= kCharacterWidth * static_cast<double>(line->name.size()) + 14;
    }
    return svg + "</svg>\n";
}

}  // namespace betamesh
