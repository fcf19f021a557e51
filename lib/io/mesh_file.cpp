
#include "io/mesh_file.h"

#include "betamesh/error.h"
#include "io/bgeo.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/obj.h"
#include "io/ply.h"

namespace betamesh {

Mesh readMesh(const std::filesystem::path& path) {
    const Extension extension = meshExtension(path);
    ReadOptions options;
    options.id.clear();  // meshes have no ids: `id` is an ordinary attribute
    const std::string file = path.string();
    switch (extension) {
        case Extension::ply:
            return meshFrom(parsePly(openFile(path), options), file);
        case Extension::obj:
            return meshFrom(parseObj(readWholeFile(path), file), file);
        default:
            return meshFrom(parseBgeo(openFile(path), options), file);
    }
}

OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh) {
    const std::string file = path.string();
    switch (meshExtension(path)) {
        case Extension::ply:
            return encodedFile(path, [&](ByteWriter& out) { encodePly(out, mesh, file); });
        case Extension::obj:
            return encodedFile(path, [&](ByteWriter& out) { encodeObj(out, mesh, file); });
        default:
            return encodedFile(path, [&](ByteWriter& out) { encodeBgeo(out, mesh, file); });
    }
}

void writeMesh(const std::filesystem::path& path, const Mesh& mesh) { encodedMesh(path, mesh).commit(); }

void writeSpheres(const std::filesystem::path& path, const Spheres& spheres) {
    const std::string file = path.string();
    switch (meshExtension(path)) {
        case Extension::ply:
            return writeEncoded(path, [&](ByteWriter& out) { encodePly(out, spheres, file); });
        case Extension::obj:
            throw Error(file + ": .obj cannot store the radius of spheres. Use .ply or .bgeo.");
        default:
            return writeEncoded(path,
                                [&](ByteWriter& out) { encodeBgeo(out, particlesOf(spheres, "pscale", file), file); });
    }
}

void requireMeshExtension(const std::filesystem::path& path) { meshExtension(path); }

}  // namespace betamesh
