// Line plots as SVG.

#pragma once

#include <string>
#include <vector>

namespace betamesh {

struct PlotLine {
    std::string name;
    std::string colour;         ///< as in CSS
    std::vector<double> value;  ///< one per entry of Plot::at; not drawn if NaN, or not positive on a logarithmic axis
};

/// Lines over a linear horizontal axis.
struct Plot {
    std::string title;
    std::string x_label, y_label;  ///< of the axes
    std::vector<double> at;        ///< horizontal positions, ascending
    std::vector<PlotLine> lines;
    bool logarithmic = true;   ///< whether the vertical axis is logarithmic
    bool whole_at = false;     ///< horizontal positions are whole numbers, such as frames
    bool whole_value = false;  ///< values are whole numbers, and their axis begins at 0
    double width = 960;        ///< of the plot, pixels
    double height = 480;
};

/// An SVG file that depends on no other file.
std::string svgOf(const Plot& plot);

/// Text escaped for SVG and HTML, also inside double quotes.
std::string escaped(const std::string& plain);

}  // namespace betamesh
