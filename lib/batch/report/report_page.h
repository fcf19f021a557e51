// A whole job on one HTML page.

#pragma once

#include "batch/report/report.h"

#include <map>
#include <string>
#include <vector>

namespace betamesh {

/// One output of the job: the meshes of one sequence.
struct ReportOutput {
    std::string name;                 ///< path with #### for the frame
    std::vector<FrameResult> frames;  ///< ascending
    std::vector<int> missing;         ///< expected frames without a manifest, ascending
    std::map<int, double> jump;       ///< frame -> distance from the previous surface, world units, if measured
};

/// Previews of frames.
struct ReportPreviews {
    std::string name;                ///< path with a placeholder for the frame
    std::map<int, std::string> png;  ///< frame -> bytes of its preview
};

/// What the page shows.
struct ReportPage {
    std::string title;
    std::vector<ReportOutput> outputs;
    std::vector<ReportPreviews> previews;
};

/// The path of a frame's file with #### for the number of the frame; unchanged if its name has no such number.
std::string sequenceName(const std::string& file, int frame);

/// An HTML file that depends on no other file and no network, and is well-formed XML, too.
std::string htmlOf(const ReportPage& page);

}  // namespace betamesh
