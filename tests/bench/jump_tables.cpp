// Prints the tables of property/README.md: how far each surface, and each curve in two dimensions, jumps at single
// events. A minute and a half on one core.

#include "support/jumps.h"
#include "support/planar_jumps.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace betamesh {
namespace {

constexpr std::array<double, 4> kSpans{1e-3, 1e-4, 1e-5, 1e-6};  // seconds

void printHead(const char* surface) {
    std::printf("| event | %s | dt = 1e-3 | 1e-4 | 1e-5 | 1e-6 |\n|---|---|---|---|---|---|\n", surface);
}

/// With two digits, as in 4.7e-3 or 1.1.
std::string inShort(double number) {
    char text[32];
    std::snprintf(text, sizeof text, number < 1 ? "%.1e" : "%.1f", number);
    std::string shortened(text);
    if (const std::size_t zero = shortened.find("e-0"); zero != std::string::npos) shortened.erase(zero + 2, 1);
    return shortened;
}

/// One row: the median and the largest jump of some events over each span. jumpsAcross(span)
void printRow(const std::string& event, const std::string& surface,
              const std::function<std::vector<double>(double)>& jumpsAcross) {
    std::printf("| %s | %s |", event.c_str(), surface.c_str());
    for (const double span : kSpans) {
        std::vector<double> jumps = jumpsAcross(span);
        std::sort(jumps.begin(), jumps.end());
        std::printf(" %s, %s |", inShort(jumps[jumps.size() / 2]).c_str(), inShort(jumps.back()).c_str());
    }
    std::printf("\n");
    std::fflush(stdout);
}

void printSurfaces() {
    const std::vector<SingleEvent>& events = singleEvents();
    printHead("surface");
    const auto kindEnd = [&](auto first) {
        return std::find_if(first, events.end(), [&](const SingleEvent& event) {
            return event.kind != first->kind || event.in_block != first->in_block;
        });
    };
    for (auto first = events.begin(); first != events.end(); first = kindEnd(first))
        for (const auto& surface : comparedSurfaces()) {
            const auto jumpsAcross = [&](double span) {
                std::vector<double> jumps;
                for (auto event = first; event != kindEnd(first); ++event)
                    jumps.push_back(jumpAcross(event->particles, event->time, span, surface.second));
                return jumps;
            };
            printRow(first->kind + (first->in_block ? ", block" : ", thin"), surface.first, jumpsAcross);
        }
}

void printCurves() {
    printHead("curve");
    for (const std::string kind : {"birth", "contact", "hole"})
        for (const auto& curve : comparedCurves()) {
            const auto jumpsAcross = [&](double span) {
                std::vector<double> jumps;
                for (const PlanarEvent& event : planarEvents())
                    if (event.kind == kind) jumps.push_back(planarJumpAcross(event, span, curve.second));
                return jumps;
            };
            printRow(kind, curve.first, jumpsAcross);
        }
}

}  // namespace
}  // namespace betamesh

int main() {
    betamesh::printSurfaces();
    std::printf("\n");
    betamesh::printCurves();
    return EXIT_SUCCESS;
}
