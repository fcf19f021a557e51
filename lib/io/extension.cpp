
#include "io/extension.h"

#include "base/nearest_word.h"
#include "betamesh/error.h"
#include "io/gzip.h"
#include "io/houdini_scf.h"
#include "io/output_file.h"

#include <cctype>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace betamesh {

namespace {

std::string lowerName(const std::filesystem::path& path) {
    std::string name = path.filename().string();
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name;
}

std::optional<Extension> extensionOf(const std::string& name) {
    for (const char* ending : {".bgeo", ".bgeo.gz", ".bgeo.sc", ".geo"})
        if (name.ends_with(ending)) return Extension::bgeo;
    if (name.ends_with(".bhclassic")) return Extension::bhclassic;
    if (name.ends_with(".ply")) return Extension::ply;
    if (name.ends_with(".vdb")) return Extension::vdb;
    if (name.ends_with(".obj")) return Extension::obj;
    if (name.ends_with(".svg")) return Extension::svg;
    return std::nullopt;
}

[[noreturn]] void failUnknownExtension(const std::filesystem::path& path, const char* kind, const char* known) {
    std::istringstream words(known);
    const std::vector<std::string> extensions{std::istream_iterator<std::string>(words), {}};
    const std::string extension = path.extension().string();
    throw Error(path.string() +
                (extension.empty() ? ": the name has no extension, which selects the format"
                                   : ": '" + extension + "' is not a format for " + kind) +
                ". Use one of " + known + '.' + didYouMean(extension, extensions));
}

}  // namespace

bool isVdb(const std::filesystem::path& path) { return extensionOf(lowerName(path)) == Extension::vdb; }

Extension particleExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::obj || *extension == Extension::svg)
        failUnknownExtension(path, "particles", ".bgeo .bgeo.gz .bgeo.sc .bhclassic .ply .vdb");
    return *extension;
}

Extension meshExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::vdb || *extension == Extension::svg)
        failUnknownExtension(path, "meshes", ".bgeo .bgeo.gz .bgeo.sc .bhclassic .obj .ply");
    return *extension;
}

Extension curveExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::vdb)
        failUnknownExtension(path, "curves", ".bgeo .bgeo.gz .bgeo.sc .bhclassic .obj .ply .svg");
    return *extension;
}

Extension anyExtension(const std::filesystem::path& path) {
    const auto extension = extensionOf(lowerName(path));
    if (!extension || *extension == Extension::svg)
        failUnknownExtension(path, "particles or meshes", ".bgeo .bgeo.gz .bgeo.sc .bhclassic .obj .ply .vdb");
    return *extension;
}

OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode) {
    const std::string name = lowerName(path);
    if (name.ends_with(".geo"))
        throw Error(path.string() + ": .geo can be read, but not written. Use .bgeo or .bgeo.sc.");
    OutputFile file(path);
    if (name.ends_with(".gz")) {
        GzipWriter packed([&](std::span<const std::byte> piece) { file.write(piece); });
        ByteWriter out([&](std::span<const std::byte> piece) { packed.write(piece); });
        encode(out);
        packed.finish();
    } else if (name.ends_with(".sc")) {
        ScfWriter packed([&](std::span<const std::byte> piece) { file.write(piece); });
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
