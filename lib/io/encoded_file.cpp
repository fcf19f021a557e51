#include "io/encoded_file.h"

#include "io/gzip.h"
#include "io/houdini_scf.h"

#include <cctype>
#include <span>

namespace betamesh {

namespace {
namespace fs = std::filesystem;
}

std::pair<std::string, std::string> splitExtension(const std::string& path) {
    const fs::path whole(path);
    std::string extension = whole.extension().string();
    if (extension == ".gz" || extension == ".sc") extension = whole.stem().extension().string() + extension;
    return {path.substr(0, path.size() - extension.size()), extension};
}

OutputFile encodedFile(const fs::path& path, const std::function<void(ByteWriter&)>& encode) {
    std::string name = path.filename().string();
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
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

void writeEncoded(const fs::path& path, const std::function<void(ByteWriter&)>& encode) {
    encodedFile(path, encode).commit();
}

}  // namespace betamesh
