
#include "io/file_info.h"

#include "io/extension.h"
#include "io/file_contents.h"
#include "io/particle_selector.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace betamesh {

FileInfo inspectFile(const std::filesystem::path& path, std::vector<Vec3f>* particles, std::optional<double> frame) {
    ReadOptions options;
    options.skip_unknown_faces = true;
    options.summary = true;
    options.frame = frame;
    FileInfo info;
    const FileFormat& format = formatByContents(path, info.note);
    FileContents contents = format.read(path, options);
    if (format.sampleTimes != nullptr) info.times = format.sampleTimes(path, options);
    info.kind = contents.kind();
    info.format = contents.format;
    std::error_code error;
    info.bytes = std::filesystem::file_size(path, error);
    info.points = contents.position.size();
    info.triangles = contents.triangles.size();
    info.edges = contents.edges.size();
    info.attributes = contents.declared;
    info.groups = contents.groups;
    info.grids = contents.grids;
    for (const std::string& note : {contents.units.up_axis_note, contents.units.meters_per_unit_note})
        if (!note.empty()) info.passed_over.push_back(note);
    info.passed_over.insert(info.passed_over.end(), contents.passed_over.begin(), contents.passed_over.end());
    info.passed_over.insert(info.passed_over.end(), contents.warnings.begin(), contents.warnings.end());
    info.volumes = contents.volumes;
    if (info.kind == FileKind::particles) {
        const std::string bad = dropBadParticles(path.string(), contents);
        if (!bad.empty()) info.passed_over.push_back(bad);
    }
    if (!contents.position.empty()) info.lower = info.upper = contents.position.front();
    for (const Vec3f& p : contents.position)
        for (int axis = 0; axis < 3; ++axis) {
            info.lower[axis] = std::min(info.lower[axis], p[axis]);
            info.upper[axis] = std::max(info.upper[axis], p[axis]);
        }
    if (particles != nullptr && info.kind == FileKind::particles)
        *particles = particlesFrom(std::move(contents), {}, path.string()).position;
    return info;
}

}  // namespace betamesh
