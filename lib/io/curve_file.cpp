
#include "io/curve_file.h"

#include "betamesh/error.h"
#include "io/encoded_file.h"
#include "io/extension.h"

namespace betamesh {

// Curves have no ids: `id` is an ordinary attribute.
Curves readCurves(const std::filesystem::path& path, std::optional<double> frame) {
    return curvesFrom(readFormat(path, FileKind::curves, {.id = "", .frame = frame}), path.string());
}

Curves readUncheckedCurves(const std::filesystem::path& path, std::optional<double> frame) {
    return uncheckedCurvesFrom(readFormat(path, FileKind::curves, {.id = "", .frame = frame}));
}

void writeCurves(const std::filesystem::path& path, const Curves& curves, const WriteOptions& options) {
    const FileFormat& format = formatOf(path, FileKind::curves, Access::write);
    if (format.write_curves == nullptr)
        throw Error(path.string() + ": a drawing is not written from curves alone. Use one of " +
                    extensionsFor(FileKind::mesh, Access::write) + ".");
    writeEncoded(path, [&](ByteWriter& out) {
        writeWithNames(format, FileKind::curves, curves,
                       [&](const Curves& named) { format.write_curves(out, named, path.string(), options); });
    });
}

void requireCurveExtension(const std::filesystem::path& path) { formatOf(path, FileKind::curves, Access::write); }

}  // namespace betamesh
