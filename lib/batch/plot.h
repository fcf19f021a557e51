// Numbers over time as a picture that any browser shows.

#pragma once

#include <string>
#include <vector>

namespace betamesh {

struct PlotLine {
    std::string name;
    std::string colour;         ///< as in CSS
    std::vector<double> value;  ///< one for each of LogPlot::at; none is drawn where it is not positive and finite
};

/// Lines over a plain horizontal and a logarithmic vertical axis.
struct LogPlot {
    std::string title;
    std::string across, up;  ///< what the axes show
    std::vector<double> at;  ///< ascending
    std::vector<PlotLine> lines;
};

/// An SVG file that needs no other.
std::string svgOf(const LogPlot& plot);

}  // namespace betamesh
