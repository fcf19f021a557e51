#include "batch/job/frame_task.h"

#include "io/extension.h"
#include "io/mesh_file.h"

namespace betamesh {

bool isWritten(FrameAction action) {
    return action == FrameAction::mesh || action == FrameAction::draw || action == FrameAction::write_empty;
}

const char* actionName(FrameAction action) {
    switch (action) {
        case FrameAction::mesh:
            return "mesh";
        case FrameAction::draw:
            return "draw (mesh is up to date)";
        case FrameAction::write_empty:
            return "write empty mesh (input missing)";
        case FrameAction::skip_missing:
            return "skip (input missing)";
        case FrameAction::fail_missing:
            return "fail (input missing)";
        case FrameAction::fail_lost:
            return "fail (process ended)";
        case FrameAction::skip_existing:
            return "skip (output exists)";
        case FrameAction::refuse_existing:
            return "refuse (output exists)";
    }
    return "";
}

const char* nameOf(FrameStatus status) {
    switch (status) {
        case FrameStatus::ok:
            return "ok";
        case FrameStatus::empty:
            return "empty";
        case FrameStatus::skipped:
            return "skipped";
        case FrameStatus::failed:
            return "failed";
    }
    return "";
}

WriteOptions writeOptions(const WriteOptions& of_sequence, int frame) {
    WriteOptions options = of_sequence;
    options.frame = frame;
    return options;
}

std::string manifestPath(const std::string& output) { return output + ".json"; }

std::string spheresPath(const std::string& output) {
    const auto [stem, extension] = splitExtension(output);
    return stem + ".spheres" + (canHoldSpheres(output) ? extension : ".ply");
}

}  // namespace betamesh
