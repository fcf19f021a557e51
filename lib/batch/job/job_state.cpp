#include "batch/job/job_state.h"

#include "batch/job/empty_frames.h"

namespace betamesh {

bool JobState::isFirst(const std::string& kind) {
    const std::scoped_lock lock(mutex);
    return remarked.insert(kind).second;
}

void JobState::noteNoVelocity(int frame) {
    const std::scoped_lock lock(mutex);
    without_velocity.insert(frame);
}

void JobState::forgetVelocity(int frame) {
    const std::scoped_lock lock(mutex);
    without_velocity.erase(frame);
}

const std::vector<Attribute>& JobState::columnsOf(const Plan& plan) {
    {
        const std::scoped_lock lock(mutex);
        if (const auto known = columns.find(&plan); known != columns.end()) return known->second;
    }
    // Not under the lock: a thread that waits for others while it reads may begin another frame.
    std::vector<Attribute> found = attributesOfEmptyFrames(plan.config);
    const std::scoped_lock lock(mutex);
    return columns.emplace(&plan, std::move(found)).first->second;
}

}  // namespace betamesh
