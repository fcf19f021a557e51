
#include "io/file_info.h"

#include "io/bytes.h"
#include "io/extension.h"
#include "io/file_contents.h"
#include "io/houdini_geo.h"
#include "io/obj.h"
#include "io/ply.h"
#include "io/vdb.h"

#include <algorithm>
#include <system_error>

namespace betamesh {

namespace {

FileContents contentsOf(const std::filesystem::path& path) {
    const Extension extension = anyExtension(path);
    ReadOptions options;
    options.skip_unknown_faces = true;
    if (extension == Extension::vdb) return readVdb(path, options);
    switch (extension) {
        case Extension::ply:
            return parsePly(openFile(path), options);
        case Extension::obj:
            return parseObj(readWholeFile(path), path.string());
        default:
            return parseHoudini(openFile(path), options);
    }
}

}  // namespace

FileInfo inspectFile(const std::filesystem::path& path) {
    const FileContents contents = contentsOf(path);
    FileInfo info;
    info.kind = contents.declares_faces   ? FileKind::mesh
                : contents.declares_edges ? FileKind::curves
                                          : FileKind::particles;
    info.format = contents.format;
    std::error_code error;
    info.bytes = std::filesystem::file_size(path, error);
    info.points = contents.position.size();
    info.triangles = contents.triangles.size();
    info.edges = contents.edges.size();
    info.attributes = contents.declared;
    if (!contents.position.empty()) info.lower = info.upper = contents.position.front();
    for (const Vec3f& p : contents.position)
        for (int axis = 0; axis < 3; ++axis) {
            info.lower[axis] = std::min(info.lower[axis], p[axis]);
            info.upper[axis] = std::max(info.upper[axis], p[axis]);
        }
    return info;
}

}  // namespace betamesh
