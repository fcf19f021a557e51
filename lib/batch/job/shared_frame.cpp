#include "batch/job/shared_frame.h"

#include "batch/job/retrying.h"
#include "betamesh/simplify.h"
#include "skin/pipeline.h"

#include <functional>
#include <mutex>

namespace betamesh {

SkinParams skinOf(const Plan& plan) {
    SkinParams skin = plan.skin;
    if (skin.radius == 0) skin.radius = 1;
    return skin;
}

bool readTheSame(const Plan& a, const Plan& b, bool near_surface) {
    return a.config.input == b.config.input && (!near_surface || a.skin == b.skin);
}

bool skinTheSame(const Plan& a, const Plan& b) {
    return a.config.input == b.config.input && a.skin == b.skin &&
           a.config.surface.dimension == b.config.surface.dimension;
}

FrameInput& SharedFrame::liquid(const FrameTask& task, const Plan& plan) {
    if (read_for_ != nullptr && readTheSame(*read_for_, plan, liquid_.near.has_value())) return liquid_;
    read_for_ = skinned_for_ = nullptr;
    skinned_ = {};
    const auto foundNear = [&](const std::string& line) {
        logDetail(task.input + ": " + line);
        const std::scoped_lock lock(job_.mutex);
        job_.near_surface[task.frame] = line;
    };
    retrying(plan.config.run.retries, [&] {
        liquid_ = {};
        liquid_ = readInput(task, plan, near_surface_ || task.near_surface, identity_, foundNear);
    });
    std::vector<Vec3f>& velocity = liquid_.particles.velocity;
    if (velocity.empty()) velocity.resize(liquid_.particles.size(), Vec3f(0, 0, 0));
    read_for_ = &plan;
    return liquid_;
}

const SkinnedFrame& SharedFrame::skinned(const Plan& plan, StageWatch& watch) {
    if (skinned_for_ == nullptr || !skinTheSame(*skinned_for_, plan)) {
        skinned_for_ = nullptr;
        skinned_ = simplified_ = {};
        simplified_by_ = 0;
        skinned_ = liquid_.near ? skinFrame(liquid_.particles, *liquid_.near, skinOf(plan), std::ref(watch))
                                : skinFrame(liquid_.particles, skinOf(plan), std::ref(watch));
        skinned_for_ = &plan;
        measured_ = nullptr;
    }
    if (plan.simplify == 0) return skinned_;
    if (simplified_by_ != plan.simplify) {
        simplified_ = {simplified(skinned_.mesh, plan.simplify), skinned_.spheres, skinned_.report};
        simplified_by_ = plan.simplify;
        measured_ = nullptr;
    }
    watch(Stage::simplify);
    return simplified_;
}

const MeshMeasure& SharedFrame::measure(const Mesh& mesh) {
    if (measured_ != &mesh) measure_ = measureMesh(mesh);
    measured_ = &mesh;
    return measure_;
}

}  // namespace betamesh
