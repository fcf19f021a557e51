
#include "io/particle_file.h"

#include "base/local_origin.h"
#include "betamesh/error.h"
#include "io/encoded_file.h"
#include "io/extension.h"
#include "io/file_contents.h"
#include "io/particle_selector.h"

#include <numeric>
#include <utility>

namespace betamesh {

namespace {

/// Reads a file; options.points gets the points.
FileContents readPoints(const std::filesystem::path& path, ReadOptions& options) {
    options.faces = false;
    return readFormat(path, FileKind::particles, options);
}

ReadOptions readOptions(const ParticleInput& input) {
    ReadOptions options;
    if (!input.id.empty()) options.id = input.id;
    options.grids = input.grid;
    options.groups = input.group;
    options.origin = input.origin;
    options.frame = input.frame;
    return options;
}

/// Calls take(points, total) for each block of chosen points of a file, and returns the rest of its contents.
template <typename Take>
FileContents readChosen(const std::filesystem::path& path, const ParticleInput& input, bool attributes,
                        ParticleSelector& selector, const Take& take) {
    ReadOptions options = readOptions(input);
    options.attributes = attributes || selector.needsAttributes();
    options.needs = [&](const std::string& attribute) { return selector.needs(attribute); };
    options.points = [&](FileContents&& points, std::uint64_t total) {
        selector.choose(points);
        take(std::move(points), total);
    };
    if (!input.grid.empty() && !hasGrids(path))
        throw Error(
            path.string() + ": has no grids, but grid '" + input.grid[0] +
            "' is asked for (input.grid). Only .vdb files have grids, .usda files prims and .abc files objects.");
    return readPoints(path, options);
}

}  // namespace

SummarisedParticles readSummarised(const std::filesystem::path& path, const ParticleInput& input,
                                   const std::vector<std::uint32_t>* rows) {
    const std::string file = path.string();
    ParticleSelector selector(input, file);
    // particlesFrom() checks the particles that are kept, but does not know their rows in the file.
    selector.check(rows != nullptr || selector.mayLeaveOut() ? Checks::velocities : Checks::none);
    FileContents kept;
    std::size_t row = 0, next = 0;  // next row of the chosen points; index of the next row to keep
    FileContents rest = readChosen(path, input, true, selector, [&](FileContents&& points, std::uint64_t total) {
        const std::size_t first = std::exchange(row, row + points.position.size());
        if (rows != nullptr) {
            std::vector<std::uint32_t> rows_of_block;
            for (; next < rows->size() && (*rows)[next] < row; ++next)
                rows_of_block.push_back((*rows)[next] - static_cast<std::uint32_t>(first));
            keepRows(rows_of_block, points);
            total = rows->size();
        }
        append(std::move(points), total, kept);
    });
    kept.declared = std::move(rest.declared);
    SummarisedParticles result;
    result.summary = selector.summary(kept, rest);
    result.particles = particlesFrom(std::move(kept), input, file);
    return result;
}

Particles readParticles(const std::filesystem::path& path, const ParticleInput& input) {
    return readSummarised(path, input).particles;
}

Particles readParticles(const std::filesystem::path& path, const ParticleInput& input,
                        const std::vector<std::uint32_t>& rows) {
    return readSummarised(path, input, &rows).particles;
}

void visitPositions(const std::filesystem::path& path, const ParticleInput& input,
                    const std::function<void(std::span<const Vec3f>)>& visit) {
    ParticleSelector selector(input, path.string());
    selector.check(Checks::positions);
    readChosen(path, input, false, selector, [&](FileContents&& points, std::uint64_t) {
        toWorld(input, points.position);
        visit(points.position);
    });
}

void visitPositions(const std::filesystem::path& path, const std::function<void(std::span<const Vec3f>)>& visit) {
    visitPositions(path, {}, visit);
}

void visitAttributes(const std::filesystem::path& path, const ParticleInput& input,
                     const std::function<void(const Particles&)>& visit) {
    ParticleSelector selector(input, path.string());
    selector.check(Checks::positions);
    readChosen(path, input, true, selector, [&](FileContents&& points, std::uint64_t) {
        Particles particles;
        particles.position = std::move(points.position);
        particles.attributes = std::move(points.attributes);
        toWorld(input, particles.position);
        toWorld(input, particles);
        visit(particles);
    });
}

std::uint64_t rowInFile(const std::filesystem::path& path, const ParticleInput& input, std::uint64_t chosen_row) {
    struct Found {
        std::uint64_t row;
    };
    ParticleSelector selector(input, path.string());
    if (!selector.mayLeaveOut()) return chosen_row;
    std::uint64_t row = 0, chosen = 0;  // in the file and among the chosen ones, of the next block
    ReadOptions options = readOptions(input);
    options.needs = [&](const std::string& attribute) { return selector.needs(attribute); };
    options.points = [&](FileContents&& points, std::uint64_t) {
        Attribute rows{"", 1, {}, std::vector<std::int32_t>(points.position.size())};
        std::iota(rows.integer.begin(), rows.integer.end(), 0);
        points.attributes.push_back(std::move(rows));
        const std::uint64_t first = std::exchange(row, row + points.position.size());
        selector.choose(points);
        const std::uint64_t before = std::exchange(chosen, chosen + points.position.size());
        if (chosen_row < chosen)
            throw Found{first + static_cast<std::uint64_t>(points.attributes.back().integer[chosen_row - before])};
    };
    try {
        readPoints(path, options);
    } catch (const Found& found) {
        return found.row;
    }
    return chosen_row;  // the file has changed
}

std::string withRowInFile(const ParticleError& error, const std::filesystem::path& path, const ParticleInput& input) {
    try {
        return "particle " + std::to_string(rowInFile(path, input, error.row())) + ' ' + error.fault();
    } catch (const Error&) {  // the file can no longer be read
        return error.what();
    }
}

bool hasDoublePositions(const std::filesystem::path& path, std::optional<double> frame) {
    struct Known {};
    bool has_doubles = false;
    ReadOptions options;
    options.frame = frame;
    options.attributes = false;
    options.points = [&](FileContents&& points, std::uint64_t) {
        has_doubles = points.has_double_positions;
        throw Known();
    };
    try {
        readPoints(path, options);
    } catch (const Known&) {
    }
    return has_doubles;
}

std::optional<std::vector<Attribute>> attributesWithoutRows(const std::filesystem::path& path,
                                                            const ParticleInput& input) {
    struct Known {};
    FileContents first;
    ReadOptions options = readOptions(input);
    options.points = [&](FileContents&& points, std::uint64_t) {
        if (points.position.empty()) return;
        keepRows({0}, points);
        first = std::move(points);
        throw Known();
    };
    try {
        readPoints(path, options);
        return std::nullopt;
    } catch (const Known&) {
    }
    ParticleInput as_it_is;
    as_it_is.velocity = input.velocity;
    as_it_is.frame = input.frame;
    std::vector<Attribute> attributes = particlesFrom(std::move(first), as_it_is, path.string()).attributes;
    for (Attribute& a : attributes) a = {a.name, a.components, {}, {}, a.integer_type, a.hasIntegers()};
    return attributes;
}

std::optional<Vec3> localOriginOf(const std::filesystem::path& path, std::optional<double> frame) {
    if (!hasDoublePositions(path, frame)) return Vec3(0, 0, 0);
    ParticleInput input;
    input.frame = frame;
    input.on_bad_particle = OnBadParticle::drop;
    Box box;
    std::size_t particles = 0;
    visitPositions(path, input, [&](std::span<const Vec3f> positions) {
        for (const Vec3f& p : positions) box.extendBy(Vec3(p));
        particles += positions.size();
    });
    if (particles == 0) return std::nullopt;
    return localOrigin(box, particles);
}

std::vector<double> sampleTimes(const std::filesystem::path& path, const ParticleInput& input, FileKind kind) {
    const FileFormat& format = formatOf(path, FileKind::particles, Access::read);
    if (format.sampleTimes == nullptr) return {};
    ReadOptions options = readOptions(input);
    options.faces = kind != FileKind::particles;
    return format.sampleTimes(path, options);
}

void writeParticles(const std::filesystem::path& path, const Particles& particles, const WriteOptions& options) {
    const FileFormat& format = formatOf(path, FileKind::particles, Access::write);
    writeEncoded(path, [&](ByteWriter& out) {
        writeWithNames(format, FileKind::particles, particles,
                       [&](const Particles& named) { format.write_particles(out, named, path.string(), options); });
    });
}

void requireParticleExtension(const std::filesystem::path& path) { formatOf(path, FileKind::particles, Access::write); }

}  // namespace betamesh
