
#include "io/extension.h"

#include "betamesh/error.h"
#include "io/gzip.h"
#include "io/output_file.h"

#include <cctype>
#include <optional>

namespace betamesh {

namespace {

std::string lowerName(const std::filesystem::path& path) {
    std::string name = path.filename().string();
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name;
}

std::optional<Extension> extensionOf(const std::string& name) {
    // Houdini now calls the classic format .bhclassic. The reader reports a .bgeo.sc of the newer format.
    for (const char* ending : {".bgeo", ".bgeo.gz", ".bgeo.sc", ".bhclassic"})
        if (name.ends_with(ending)) return Extension::bgeo;
    if (name.ends_with(".ply")) return Extension::ply;
    if (name.ends_with(".vdb")) return Extension::vdb;
    if (name.ends_with(".obj")) return Extension::obj;
    if (name.ends_with(".svg")) return Extension::svg;
    return std::nullopt;
}

[[noreturn]] void failUnknownExtension(const std::filesystem::path& path, const char* kind, const char* known) {
    throw Error(path.string() + ": unknown extension for " + kind + ". Use one of " + known + ".");
}

}  // namespace

bool isVdb(const std::filesystem::path& path) { return extensionOf(lowerName(path)) == Extension::vdb; }

Extension particleExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::obj || *extension == Extension::svg)
        failUnknownExtension(path, "particles", ".bgeo .bgeo.gz .ply .vdb");
    return *extension;
}

Extension meshExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::vdb || *extension == Extension::svg)
        failUnknownExtension(path, "a mesh", ".bgeo .bgeo.gz .obj .ply");
    return *extension;
}

Extension curveExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::vdb)
        failUnknownExtension(path, "curves", ".bgeo .bgeo.gz .obj .ply .svg");
    return *extension;
}

Extension anyExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::svg)
        failUnknownExtension(path, "particles or a mesh", ".bgeo .bgeo.gz .obj .ply .vdb");
    return *extension;
}

OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode) {
    const std::string name = lowerName(path);
    if (name.ends_with(".sc")) throw Error(path.string() + ": .bgeo.sc cannot be written. Use .bgeo or .bgeo.gz.");
    OutputFile file(path);
    if (name.ends_with(".gz")) {
        GzipWriter packed([&](std::span<const std::byte> piece) { file.write(piece); });
        ByteWriter out([&](std::span<const std::byte> piece) { packed.write(piece); });
        encode(out);
        packed.finish();
    } else {
        ByteWriter out([&](std::span<const std::byte> piece) { file.write(piece); });
        encode(out);
    }
    return file;
}

void writeEncoded(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode) {
    encodedFile(path, encode).commit();
}

}  // namespace betamesh
