// Reads the geometry of Alembic files.

#include "io/alembic.h"

#include "io/alembic_archive.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <set>
#include <system_error>
#include <utility>

namespace betamesh {

namespace {

template <typename From, typename To>
std::vector<To> convertedNumbers(const Bytes& bytes) {
    std::vector<To> numbers(bytes.size() / sizeof(From));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<To>(loadLittle<From>(bytes.data() + i * sizeof(From)));
    return numbers;
}

bool isInteger(AlembicType type) { return type <= AlembicType::int64; }
bool isReal(AlembicType type) { return type == AlembicType::float32 || type == AlembicType::float64; }

std::vector<float> realsOf(AlembicType type, const Bytes& bytes) {
    return type == AlembicType::float64 ? convertedNumbers<double, float>(bytes)
                                        : convertedNumbers<float, float>(bytes);
}

std::vector<std::int64_t> integersOf(AlembicType type, const Bytes& bytes) {
    switch (type) {
        case AlembicType::boolean:
        case AlembicType::uint8:
            return convertedNumbers<std::uint8_t, std::int64_t>(bytes);
        case AlembicType::int8:
            return convertedNumbers<std::int8_t, std::int64_t>(bytes);
        case AlembicType::uint16:
            return convertedNumbers<std::uint16_t, std::int64_t>(bytes);
        case AlembicType::int16:
            return convertedNumbers<std::int16_t, std::int64_t>(bytes);
        case AlembicType::uint32:
            return convertedNumbers<std::uint32_t, std::int64_t>(bytes);
        case AlembicType::int32:
            return convertedNumbers<std::int32_t, std::int64_t>(bytes);
        default:
            return convertedNumbers<std::int64_t, std::int64_t>(bytes);
    }
}

/// The type in which formats write the integers of an attribute again.
IntegerType integerTypeOf(AlembicType type) {
    switch (type) {
        case AlembicType::boolean:
        case AlembicType::uint8:
            return IntegerType::uint8;
        case AlembicType::int8:
            return IntegerType::int8;
        case AlembicType::uint16:
            return IntegerType::uint16;
        case AlembicType::int16:
            return IntegerType::int16;
        default:
            return IntegerType::int32;
    }
}

/// How vectors of a kind follow a transform.
enum class VectorKind { point, vector, normal };

std::array<double, 3> transformed(const std::array<double, 3>& v, VectorKind kind, const Matrix4& m) {
    std::array<double, 3> result{};
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
            // Normals: times the cofactors, the transposed inverse up to a factor.
            const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            result[j] += v[i] * (kind == VectorKind::normal ? m[a][c] * m[b][d] - m[a][d] * m[b][c] : m[i][j]);
        }
        if (kind == VectorKind::point) result[j] += m[3][j];
    }
    if (kind != VectorKind::normal) return result;
    const double length = std::hypot(result[0], result[1], result[2]);
    for (double& x : result) x = length > 0 ? x / length : 0;
    return result;
}

/// Whether a transform turns right hands into left ones.
bool isMirror(const Matrix4& m) {
    double determinant = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t c = (j + 1) % 3, d = (j + 2) % 3;
        determinant += m[0][j] * (m[1][c] * m[2][d] - m[1][d] * m[2][c]);
    }
    return determinant < 0;
}

std::string commaList(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
    return text;
}

/// Reads one object.
class GeometryReader {
public:
    GeometryReader(AlembicArchive& archive, const AlembicObject& object, const ReadOptions& options,
                   FileContents& contents)
        : archive_(archive), object_(object), options_(options), contents_(contents) {}

    void read() {
        std::vector<AlembicProperty> geometry, parameters;
        for (const AlembicProperty& p : archive_.properties(object_.properties))
            if (p.name == ".geom" && p.isCompound()) geometry = archive_.properties(p.content);
        const auto property = [&](const char* name) -> const AlembicProperty* {
            const auto found = std::find_if(geometry.begin(), geometry.end(),
                                            [&](const AlembicProperty& p) { return p.name == name; });
            return found == geometry.end() ? nullptr : &*found;
        };
        readPositions(property("P"));
        if (const AlembicProperty* ids = property(".pointIds")) readIds(*ids);
        if (options_.attributes) {
            if (const AlembicProperty* p = property(".velocities")) readAttribute(*p, "v", VectorKind::vector);
            for (const char* name : {"N", "uv"})
                if (const AlembicProperty* p = property(name)) readParameter(*p);
        }
        if (object_.schema == kMeshSchema && options_.faces)
            readFaces(property(".faceCounts"), property(".faceIndices"));
        if (const AlembicProperty* p = property(".faceCounts"); p != nullptr && !p->isCompound() && !options_.faces)
            contents_.unread_polygons += archive_.firstSample(*p).size() / bytesOf(p->type);
        if (const AlembicProperty* p = property(".arbGeomParams");
            p != nullptr && p->isCompound() && options_.attributes)
            parameters = archive_.properties(p->content);
        for (const AlembicProperty& p : parameters) readParameter(p);
        const bool has_radius = std::any_of(points_.attributes.begin(), points_.attributes.end(),
                                            [](const auto& a) { return a.name == "radius" || a.name == "pscale"; });
        const AlembicProperty* const widths = property(".widths");
        if (widths != nullptr && !has_radius && options_.attributes) readWidths(*widths);
        if (samples_ > 1 && !is_at_frame_)
            contents_.warnings.push_back(
                "object '" + object_.path + "' has " + std::to_string(samples_) + " time samples, of which " +
                (options_.frame ? "an earlier one" : "the first") + " is read and " + std::to_string(samples_ - 1) +
                " left out. Export a sequence of files with one frame each");
        if (samples_ > 1 && !options_.frame) contents_.format += ", first of " + std::to_string(samples_) + " samples";
        const std::size_t n = points_.position.size();
        deliver(std::move(points_), n, options_, contents_);
    }

private:
    std::string where(const std::string& name) const { return "object '" + object_.path + "': " + name; }

    Bytes sample(const AlembicProperty& p) {
        if (p.changes) samples_ = std::max(samples_, p.samples);
        if (!options_.frame) return archive_.firstSample(p);
        const std::uint32_t sample = archive_.sampleAt(p, *options_.frame);
        is_at_frame_ |= p.changes && archive_.timeOf(p, sample) == options_.frame;
        return archive_.sample(p, sample);
    }

    void declare(const std::string& name, AlembicType type, std::size_t components) {
        contents_.declared.push_back({name, nameOf(type), static_cast<std::uint32_t>(components), {}});
    }

    void passOver(const std::string& what) { contents_.passed_over.push_back(what); }

    void readPositions(const AlembicProperty* p) {
        if (p == nullptr || p->isCompound() || p->extent != 3 || !isReal(p->type))
            archive_.fail(where("the positions (P) are missing or not three floats per point"));
        declare("P", p->type, 3);
        const Bytes bytes = sample(*p);
        const bool doubles = p->type == AlembicType::float64;
        points_.has_double_positions = contents_.has_double_positions = doubles;
        points_.position.resize(bytes.size() / bytesOf(p->type) / 3);
        for (std::size_t i = 0; i < points_.position.size(); ++i) {
            std::array<double, 3> x;
            for (std::size_t k = 0; k < 3; ++k)
                x[k] = doubles ? loadLittle<double>(bytes.data() + (3 * i + k) * sizeof(double))
                               : loadLittle<float>(bytes.data() + (3 * i + k) * sizeof(float));
            if (object_.world) x = transformed(x, VectorKind::point, *object_.world);
            const Vec3& o = options_.origin;
            points_.position[i] =
                Vec3f(static_cast<float>(x[0] - o.x), static_cast<float>(x[1] - o.y), static_cast<float>(x[2] - o.z));
        }
    }

    void readIds(const AlembicProperty& p) {
        if (p.isCompound() || p.extent != 1 || p.type != AlembicType::uint64 || options_.id != "id") return;
        const std::vector<std::uint64_t> ids = convertedNumbers<std::uint64_t, std::uint64_t>(sample(p));
        if (ids.empty() && !points_.position.empty()) return;
        declare("id", p.type, 1);
        if (ids.size() == points_.position.size())
            points_.id = ids;
        else
            passOver("ids that are not one per point");
    }

    /// A parameter of the geometry: an array, or a compound of values and indices to them.
    void readParameter(const AlembicProperty& p) {
        constexpr std::size_t kMaxIndexed = 16;  // numbers per index: a few values could become very many
        const std::string scope = p.meta("geoScope"), kind = p.meta("interpretation");
        const bool is_component = p.name == kComponent && scope == "uni";
        if (is_component && !p.isCompound()) return readComponents(p);
        const VectorKind vector_kind = kind == "point"    ? VectorKind::point
                                       : kind == "normal" ? VectorKind::normal
                                                          : VectorKind::vector;
        if (scope != "vtx" && scope != "var" && !scope.empty()) return passOver("'" + p.name + "', not of points");
        if (!p.isCompound()) return readAttribute(p, p.name, vector_kind);
        const AlembicProperty* values = nullptr;
        const AlembicProperty* indices = nullptr;
        const std::vector<AlembicProperty> parts = archive_.properties(p.content);
        for (const AlembicProperty& part : parts) {
            if (part.name == ".vals" && !part.isCompound()) values = &part;
            if (part.name == ".indices" && part.type == AlembicType::uint32) indices = &part;
        }
        if (values == nullptr || indices == nullptr || indices->isCompound() || values->extent == 0 ||
            values->extent > kMaxIndexed || bytesOf(values->type) == 0)
            return passOver("'" + p.name + "' of an unknown kind");
        const Bytes rows = sample(*values);
        const std::vector<std::uint32_t> index = convertedNumbers<std::uint32_t, std::uint32_t>(sample(*indices));
        const std::size_t row_bytes = values->extent * bytesOf(values->type);
        if (index.size() != points_.position.size()) return passOver("'" + p.name + "', not one per point");
        Bytes all(index.size() * row_bytes);
        for (std::size_t i = 0; i < index.size(); ++i) {
            if (index[i] >= rows.size() / row_bytes)
                archive_.fail(where("index " + std::to_string(index[i]) + " of '" + p.name + "' has no value"));
            std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(index[i] * row_bytes), row_bytes,
                        all.begin() + static_cast<std::ptrdiff_t>(i * row_bytes));
        }
        addAttribute(p.name, *values, all, vector_kind);
    }

    /// Widths are diameters, one per point or one for all.
    void readWidths(const AlembicProperty& p) {
        if (p.isCompound() || !isReal(p.type)) return passOver("'.widths' of an unknown kind");
        const std::size_t n = points_.position.size();
        std::vector<float> radius = realsOf(p.type, sample(p));
        if (radius.size() == 1 && n > 1) radius.resize(n, radius[0]);
        if (radius.size() != n) return passOver("'.widths', not one per point");
        for (float& r : radius) r /= 2;
        declare("pscale", p.type, 1);
        if (n > 0) points_.attributes.push_back({"pscale", 1, std::move(radius), {}});
    }

    void readAttribute(const AlembicProperty& p, const std::string& name, VectorKind kind) {
        if (p.isCompound()) return passOver("'" + name + "' of an unknown kind");
        addAttribute(name, p, sample(p), kind);
    }

    /// An attribute of points from the bytes of its numbers.
    void addAttribute(const std::string& name, const AlembicProperty& p, const Bytes& bytes, VectorKind kind) {
        constexpr std::size_t kMaxComponents = 1000;
        const std::size_t n = points_.position.size();
        if (bytesOf(p.type) == 0) return declare(name, p.type, p.extent);
        if (!isReal(p.type) && !isInteger(p.type)) return passOver("'" + name + "' of type " + nameOf(p.type));
        const std::size_t numbers = bytes.size() / bytesOf(p.type);
        const std::size_t components = n == 0 ? std::max<std::size_t>(1, p.extent) : numbers / n;
        const bool is_known = std::any_of(points_.attributes.begin(), points_.attributes.end(),
                                          [&](const Attribute& a) { return a.name == name; });
        if (components == 0 || components > kMaxComponents || numbers != components * n || is_known || name.empty()) {
            if (numbers > 0) passOver("'" + name + "', not one per point");
            return;
        }
        declare(name, p.type, components);
        if (n == 0) return;
        if (isInteger(p.type)) {
            std::vector<std::int64_t> integers = integersOf(p.type, bytes);
            if (name == options_.id && components == 1) {
                points_.id.assign(integers.begin(), integers.end());
                return;
            }
            points_.attributes.push_back(
                integerAttribute(name, static_cast<std::uint32_t>(components), std::move(integers)));
            points_.attributes.back().integer_type = integerTypeOf(p.type);
            return;
        }
        points_.attributes.push_back({name, static_cast<std::uint32_t>(components), realsOf(p.type, bytes), {}});
        if (!object_.world || components != 3 || (name != "v" && p.meta("interpretation").empty())) return;
        if (p.meta("interpretation") == "rgb") return;
        std::vector<float>& x = points_.attributes.back().real;
        for (std::size_t i = 0; i < x.size(); i += 3) {
            const auto moved = transformed({x[i], x[i + 1], x[i + 2]}, kind, *object_.world);
            for (std::size_t k = 0; k < 3; ++k) x[i + k] = static_cast<float>(moved[k]);
        }
    }

    void readFaces(const AlembicProperty* counts, const AlembicProperty* indices) {
        contents_.declares_faces = true;
        for (const AlembicProperty* p : {counts, indices})
            if (p == nullptr || p->isCompound() || p->type != AlembicType::int32 || p->extent != 1)
                archive_.fail(where("the faces (.faceCounts, .faceIndices) are missing or not integers"));
        const std::vector<std::uint32_t> corners = convertedNumbers<std::int32_t, std::uint32_t>(sample(*indices));
        const std::size_t n = points_.position.size();
        const bool is_mirror = object_.world && isMirror(*object_.world);
        std::size_t begin = 0;
        std::vector<std::uint32_t> polygon;
        for (const std::uint32_t count : convertedNumbers<std::int32_t, std::uint32_t>(sample(*counts))) {
            if (count > corners.size() - begin)
                archive_.fail(where("the faces have more corners than there are indices"));
            polygon.assign(corners.begin() + static_cast<std::ptrdiff_t>(begin),
                           corners.begin() + static_cast<std::ptrdiff_t>(begin + count));
            begin += count;
            for (const std::uint32_t corner : polygon)
                if (corner >= n)
                    archive_.fail(where("a face has the vertex " + std::to_string(corner) + ", but there are only " +
                                        std::to_string(n)));
            if (!is_mirror && polygon.size() > 1) std::reverse(polygon.begin() + 1, polygon.end());
            appendFan(polygon, contents_.triangles);
            triangles_of_face_.push_back(count < 3 ? 0 : count - 2);
        }
        if (begin < corners.size()) archive_.fail(where("there are more indices than corners of faces"));
    }

    void readComponents(const AlembicProperty& p) {
        if (!options_.faces || object_.schema != kMeshSchema) return;
        const std::vector<std::int32_t> numbers = p.type == AlembicType::int32
                                                      ? convertedNumbers<std::int32_t, std::int32_t>(sample(p))
                                                      : std::vector<std::int32_t>{};
        if (numbers.size() != triangles_of_face_.size()) return passOver("'component', not an integer per face");
        std::vector<std::int32_t>& component = contents_.component.emplace();
        for (std::size_t i = 0; i < numbers.size(); ++i)
            component.insert(component.end(), triangles_of_face_[i], numbers[i]);
    }

    AlembicArchive& archive_;
    const AlembicObject& object_;
    const ReadOptions& options_;
    FileContents& contents_;
    FileContents points_;
    std::vector<std::uint32_t> triangles_of_face_;
    std::uint32_t samples_ = 1;
    bool is_at_frame_ = false;  // a sample is there for options.frame
};

/// Whether an object is called so: by its path, or the last name in it.
bool isNamed(const AlembicObject& object, const std::string& name) {
    return object.path == name || object.path.substr(object.path.rfind('/') + 1) == name;
}

/// The objects to read.
std::vector<const AlembicObject*> chosenObjects(const AlembicArchive& archive, const ReadOptions& options) {
    const auto ofSchema = [&](std::string_view schema) {
        std::vector<const AlembicObject*> objects;
        for (const AlembicObject& object : archive.objects())
            if (object.schema == schema) objects.push_back(&object);
        return objects;
    };
    std::vector<const AlembicObject*> objects = ofSchema(options.faces ? kMeshSchema : kPointsSchema);
    if (objects.empty()) objects = ofSchema(options.faces ? kPointsSchema : kMeshSchema);
    std::vector<std::string> all, candidates;
    for (const AlembicObject& object : archive.objects()) all.push_back(object.path);
    for (const AlembicObject* object : objects) candidates.push_back(object->path);
    if (objects.empty())
        archive.fail("contains neither points nor a polygon mesh (found " +
                     (all.empty() ? std::string("no objects") : commaList(all)) + ")");
    for (const std::string& wanted : options.grids)
        if (std::none_of(objects.begin(), objects.end(), [&](const auto* object) { return isNamed(*object, wanted); }))
            archive.fail("has no object '" + wanted + "' that can be read. There are " + commaList(candidates) + ".");
    if (!options.grids.empty())
        std::erase_if(objects, [&](const AlembicObject* object) {
            return std::none_of(options.grids.begin(), options.grids.end(),
                                [&](const std::string& wanted) { return isNamed(*object, wanted); });
        });
    else if (objects.size() > 1)
        archive.fail("contains several objects: " + commaList(candidates) +
                     (options.faces
                          ? ". Export each into a file of its own, or choose one with `betamesh convert --grid`."
                          : ". Choose some with --grid (input.grid)."));
    return objects;
}

FileContents readArchive(AlembicArchive archive, const ReadOptions& options) {
    FileContents contents;
    contents.format = "alembic ogawa";
    contents.units.frames_per_second = archive.framesPerSecond();
    const std::vector<const AlembicObject*> objects = chosenObjects(archive, options);
    for (const AlembicObject& object : archive.objects()) {
        const bool is_read = std::find(objects.begin(), objects.end(), &object) != objects.end();
        contents.grids.push_back({object.path, object.schema, is_read});
    }
    for (const AlembicObject* object : objects) GeometryReader(archive, *object, options, contents).read();
    return contents;
}

std::vector<double> sampleTimes(AlembicArchive archive, const ReadOptions& options) {
    constexpr std::uint64_t kMostSamples = 1'000'000;
    std::uint64_t samples = 0;
    std::set<double> times;
    for (const AlembicObject* object : chosenObjects(archive, options))
        for (const AlembicProperty& geometry : archive.properties(object->properties)) {
            if (geometry.name != ".geom" || !geometry.isCompound()) continue;
            for (const AlembicProperty& p : archive.properties(geometry.content))
                for (std::uint32_t sample = 0; p.changes && sample < p.samples; ++sample) {
                    const auto time = archive.timeOf(p, sample);
                    if (!time || !std::isfinite(*time) || ++samples > kMostSamples) return {};
                    times.insert(*time);
                }
        }
    return {times.begin(), times.end()};
}

template <typename Use>
auto withArchive(const std::filesystem::path& path, const Use& use) {
    requireRegularFile(path);
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) throw Error(path.string() + ": cannot be read: " + std::generic_category().message(errno));
    const auto size = static_cast<std::uint64_t>(in.tellg());
    const auto source = [&](std::uint64_t at, std::span<std::byte> to) {
        in.seekg(static_cast<std::streamoff>(at));
        if (!in.read(reinterpret_cast<char*>(to.data()), static_cast<std::streamsize>(to.size())))
            throw Error(path.string() + ": cannot be read to its end");
    };
    return use(AlembicArchive(OgawaReader(source, size, path.string())));
}

}  // namespace

FileContents parseAbc(std::span<const std::byte> bytes, const std::string& file, const ReadOptions& options) {
    const auto source = [bytes](std::uint64_t at, std::span<std::byte> to) {
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), to.size(), to.begin());
    };
    return readArchive(AlembicArchive(OgawaReader(source, bytes.size(), file)), options);
}

FileContents readAbc(const std::filesystem::path& path, const ReadOptions& options) {
    return withArchive(path, [&](AlembicArchive archive) { return readArchive(std::move(archive), options); });
}

std::vector<double> abcSampleTimes(const std::filesystem::path& path, const ReadOptions& options) {
    return withArchive(path, [&](AlembicArchive archive) { return sampleTimes(std::move(archive), options); });
}

}  // namespace betamesh
