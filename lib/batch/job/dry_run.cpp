
#include "batch/job/dry_run.h"

#include "batch/job/plane.h"
#include "betamesh/error.h"
#include "io/particle_file.h"
#include "skin/attributes.h"
#include "skin/particle_sizes.h"

namespace betamesh {

std::string whyFrameFails(const FrameTask& task, const Plan& plan) {
    try {
        const Particles particles = readParticles(task.input, plan.config.input);
        if (plan.config.surface.dimension == 2) flattened(particles, plan.spacing);
        carriedAttributes(particles, {}, {}, {}, plan.skin.attributes, {});  // of no vertices: checks the names alone
        particleSizes(particles, plan.skin);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

}  // namespace betamesh
