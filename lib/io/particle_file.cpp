#include "io/particle_file.h"

#include "io/bgeo.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/output_file.h"
#include "io/ply.h"
#include "io/vdb.h"

namespace betamesh {

Particles readParticles(const std::filesystem::path& path, const AttributeNames& names) {
    const Extension extension = particleExtension(path);
    ReadOptions options;
    if (!names.id.empty()) options.id = names.id;
    options.faces = false;
    const std::string file = path.string();
    if (extension == Extension::vdb) return particlesFrom(readVdb(path, options), names, file);
    const Bytes bytes = readWholeFile(path);
    FileContents contents =
        extension == Extension::ply ? parsePly(bytes, file, options) : parseBgeo(bytes, file, options);
    return particlesFrom(std::move(contents), names, file);
}

void prepareToReadParticles(const std::filesystem::path& path) {
    if (particleExtension(path) == Extension::vdb) loadVdb();
}

void writeParticles(const std::filesystem::path& path, const Particles& particles) {
    const std::string file = path.string();
    switch (particleExtension(path)) {
        case Extension::vdb:
            return writeFile(path, encodeVdb(particles, file));
        case Extension::ply:
            return writeEncoded(path, [&](ByteWriter& out) { encodePly(out, particles, file); });
        default:
            return writeEncoded(path, [&](ByteWriter& out) { encodeBgeo(out, particles, file); });
    }
}

void requireParticleExtension(const std::filesystem::path& path) { particleExtension(path); }

}  // namespace betamesh
