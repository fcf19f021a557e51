#include "coherence_table.h"

#include "batch/report/printable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>

namespace betamesh {
namespace {

constexpr std::size_t kNameColumns = 20;
constexpr std::size_t kEventColumns = 36;

std::string text(const Vec3& p) { return "(" + shortText(p.x) + ", " + shortText(p.y) + ", " + shortText(p.z) + ")"; }

/// Text filled with spaces up to a width; at least one space follows it.
std::string padded(const std::string& text, std::size_t columns) {
    return text.size() < columns ? text + std::string(columns - text.size(), ' ') : text + ' ';
}

/// A displacement as a multiple of that of the fastest particle.
std::string ratioText(const CoherenceReport& report, double displacement) {
    const std::optional<double> ratio = report.ratio(displacement);
    return ratio ? shortText(*ratio) : "-";
}

/// The change of shape at a place without a change of topology. If only the surface before or only the surface after is
/// far from the other one, a dent or a tip appeared or disappeared.
std::string shapeChangeAt(const JumpSite& place) {
    std::string change = "no change of topology";
    if (place.liquid == LiquidChange::both || (place.vanished > 0 && place.appeared > 0)) return change;
    const bool gained = place.liquid == LiquidChange::gained, vanished = place.vanished > 0;
    if (gained == vanished) return change + (gained ? ": dent filled" : ": dent opened");
    return change + (gained ? ": tip rose" : ": tip sank");
}

std::string eventsAt(const JumpSite& place) {
    std::string events;
    for (const auto& [event, times] : place.events) {
        if (!events.empty()) events += ", ";
        events += nameOf(event);
        if (times > 1) events += " (" + std::to_string(times) + " times)";
    }
    return events.empty() ? shapeChangeAt(place) : events;
}

void printPlace(const CoherenceReport& report, const JumpSite& place) {
    std::cout << "    " << padded(shortText(place.jump), 12) << padded(ratioText(report, place.jump), 10)
              << padded(shortText(report.expectedAt(place)), 12) << padded(std::to_string(place.points), 8)
              << padded(shortText(place.vanished), 11) << padded(shortText(place.appeared), 11)
              << padded(std::string(nameOf(place.liquid)), 8) << padded(eventsAt(place), kEventColumns)
              << text(place.position) << '\n';
}

void printJumpSites(const CoherenceReport& report, std::size_t max_places) {
    if (report.places.empty()) return;
    std::cout << "    " << padded("jump", 12) << padded("ratio", 10) << padded("expected", 12) << padded("points", 8)
              << padded("vanished", 11) << padded("appeared", 11) << padded("liquid", 8)
              << padded("what happened", kEventColumns) << "at\n";
    const std::size_t printed = std::min(max_places, report.places.size());
    for (std::size_t i = 0; i < printed; ++i) printPlace(report, report.places[i]);
    const std::size_t more = report.places.size() - printed;
    if (more > 0) std::cout << "    and " << more << (more == 1 ? " more place\n" : " more places\n");
}

}  // namespace

std::string shortText(double x) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.4g", x);
    return buffer.data();
}

void printTableHead(const std::string& first_moment, bool with_particles) {
    std::cout << padded("to", kNameColumns) << padded("max", 12) << padded("99.9 %", 12) << padded("RMS", 12)
              << (with_particles ? padded("particles", 12) + padded("ratio", 10) : "") << "farthest at\n"
              << printable(first_moment) << '\n';
}

void printTableRow(const CoherenceReport& report, bool with_particles, std::size_t max_places) {
    std::cout << padded(printable(report.to), kNameColumns);
    if (!report.error.empty()) {
        std::cout << "not measured\n";
        return;
    }
    const SurfaceDistance& distance = report.distance;
    std::cout << padded(shortText(distance.max), 12) << padded(shortText(distance.quantile999), 12)
              << padded(shortText(distance.rms), 12);
    if (with_particles)
        std::cout << padded(report.particles ? shortText(report.particles->max) : "-", 12)
                  << padded(ratioText(report, distance.max), 10);
    std::cout << text(distance.worst) << '\n';
    printJumpSites(report, max_places);
    std::cout.flush();
}

void printLargest(const std::vector<CoherenceReport>& reports) {
    const auto isMeasured = [](const CoherenceReport& report) {
        return report.error.empty() && (report.distance.area > 0 || std::isinf(report.distance.max));
    };
    const auto largest = std::ranges::max_element(reports, std::less<>(),
                                                  [&](const auto& r) { return isMeasured(r) ? r.distance.max : -1.0; });
    if (!isMeasured(*largest)) {
        const bool all_failed = std::ranges::none_of(reports, [](const auto& r) { return r.error.empty(); });
        std::cout << "nothing was measured: "
                  << (all_failed ? "no two surfaces in a row could be compared, see the errors"
                                 : "no surface has triangles, or none where the liquid is thick enough "
                                   "(--ignore-thinner)")
                  << '\n';
        return;
    }
    std::cout << "largest: " << shortText(largest->distance.max) << ", from " << printable(largest->from) << " to "
              << printable(largest->to) << " at " << text(largest->distance.worst) << '\n';
}

}  // namespace betamesh
