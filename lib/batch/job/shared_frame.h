// What the outputs of a frame share.

#pragma once

#include "batch/job/frame_input.h"
#include "batch/job/job_state.h"
#include "batch/job/output_plan.h"
#include "batch/job/stage_watch.h"
#include "betamesh/check.h"
#include "betamesh/skin.h"

namespace betamesh {

/// The parameters of a frame. The radius of a sequence without particles is unknown, and any will do.
SkinParams skinOf(const Plan& plan);

/// Whether two outputs read the same particles. Those near the surface depend on its settings.
bool readTheSame(const Plan& a, const Plan& b, bool near_surface);

/// Whether two outputs have the same surface.
bool skinTheSame(const Plan& a, const Plan& b);

/// The particles and the surface of the output before, which the next output uses again if it has the same settings.
class SharedFrame {
public:
    SharedFrame(JobState& job, bool near_surface) : job_(job), near_surface_(near_surface) {}

    /// The particles of an output.
    FrameInput& liquid(const FrameTask& task, const Plan& plan);

    /// The identity of the file that liquid() has read.
    const FileIdentity& identity() const { return identity_; }

    /// The surface of the particles that liquid() has read.
    const SkinnedFrame& skinned(const Plan& plan, StageWatch& watch);

    /// measureMesh() of a mesh that skinned() has returned.
    const MeshMeasure& measure(const Mesh& mesh);

private:
    JobState& job_;
    bool near_surface_;
    FrameInput liquid_;
    FileIdentity identity_;
    SkinnedFrame skinned_, simplified_;
    double simplified_by_ = 0;        ///< tolerance of simplified_; 0: it was not made
    const Mesh* measured_ = nullptr;  ///< the mesh of measure_; null: none
    MeshMeasure measure_;
    const Plan* read_for_ = nullptr;     ///< the output for which liquid_ was read; null: none
    const Plan* skinned_for_ = nullptr;  ///< the output for which skinned_ was made; null: none
};

}  // namespace betamesh
