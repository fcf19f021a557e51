
#include "io/curve_file.h"

#include "betamesh/error.h"
#include "io/bgeo.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/obj.h"
#include "io/ply.h"

namespace betamesh {

Curves readCurves(const std::filesystem::path& path) {
    const Extension extension = meshExtension(path);
    ReadOptions options;
    options.id.clear();  // curves have no ids: `id` is an ordinary attribute
    const std::string file = path.string();
    switch (extension) {
        case Extension::ply:
            return curvesFrom(parsePly(openFile(path), options), file);
        case Extension::obj:
            return curvesFrom(parseObj(readWholeFile(path), file), file);
        default:
            return curvesFrom(parseBgeo(openFile(path), options), file);
    }
}

void writeCurves(const std::filesystem::path& path, const Curves& curves) {
    const std::string file = path.string();
    switch (meshExtension(path)) {
        case Extension::ply:
            return writeEncoded(path, [&](ByteWriter& out) { encodePly(out, curves, file); });
        case Extension::obj:
            return writeEncoded(path, [&](ByteWriter& out) { encodeObj(out, curves, file); });
        default:
            return writeEncoded(path, [&](ByteWriter& out) { encodeBgeo(out, curves, file); });
    }
}

void requireCurveExtension(const std::filesystem::path& path) { curveExtension(path); }

}  // namespace betamesh
