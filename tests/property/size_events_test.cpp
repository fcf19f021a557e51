// Single events on the boundary of balls of different and changing sizes, and how far the surface jumps there.

#include "base/random.h"
#include "betamesh/coherence.h"
#include "betamesh/skin.h"
#include "support/events.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace betamesh {
namespace {

constexpr double kSpacing = 1, kRadius = 1.5, kSkin = 0.55;  // of the largest particles

SkinParams paramsFor(double skin) {
    SkinParams params;
    params.radius = kRadius;
    params.spacing = kSpacing;
    params.skin = skin;
    params.radius_attribute = "size";
    return params;
}

struct Event {
    std::string kind;
    Particles particles;  // at time 0, with the rates of their sizes
    double time;
    std::string name;
};

Particles at(const Particles& start, double time) {
    Particles moved = advected(start, time);
    for (std::size_t i = 0; i < moved.size(); ++i)
        moved.attributes[0].real[i] += static_cast<float>(time) * moved.attributes[1].real[i];
    return moved;
}

// A block of particles of any sizes from half the spacing up; a block that is finer at one end; spray.
Particles sizedCloud(std::uint64_t seed) {
    Random random(seed);
    Particles particles = seed % 3 == 0   ? movingCloud(seed, {5, 5, 4}, 0.25, 1)
                          : seed % 3 == 1 ? movingCloud(seed, {4, 4, 2}, 0.25, 1)
                                          : movingCloud(seed, {5, 5, 5}, 0.5, 0.1);
    std::vector<float> size;
    for (std::size_t i = 0; i < particles.size(); ++i)
        size.push_back(seed % 3 == 1 ? 1 : static_cast<float>(random.between(0.5, 1)));
    if (seed % 3 == 1) {
        constexpr double kFine = 0.5;
        const Particles fine = movingCloud(seed + 1, {8, 8, 3}, 0.25, 1);
        for (std::size_t i = 0; i < fine.size(); ++i) {
            particles.position.emplace_back(Vec3(fine.position[i]) * kFine + Vec3(0, 0, 1.75));
            particles.velocity.emplace_back(Vec3(fine.velocity[i]) * kFine);
            particles.id.push_back(particles.id.size());
            size.push_back(kFine);
        }
    }
    std::vector<float> rate;
    for (const float s : size) rate.push_back(s * static_cast<float>(random.between(-0.5, 0.5)));
    particles.attributes = {{"size", 1, size, {}}, {"rate", 1, rate, {}}};
    return particles;
}

const std::vector<Event>& events() {
    static const std::vector<Event> all = [] {
        constexpr std::size_t kMost = 12, kMostOfACloud = 2;
        std::vector<Event> list;
        std::map<std::string, std::size_t> count;
        for (std::uint64_t seed = 0; seed < 24; ++seed) {
            const Particles start = sizedCloud(seed);
            std::map<std::string, std::size_t> here;
            findEvents(
                0, seed % 3 == 2 ? 1 : 0.05, paramsFor(kSkin), [&](double time) { return at(start, time); },
                [&](double time, const std::string& kind) {
                    if (kind == "several" || count[kind] == kMost || here[kind] == kMostOfACloud) return;
                    ++count[kind], ++here[kind];
                    list.push_back({kind, start, time,
                                    kind + " of cloud " + std::to_string(seed) + " at " + std::to_string(time)});
                });
        }
        return list;
    }();
    return all;
}

// In radii of the largest.
double jumpOf(const Event& event, double span, double skin) {
    const SkinParams params = paramsFor(skin);
    const Mesh before = skinFrame(at(event.particles, event.time - span / 2), params).mesh;
    const Mesh after = skinFrame(at(event.particles, event.time + span / 2), params).mesh;
    return surfaceDistance(before, after).max / kRadius;
}

bool changesFaces(const Event& event) { return event.kind == "flip" || event.kind == "birth"; }

TEST(SizeEvents, OfEveryKindAreFound) {
    std::map<std::string, std::size_t> count;
    for (const Event& event : events()) ++count[event.kind];
    for (const char* kind : {"flip", "birth", "hole", "graze", "contact"}) EXPECT_GE(count[kind], 4u) << kind;
}

// Balls of all sizes meet where one emerges between others.
TEST(SizeEvents, TheSurfaceOfTheBallsIsContinuousThroughFlipsAndBirths) {
    for (const Event& event : events()) {
        if (!changesFaces(event)) continue;
        for (const double span : {1e-6, 1e-7}) EXPECT_LE(jumpOf(event, span, 0), 0.0005) << event.name << ", " << span;
    }
}

// As with balls of one size.
TEST(SizeEvents, TheSkinHardlyJumpsAtFlipsAndBirths) {
    std::vector<double> found;
    for (const Event& event : events())
        if (changesFaces(event)) found.push_back(jumpOf(event, 1e-6, kSkin));
    ASSERT_GE(found.size(), 16u);
    std::sort(found.begin(), found.end());
    EXPECT_LE(found[found.size() / 2], 0.001);
    EXPECT_LE(found.back(), 0.03);
}

TEST(SizeEvents, TheSurfaceOfTheBallsHardlyJumpsWhereBallsBeginToTouch) {
    for (const Event& event : events()) {
        if (event.kind != "contact" && event.kind != "hole") continue;
        EXPECT_LE(jumpOf(event, 1e-5, 0), 0.01) << event.name;
    }
}

}  // namespace
}  // namespace betamesh
