
#include "io/particle_file.h"

#include "io/extension.h"
#include "io/file_contents.h"

#include <utility>

namespace betamesh {

namespace {

/// Reads a file; options.points gets the points.
FileContents readPoints(const std::filesystem::path& path, ReadOptions& options) {
    options.faces = false;
    return readFormat(path, FileKind::particles, options);
}

/// rows: those to keep; null: all.
Particles readRows(const std::filesystem::path& path, const AttributeNames& names,
                   const std::vector<std::uint32_t>* rows) {
    const std::string file = path.string();
    ReadOptions options;
    if (!names.id.empty()) options.id = names.id;
    FileContents kept;
    std::size_t row = 0, next = 0;  // next row of the file; index of the next row to keep
    options.points = [&](FileContents&& points, std::uint64_t total) {
        const std::size_t first = std::exchange(row, row + points.position.size());
        if (rows) {
            requireFinite(points, names, first, file);  // particlesFrom() checks only the rows that are kept
            std::vector<std::uint32_t> rows_of_block;
            for (; next < rows->size() && (*rows)[next] < row; ++next)
                rows_of_block.push_back((*rows)[next] - static_cast<std::uint32_t>(first));
            keepRows(rows_of_block, points);
            total = rows->size();
        }
        append(std::move(points), total, kept);
    };
    kept.declared = readPoints(path, options).declared;
    return particlesFrom(std::move(kept), names, file);
}

}  // namespace

Particles readParticles(const std::filesystem::path& path, const AttributeNames& names) {
    return readRows(path, names, nullptr);
}

Particles readParticles(const std::filesystem::path& path, const AttributeNames& names,
                        const std::vector<std::uint32_t>& rows) {
    return readRows(path, names, &rows);
}

void visitPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit) {
    ReadOptions options;
    options.attributes = false;
    std::size_t row = 0;
    options.points = [&](FileContents&& points, std::uint64_t) {
        requireFinite(points, {}, row, path.string());
        row += points.position.size();
        visit(points.position);
    };
    readPoints(path, options);
}

void writeParticles(const std::filesystem::path& path, const Particles& particles) {
    const FileFormat& format = formatOf(path, FileKind::particles, Access::write);
    writeEncoded(path, [&](ByteWriter& out) { format.write_particles(out, particles, path.string()); });
}

void requireParticleExtension(const std::filesystem::path& path) { formatOf(path, FileKind::particles, Access::write); }

}  // namespace betamesh
