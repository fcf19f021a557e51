
#include "io/file_contents.h"

#include "base/parallel.h"
#include "betamesh/error.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kRowsAtOnce = std::size_t{1} << 12;

std::vector<Vec3f> rowsOf(const std::vector<float>& numbers) {
    std::vector<Vec3f> rows;
    firstTouchResize(rows, numbers.size() / 3);
    parallelFor(rows.size(), kRowsAtOnce, [&](std::size_t i) {
        rows[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    });
    return rows;
}

/// Removes the velocity from the attributes and returns it. requested: its names; empty: the usual ones.
std::vector<Vec3f> takeVelocity(FileContents& contents, const std::string& requested, const std::string& file) {
    std::vector<Attribute>& attributes = contents.attributes;
    const std::size_t n = contents.position.size();
    const auto source = findVelocity(attributes, n, requested, attributeNames(contents), file);
    if (!source) return {};
    std::vector<Vec3f> velocity;
    if (source->is_whole_attribute) {
        velocity = rowsOf(attributes[source->xyz[0].attribute].real);
    } else {
        firstTouchResize(velocity, n);
        for (int axis = 0; axis < 3; ++axis) {
            const auto [index, component] = source->xyz[static_cast<std::size_t>(axis)];
            const Attribute& a = attributes[index];
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t at = i * a.components + component;
                velocity[i][axis] = a.real.empty() ? static_cast<float>(a.integer[at]) : a.real[at];
            }
        }
    }
    std::vector<std::size_t> used;
    for (const auto& [index, component] : source->xyz)
        if (attributes[index].components == 1 || source->is_whole_attribute) used.push_back(index);
    std::sort(used.begin(), used.end(), std::greater<>());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::size_t index : used) attributes.erase(attributes.begin() + static_cast<std::ptrdiff_t>(index));
    return velocity;
}

/// Whether files can store the vector, whose numbers are 32-bit floats there.
template <typename Vector>
bool fitsFloats(const Vector& v) {
    constexpr auto kMost = std::numeric_limits<float>::max();
    return std::abs(v.x) <= kMost && std::abs(v.y) <= kMost && std::abs(v.z) <= kMost;
}

/// The velocity of a mesh or of curves, removed from the attributes.
std::vector<Vec3f> takeVertexVelocity(FileContents& contents) {
    const std::size_t n = contents.position.size();
    for (const char* name : {"v", "velocity", "vel"}) {
        const auto found = std::find_if(contents.attributes.begin(), contents.attributes.end(), [&](const auto& a) {
            return a.name == name && a.components == 3 && a.real.size() == 3 * n;
        });
        if (n == 0 || found == contents.attributes.end()) continue;
        std::vector<Vec3f> velocity = rowsOf(found->real);
        contents.attributes.erase(found);
        return velocity;
    }
    return {};
}

template <typename Vector>
void requireFiniteVertices(const std::vector<Vector>& rows, const char* what, const std::string& file) {
    const std::size_t i = firstIndexWhere(rows.size(), [&](std::size_t row) { return !fitsFloats(rows[row]); });
    if (i < rows.size())
        throw Error(
            file + ": vertex " + std::to_string(i) + ": " + what + " is (" + std::to_string(rows[i].x) + ", " +
            std::to_string(rows[i].y) + ", " + std::to_string(rows[i].z) + "), which is " +
            (isFinite(rows[i]) ? "beyond the range of the 32-bit floats that files store (3.4e38)" : "not finite"));
}

/// Moves points and attributes into a mesh or curves.
template <typename Surface>
void moveVertices(FileContents& contents, Surface& surface) {
    for (const Vec3f& v : takeVertexVelocity(contents)) surface.velocity.emplace_back(v);
    surface.position.reserve(contents.position.size());
    for (const Vec3f& p : contents.position) surface.position.emplace_back(p);
    surface.attributes = std::move(contents.attributes);
}

template <typename Surface>
void requireWritableVertices(const Surface& surface, const std::string& file) {
    const std::size_t n = surface.position.size();
    if (!surface.velocity.empty() && surface.velocity.size() != n)
        throw Error(file + ": velocity has " + std::to_string(surface.velocity.size()) + " rows, but there are " +
                    std::to_string(n) + " vertices");
    requireFiniteVertices(surface.position, "position", file);
    requireFiniteVertices(surface.velocity, "velocity", file);
}

template <typename Corners>
void requireCorners(const std::vector<Corners>& rows, const char* what, std::size_t n, const std::string& file) {
    const auto lastCorner = [&](std::size_t i) { return *std::max_element(rows[i].begin(), rows[i].end()); };
    const std::size_t i = firstIndexWhere(rows.size(), [&](std::size_t row) { return lastCorner(row) >= n; });
    if (i < rows.size())
        throw Error(file + ": " + what + " " + std::to_string(i) + " has vertex " + std::to_string(lastCorner(i)) +
                    ", but there are only " + std::to_string(n) + " vertices");
}

/// Appends numbers. total: number of them in the end; it may be damaged, so that memory is reserved for at most twice
/// the numbers that are there.
template <typename T>
void appendNumbers(std::vector<T>&& more, std::uint64_t total, std::vector<T>& numbers) {
    if (numbers.capacity() == 0 && more.size() >= total) {
        numbers = std::move(more);
        return;
    }
    const std::size_t wanted = numbers.size() + more.size();
    if (numbers.capacity() < wanted)
        firstTouchReserve(numbers, std::max<std::size_t>(wanted, static_cast<std::size_t>(std::min<std::uint64_t>(
                                                                     total, 2 * std::uint64_t{wanted}))));
    numbers.insert(numbers.end(), more.begin(), more.end());
}

/// Converts an integer attribute to floats.
void makeReal(Attribute& a) {
    a.real.insert(a.real.end(), a.integer.begin(), a.integer.end());
    a.integer.clear();
}

void appendAttribute(Attribute&& more, std::uint64_t total, Attribute& attribute) {
    if (!attribute.real.empty() && !more.integer.empty()) makeReal(more);
    if (!attribute.integer.empty() && !more.real.empty()) makeReal(attribute);
    appendNumbers(std::move(more.real), total * attribute.components, attribute.real);
    appendNumbers(std::move(more.integer), total * attribute.components, attribute.integer);
}

template <typename T>
void keepRowsOf(const std::vector<std::uint32_t>& rows, std::size_t components, std::vector<T>& numbers) {
    if (numbers.empty()) return;
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t c = 0; c < components; ++c) numbers[i * components + c] = numbers[rows[i] * components + c];
    numbers.resize(rows.size() * components);
}

}  // namespace

void append(FileContents&& points, std::uint64_t total, FileContents& contents) {
    if (!std::exchange(contents.begun, true)) {
        for (const Attribute& a : points.attributes)
            contents.attributes.push_back({a.name, a.components, {}, {}, a.integer_type, a.hasIntegers()});
    }
    const auto matching = [&](const Attribute& a) {
        return std::find_if(points.attributes.begin(), points.attributes.end(),
                            [&](const Attribute& b) { return a.name == b.name && a.components == b.components; });
    };
    std::erase_if(contents.attributes, [&](const Attribute& a) { return matching(a) == points.attributes.end(); });
    for (Attribute& a : contents.attributes) appendAttribute(std::move(*matching(a)), total, a);
    if (contents.id.size() == contents.position.size() && points.id.size() == points.position.size())
        appendNumbers(std::move(points.id), total, contents.id);
    else
        contents.id = {};
    for (LostNumber& lost : points.lost_numbers) {
        lost.particle += contents.position.size();
        noteLost(std::move(lost), contents.lost_numbers);
    }
    appendNumbers(std::move(points.position), total, contents.position);
}

void noteLost(LostNumber&& lost, std::vector<LostNumber>& numbers) {
    if (std::ranges::find(numbers, lost.attribute, &LostNumber::attribute) == numbers.end())
        numbers.push_back(std::move(lost));
}

void deliver(FileContents&& points, std::uint64_t total, const ReadOptions& options, FileContents& contents) {
    if (options.points)
        options.points(std::move(points), total);
    else
        append(std::move(points), total, contents);
}

void deliverRows(Cursor& in, std::uint64_t total, std::size_t row_bytes,
                 const std::function<FileContents(const std::byte* rows, std::size_t count)>& decode,
                 const ReadOptions& options, FileContents& contents) {
    in.requireRows(total, row_bytes, "points");
    std::uint64_t taken = 0;
    const auto take = [&]() -> std::optional<Bytes> {
        const std::uint64_t rows = std::min<std::uint64_t>(kRowsAtOnce, total - taken);
        if (rows == 0) return std::nullopt;
        taken += rows;
        const std::byte* first = in.take(static_cast<std::size_t>(rows) * row_bytes, "points");
        return Bytes(first, first + rows * row_bytes);
    };
    if (total == 0) return deliver(decode(nullptr, 0), total, options, contents);  // declares the attributes
    parallelInOrder(
        take, [&](Bytes&& rows) { return decode(rows.data(), rows.size() / row_bytes); },
        [&](FileContents&& points) { deliver(std::move(points), total, options, contents); });
}

void keepRows(const std::vector<std::uint32_t>& rows, FileContents& points) {
    keepRowsOf(rows, 1, points.position);
    keepRowsOf(rows, 1, points.id);
    for (Attribute& a : points.attributes) {
        keepRowsOf(rows, a.components, a.real);
        keepRowsOf(rows, a.components, a.integer);
    }
}

Attribute integerAttribute(std::string name, std::uint32_t components, std::vector<std::int64_t> values) {
    Attribute a;
    a.name = std::move(name);
    a.components = components;
    if (haveSigned32Bits(values))
        std::transform(values.begin(), values.end(), std::back_inserter(a.integer),
                       [](auto v) { return static_cast<std::int32_t>(v); });
    else
        std::transform(values.begin(), values.end(), std::back_inserter(a.real),
                       [](auto v) { return static_cast<float>(v); });
    return a;
}

IntegerType writtenType(const Attribute& a) {
    const auto fits = [&]<typename T>(T) {
        return std::all_of(a.integer.begin(), a.integer.end(), [](std::int32_t x) {
            return x >= std::numeric_limits<T>::min() && x <= std::numeric_limits<T>::max();
        });
    };
    switch (a.integer_type) {
        case IntegerType::int8:
            return fits(std::int8_t{}) ? a.integer_type : IntegerType::int32;
        case IntegerType::uint8:
            return fits(std::uint8_t{}) ? a.integer_type : IntegerType::int32;
        case IntegerType::int16:
            return fits(std::int16_t{}) ? a.integer_type : IntegerType::int32;
        case IntegerType::uint16:
            return fits(std::uint16_t{}) ? a.integer_type : IntegerType::int32;
        case IntegerType::int32:
            break;
    }
    return IntegerType::int32;
}

void appendFan(const std::vector<std::uint32_t>& corners, std::vector<Triangle>& triangles) {
    for (std::size_t i = 2; i < corners.size(); ++i) triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

bool isPointGroup(const Attribute& a) {
    return a.name.starts_with(kGroupPrefix) && a.name.size() > kGroupPrefix.size() && a.components == 1 &&
           a.real.empty() && std::all_of(a.integer.begin(), a.integer.end(), [](auto n) { return n == 0 || n == 1; });
}

std::string unknownGroup(const std::string& wanted, const std::vector<std::string>& groups) {
    std::string names;
    for (const std::string& name : groups) names += (names.empty() ? "'" : ", '") + name + "'";
    return "has no point group '" + wanted + "'. " +
           (names.empty() ? "The file has no point groups." : "The point groups are " + names + ".");
}

void subtractOrigin(const Vec3& origin, std::vector<Vec3f>& positions) {
    if (origin == Vec3(0, 0, 0)) return;
    for (Vec3f& p : positions) p = Vec3f(Vec3(p) - origin);
}

std::string attributeNames(const FileContents& contents) {
    std::string names;
    const auto add = [&](const std::string& name) { names += (names.empty() ? "'" : ", '") + name + "'"; };
    for (const AttributeInfo& a : contents.declared) add(a.name);
    if (contents.declared.empty())
        for (const Attribute& a : contents.attributes) add(a.name);
    return names.empty() ? "no attributes" : names;
}

Particles particlesFrom(FileContents contents, const ParticleInput& input, const std::string& file) {
    Particles particles;
    particles.velocity = takeVelocity(contents, input.velocity, file);
    if (!input.id.empty() && contents.id.empty() && !contents.position.empty())
        throw Error(file + ": has no id attribute '" + input.id + "' with one integer per point. The file has " +
                    attributeNames(contents) + ".");
    particles.position = std::move(contents.position);
    particles.id = std::move(contents.id);
    particles.attributes = std::move(contents.attributes);
    toWorld(input, particles.position);
    toWorld(input, particles);
    try {
        validate(particles);
    } catch (const Error& error) {
        const auto isBad = [](const Vec3f& v) { return !isFinite(v); };
        std::string advice;
        for (const std::vector<Vec3f>* vectors : {&particles.position, &particles.velocity}) {
            const auto bad = std::find_if(vectors->begin(), vectors->end(), isBad);
            if (bad == vectors->end()) continue;
            advice = noteOnLost(contents.lost_numbers, static_cast<std::uint64_t>(bad - vectors->begin())) +
                     ". Use --on-bad-particle drop to leave such particles out.";
            break;
        }
        throw Error(file + ": " + error.what() + advice);
    }
    return particles;
}

Mesh uncheckedMeshFrom(FileContents contents) {
    Mesh mesh;
    moveVertices(contents, mesh);
    mesh.triangles = std::move(contents.triangles);
    mesh.component = std::move(contents.component);
    return mesh;
}

Mesh meshFrom(FileContents contents, const std::string& file) {
    Mesh mesh = uncheckedMeshFrom(std::move(contents));
    requireWritable(mesh, file);
    return mesh;
}

Curves uncheckedCurvesFrom(FileContents contents) {
    Curves curves;
    moveVertices(contents, curves);
    curves.edges = std::move(contents.edges);
    return curves;
}

Curves curvesFrom(FileContents contents, const std::string& file) {
    Curves curves = uncheckedCurvesFrom(std::move(contents));
    requireWritable(curves, file);
    return curves;
}

void requireWritable(const std::vector<Attribute>& attributes, std::size_t n, std::vector<std::string> reserved,
                     const std::string& file) {
    for (const Attribute& a : attributes) {
        const std::string where = file + ": attribute '" + a.name + "'";
        if (a.name.empty() || a.name.size() > 200 || a.name.find_first_of(" \t\r\n\v\f") != std::string::npos ||
            a.name.find('\0') != std::string::npos)
            throw Error(where + ": a name must have 1 to 200 characters and no white space");
        if (std::find(reserved.begin(), reserved.end(), a.name) != reserved.end())
            throw Error(where + ": this name is already in use. Rename the attribute.");
        if (!a.real.empty() && !a.integer.empty())
            throw Error(where + " has both floats and integers, but may only have one of them");
        if (a.components == 0 || a.components > 1000)
            throw Error(where + " has " + std::to_string(a.components) + " components, but must have 1 to 1000");
        const std::size_t numbers = std::max(a.real.size(), a.integer.size());
        if (numbers != n * a.components)
            throw Error(where + " has " + std::to_string(numbers) + " numbers, but needs " +
                        std::to_string(a.components) + " for each of " + std::to_string(n) + " points");
        reserved.push_back(a.name);
    }
}

std::vector<std::string> distinctNames(const std::vector<std::string>& names, std::vector<std::string> wanted,
                                       std::set<std::string> taken) {
    std::vector<bool> is_kept;
    for (std::size_t i = 0; i < names.size(); ++i)
        is_kept.push_back(wanted[i] == names[i] && taken.insert(names[i]).second);
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string stem = wanted[i];
        for (int k = 2; !is_kept[i] && !taken.insert(wanted[i]).second; ++k) wanted[i] = stem + '_' + std::to_string(k);
    }
    return wanted;
}

bool haveSigned32Bits(const std::vector<std::int64_t>& numbers) {
    using Limits = std::numeric_limits<std::int32_t>;
    return std::ranges::all_of(numbers, [](auto n) { return n >= Limits::min() && n <= Limits::max(); });
}

bool haveSigned32Bits(const std::vector<std::uint64_t>& ids) {
    return std::all_of(ids.begin(), ids.end(), [](std::uint64_t id) {
        return static_cast<std::int64_t>(id) == static_cast<std::int32_t>(static_cast<std::uint32_t>(id));
    });
}

std::uint32_t idOf32Bits(const std::vector<std::uint64_t>& ids, std::size_t i, const std::string& file) {
    constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
    if (ids[i] > kMax)
        throw Error(file + ": particle " + std::to_string(i) + ": id " +
                    (ids[i] >> 63 != 0 ? std::to_string(static_cast<std::int64_t>(ids[i])) + " is negative or"
                                       : std::to_string(ids[i])) +
                    " needs more than 32 bits, which this format cannot store. Use .vdb, which stores 64.");
    return static_cast<std::uint32_t>(ids[i]);
}

Particles particlesOf(const Spheres& spheres, const std::string& radius_name, const std::string& file) {
    const std::size_t n = spheres.size();
    if (spheres.radius.size() != n)
        throw Error(file + ": radius has " + std::to_string(spheres.radius.size()) + " rows, but there are " +
                    std::to_string(n) + " spheres");
    Particles particles;
    for (const Vec3& p : spheres.position) particles.position.emplace_back(p);
    for (const Vec3& v : spheres.velocity) particles.velocity.emplace_back(v);
    if (particles.velocity.empty()) particles.velocity.resize(n, Vec3f(0, 0, 0));
    particles.id = spheres.id;
    particles.attributes.push_back({radius_name, 1, spheres.radius, {}});
    for (const Attribute& a : spheres.attributes)
        if (a.name != radius_name) particles.attributes.push_back(a);
    return particles;
}

void requireWritable(const Particles& particles, const std::string& file) {
    try {
        validate(particles);
    } catch (const Error& error) {
        throw Error(file + ": " + error.what());
    }
}

void requireWritable(const Mesh& mesh, const std::string& file) {
    if (mesh.component && mesh.component->size() != mesh.triangles.size())
        throw Error(file + ": component has " + std::to_string(mesh.component->size()) + " rows, but there are " +
                    std::to_string(mesh.triangles.size()) + " triangles");
    requireWritableVertices(mesh, file);
    requireCorners(mesh.triangles, "triangle", mesh.position.size(), file);
}

void requireWritable(const Curves& curves, const std::string& file) {
    requireWritableVertices(curves, file);
    requireCorners(curves.edges, "edge", curves.position.size(), file);
}

}  // namespace betamesh
