// Numbers over time as a picture that any browser shows.

#pragma once

#include <string>
#include <vector>

namespace betamesh {

struct PlotLine {
    std::string name;
    std::string colour;         ///< as in CSS
    std::vector<double> value;  ///< one for each of Plot::at; none is drawn where the axis has no place for it
};

/// Lines over a plain horizontal axis.
struct Plot {
    std::string title;
    std::string across, up;  ///< what the axes show
    std::vector<double> at;  ///< ascending
    std::vector<PlotLine> lines;
    bool logarithmic = true;  ///< the axis up, of positive values; otherwise it spans what there is
};

/// An SVG file that needs no other.
std::string svgOf(const Plot& plot);

/// Text for SVG and HTML, also inside double quotes.
std::string escaped(const std::string& plain);

}  // namespace betamesh
