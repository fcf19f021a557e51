
#include "batch/job/dry_run.h"

#include "batch/job/frame_input.h"
#include "batch/job/plane.h"
#include "betamesh/error.h"
#include "io/particle_file.h"
#include "skin/particle_sizes.h"

#include <utility>

namespace betamesh {

std::string whyFrameFails(const FrameTask& task, const Plan& plan) {
    try {
        SummarisedParticles read = readSummarised(task.input, inputOf(plan.config, task.frame));
        const FrameInput liquid{std::move(read.particles), {}, std::move(read.summary)};
        const Particles& particles = liquid.particles;
        requireAttributes(liquid, plan.config);
        if (plan.config.surface.dimension == 2) flattened(particles, plan.spacing);
        particleSizes(particles, plan.skin);
        return "";
    } catch (const ParticleError& error) {
        return withRowInFile(error, task.input, inputOf(plan.config, task.frame));
    } catch (const Error& error) {
        return error.what();
    }
}

}  // namespace betamesh
