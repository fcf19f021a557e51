#include "io/encoded_file.h"

#include "base/lower_case.h"
#include "io/gzip.h"
#include "io/houdini_scf.h"

#include <span>

namespace betamesh {

namespace {
namespace fs = std::filesystem;
}

OutputFile encodedFile(const fs::path& path, const std::function<void(ByteWriter&)>& encode) {
    const std::string name = lowerCase(path.filename().string());
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
