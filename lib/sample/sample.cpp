
#include "sample/sample.h"

#include "base/nearest_word.h"
#include "betamesh/error.h"
#include "sample/scene.h"

#include <cmath>

namespace betamesh {

namespace {

struct Entry {
    SampleInfo info;
    SceneMaker make;
};

const std::vector<Entry>& entries() {
    static const std::vector<Entry> all = {
        {{"dambreak", "a column of liquid collapses in a tank with an obstacle and splashes", 30000}, makeDamBreak},
        {{"rotcube", "a spinning cube of liquid in free flight tears into sheets and tendrils", 30000},
         makeRotatingCube},
        {{"drop", "a drop, and a single particle beside it, sink slowly into a pool", 20000}, makeDrop},
        {{"bubble", "a bubble grows in a pool until the film above it tears", 20000}, makeBubble},
        {{"puddle", "two-dimensional: a drop, a thinning jet and a pool with a bubble", 1500}, makePuddle},
        {{"dambreak2d", "two-dimensional: a column of liquid collapses in a tank", 3000}, makePlaneDamBreak},
        {{"sheet", "a waving sheet, one particle thick", 10000}, makeSheet},
        {{"tendril", "threads of several widths are stretched, thin out and break up into beads", 4000}, makeTendril},
        {{"lattice", "a cubic lattice at rest, with exactly equal distances everywhere", 8000}, makeLattice},
        {{"jitter", "the same lattice; every particle oscillates by up to a quarter of the spacing", 8000}, makeJitter},
    };
    return all;
}

}  // namespace

std::vector<SampleInfo> samples() {
    std::vector<SampleInfo> infos;
    for (const Entry& entry : entries()) infos.push_back(entry.info);
    return infos;
}

Sample::Sample(const SampleParams& params) {
    if (!(params.frames_per_second > 0) || !std::isfinite(params.frames_per_second))
        throw Error("sample '" + params.name + "': the frame rate is " + std::to_string(params.frames_per_second) +
                    " frames per second. It must be positive.");
    std::vector<std::string> names;
    for (const Entry& entry : entries()) {
        if (entry.info.name == params.name) {
            SampleParams resolved = params;
            if (resolved.particles == 0) resolved.particles = entry.info.particles;
            scene_ = entry.make(resolved);
            return;
        }
        names.push_back(entry.info.name);
    }
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    throw Error("unknown sample '" + params.name + "'. Samples are: " + list + '.' + didYouMean(params.name, names));
}

Sample::~Sample() = default;
Sample::Sample(Sample&&) noexcept = default;
Sample& Sample::operator=(Sample&&) noexcept = default;

Particles Sample::frame(int number) { return scene_->frame(number); }
double Sample::spacing() const { return scene_->spacing(); }

}  // namespace betamesh
