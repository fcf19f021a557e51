
#include "io/mesh_file.h"

#include "betamesh/error.h"
#include "io/encoded_file.h"
#include "io/extension.h"

namespace betamesh {

// Meshes have no ids: `id` is an ordinary attribute.
Mesh readMesh(const std::filesystem::path& path, std::optional<double> frame) {
    return meshFrom(readFormat(path, FileKind::mesh, {.id = "", .frame = frame}), path.string());
}

Mesh readUncheckedMesh(const std::filesystem::path& path, std::optional<double> frame) {
    return uncheckedMeshFrom(readFormat(path, FileKind::mesh, {.id = "", .frame = frame}));
}

OutputFile encodedMesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options) {
    const FileFormat& format = formatOf(path, FileKind::mesh, Access::write);
    return encodedFile(path, [&](ByteWriter& out) {
        writeWithNames(format, FileKind::mesh, mesh,
                       [&](const Mesh& named) { format.write_mesh(out, named, path.string(), options); });
    });
}

void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options) {
    encodedMesh(path, mesh, options).commit();
}

bool canHoldSpheres(const std::filesystem::path& path) {
    return canHold(path, FileKind::mesh, Access::write) &&
           formatOf(path, FileKind::mesh, Access::write).write_spheres != nullptr;
}

void writeSpheres(const std::filesystem::path& path, const Spheres& spheres, const WriteOptions& options) {
    const FileFormat& format = formatOf(path, FileKind::mesh, Access::write);
    if (format.write_spheres == nullptr)
        throw Error(path.string() + ": " + std::string(format.write_extensions) +
                    " cannot store the radius of spheres. Use .ply or .bgeo.");
    if (!holdsIds(format, spheres.id)) {
        Spheres without_ids = spheres;
        without_ids.id.clear();
        if (options.warn != nullptr)
            (*options.warn)("the ids of the spheres are negative or need more than " + std::to_string(format.id_bits) +
                            " bits, which " + std::string(format.write_extensions) + " cannot hold: they are left out");
        return writeSpheres(path, without_ids, options);
    }
    writeEncoded(path, [&](ByteWriter& out) {
        writeWithNames(format, FileKind::particles, spheres,
                       [&](const Spheres& named) { format.write_spheres(out, named, path.string(), options); });
    });
}

void requireMeshExtension(const std::filesystem::path& path) { formatOf(path, FileKind::mesh, Access::write); }

}  // namespace betamesh
