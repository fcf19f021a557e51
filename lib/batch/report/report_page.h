// A whole job on one HTML page.

#pragma once

#include "batch/report/report.h"

#include <map>
#include <string>
#include <vector>

namespace betamesh {

/// What the page shows.
struct ReportPage {
    std::string title;
    std::vector<FrameReport> frames;         ///< ascending
    std::vector<int> missing;                ///< expected frames without a manifest, ascending
    std::map<int, double> jump;              ///< frame -> distance from the previous surface, world units, if measured
    std::map<int, std::string> preview_png;  ///< frame -> bytes of its picture, if there is one
};

/// An HTML file that depends on no other file and no network.
std::string htmlOf(const ReportPage& page);

}  // namespace betamesh
