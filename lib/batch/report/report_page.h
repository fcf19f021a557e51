// A job on one page.

#pragma once

#include "batch/report/report.h"

#include <map>
#include <string>
#include <vector>

namespace betamesh {

/// What the page shows.
struct ReportPage {
    std::string title;
    std::vector<FrameReport> frames;         ///< ascending frames
    std::vector<int> missing;                ///< frames that were expected, but have no report; ascending
    std::map<int, double> jump;              ///< how far the surface moved to this frame, world units; where measured
    std::map<int, std::string> preview_png;  ///< the bytes of pictures, where there are some
};

/// An HTML file that needs no other and no network.
std::string htmlOf(const ReportPage& page);

}  // namespace betamesh
