
#include "io/bgeo.h"

#include "io/gzip.h"

#include <algorithm>
#include <limits>

namespace betamesh {

namespace {

// Layout. Everything is big-endian:
//   header      "Bgeo" 'V', then nine int32: version, number of points, primitives, point groups, primitive groups,
//               point, vertex, primitive and detail attributes
//   attribute   uint16 length and name, uint16 size, int32 type; then the defaults (`size` times 4 bytes) or, for an
//               indexed string, its table: int32 count, then uint16 length and characters of each string
//   point       x y z w as float, then its attributes
//   primitive   int32 key; or kRun, uint16 count and int32 key for a run of primitives with the same key. Then, for
//               each primitive, the data that the key defines and its attributes. Polygon: int32 corners, '<' closed
//               or ':' open, corners. Particle system: int32 corners, corners. Corner: point index and vertex
//               attributes.
//   afterwards  detail attributes, groups, 00 ff: not read
enum class Type : std::int32_t { real = 0, integer = 1, string = 4, vector = 5 };

constexpr std::int32_t kVersion = 5;
constexpr std::uint32_t kRun = 0xffffffff;
constexpr std::uint32_t kPolygon = 0x00000001;
constexpr std::uint32_t kParticleSystem = 0x00008000;
constexpr std::size_t kMaxRun = 65535;           ///< primitives
constexpr std::size_t kLongIndexPoints = 65536;  ///< point indices are uint16 in files with fewer points, else int32

struct Declaration {
    std::string name;
    std::uint32_t size = 0;  ///< numbers per row, 4 bytes each
    Type type = Type::real;
};

struct Header {
    std::uint32_t points, primitives, point_groups, point_attributes, vertex_attributes, primitive_attributes;
};

std::uint32_t readCount(Cursor& in, const char* what) {
    const auto count = in.big<std::int32_t>(what);
    if (count < 0) in.fail(std::string(what) + " is " + std::to_string(count) + ", but cannot be negative");
    return static_cast<std::uint32_t>(count);
}

std::string readString(Cursor& in, const char* what) {
    const auto length = in.big<std::uint16_t>(what);
    return {reinterpret_cast<const char*>(in.take(length, what)), length};
}

Header readHeader(Cursor& in) {
    if (!in.peek(5).starts_with("BgeoV")) in.fail("not geometry of Houdini, whose classic format begins with 'BgeoV'");
    in.take(5, "magic");
    const auto version = in.big<std::int32_t>("version");
    if (version != kVersion)
        in.fail("version is " + std::to_string(version) + "; only version " + std::to_string(kVersion) +
                " can be read");
    Header header = {};
    header.points = readCount(in, "number of points");
    header.primitives = readCount(in, "number of primitives");
    header.point_groups = readCount(in, "number of point groups");
    readCount(in, "number of primitive groups");
    header.point_attributes = readCount(in, "number of point attributes");
    header.vertex_attributes = readCount(in, "number of vertex attributes");
    header.primitive_attributes = readCount(in, "number of primitive attributes");
    readCount(in, "number of detail attributes");
    return header;
}

Declaration readDeclaration(Cursor& in) {
    Declaration d;
    d.name = readString(in, "attribute name");
    d.size = in.big<std::uint16_t>("attribute size");
    const auto type = in.big<std::int32_t>("attribute type");
    d.type = static_cast<Type>(type);
    switch (d.type) {
        case Type::real:
        case Type::integer:
        case Type::vector:
            in.take(std::size_t{4} * d.size, "attribute default");
            return d;
        case Type::string: {
            const std::uint32_t strings = readCount(in, "number of strings");
            for (std::uint32_t i = 0; i < strings; ++i) readString(in, "string of an attribute");
            return d;
        }
    }
    in.fail("attribute '" + d.name + "' has the unknown type " + std::to_string(type) +
            ". Known types are 0 (float), 1 (int), 4 (string) and 5 (vector).");
}

std::vector<Declaration> readDeclarations(Cursor& in, std::uint32_t count) {
    std::vector<Declaration> declarations;
    for (std::uint32_t i = 0; i < count; ++i) declarations.push_back(readDeclaration(in));
    return declarations;
}

std::size_t rowBytes(const std::vector<Declaration>& declarations) {
    std::size_t bytes = 0;
    for (const Declaration& d : declarations) bytes += std::size_t{4} * d.size;
    return bytes;
}

/// Extracts one attribute from interleaved rows. first: its bytes in the first row.
template <typename T>
std::vector<T> readColumn(const std::byte* first, std::size_t rows, std::size_t row_bytes, std::uint32_t size) {
    std::vector<T> column(rows * size);
    T* to = column.data();
    for (std::size_t i = 0; i < rows; ++i)
        for (std::uint32_t c = 0; c < size; ++c) *to++ = loadBig<T>(first + i * row_bytes + std::size_t{4} * c);
    return column;
}

/// Decodes interleaved rows of points.
FileContents pointsFrom(const std::byte* first, std::size_t n, std::size_t row,
                        const std::vector<Declaration>& declarations, const ReadOptions& options) {
    FileContents points;
    points.position.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::byte* p = first + i * row;
        points.position[i] = {loadBig<float>(p), loadBig<float>(p + 4), loadBig<float>(p + 8)};
    }
    subtractOrigin(options.origin, points.position);
    bool has_id = false;
    std::size_t at = 16;
    for (const Declaration& d : declarations) {
        const std::byte* column = first + at;
        at += std::size_t{4} * d.size;
        if (d.type == Type::string || d.size == 0 || !options.attributes) continue;
        if (d.type == Type::integer && d.size == 1 && d.name == options.id && !has_id) {
            // An id of 2^31 or more was written as the signed number with the same bits.
            const auto ids = readColumn<std::uint32_t>(column, n, row, 1);
            points.id.assign(ids.begin(), ids.end());
            has_id = true;
            continue;
        }
        Attribute a;
        a.name = d.name;
        a.components = d.size;
        if (d.type == Type::integer)
            a.integer = readColumn<std::int32_t>(column, n, row, d.size);
        else
            a.real = readColumn<float>(column, n, row, d.size);
        points.attributes.push_back(std::move(a));
    }
    return points;
}

class PrimitiveReader {
public:
    PrimitiveReader(Cursor& in, const Header& header, const ReadOptions& options, FileContents& contents)
        : in_(in), options_(options), contents_(contents), points_(header.points), primitives_(header.primitives) {
        const auto vertex = readDeclarations(in, header.vertex_attributes);
        for (const Declaration& d : readDeclarations(in, header.primitive_attributes)) {
            if (options.faces && d.name == kComponent && d.type == Type::integer && d.size == 1) {
                component_at_ = primitive_bytes_;
                contents.component.emplace();
            }
            primitive_bytes_ += std::size_t{4} * d.size;
        }
        corner_bytes_ = (points_ < kLongIndexPoints ? 2 : 4) + rowBytes(vertex);
    }

    void readAll() {
        for (std::uint32_t done = 0; done < primitives_;) {
            auto key = in_.big<std::uint32_t>("primitive");
            std::uint32_t count = 1;
            if (key == kRun) {
                count = in_.big<std::uint16_t>("length of a run of primitives");
                key = in_.big<std::uint32_t>("primitive");
                if (count == 0 || count > primitives_ - done)
                    in_.fail("a run has " + std::to_string(count) + " primitives; there must be 1 to " +
                             std::to_string(primitives_ - done));
            }
            if (key != kPolygon && key != kParticleSystem) {
                if (options_.skip_unknown_faces || !options_.faces) return;
                in_.fail(
                    "a primitive has type " + std::to_string(key) +
                    ". Only polygons (1) and particle systems (32768) can be read; convert the geometry to polygons.");
            }
            for (std::uint32_t i = 0; i < count; ++i) readOne(key);
            done += count;
        }
    }

private:
    void readOne(std::uint32_t key) {
        const std::uint32_t size = readCount(in_, "number of corners");
        if (key == kParticleSystem) {
            in_.requireRows(size, corner_bytes_, "corners of a particle system");
            in_.skip(size * corner_bytes_, "corners of a particle system");
        } else {
            readPolygon(size);
        }
        const std::byte* attributes = in_.take(primitive_bytes_, "primitive attributes");
        if (contents_.component)
            contents_.component->resize(contents_.triangles.size(), loadBig<std::int32_t>(attributes + component_at_));
    }

    void readPolygon(std::uint32_t size) {
        const char closed = in_.big<char>("closed flag of a polygon");
        if (options_.faces && closed != '<' && closed != ':')
            in_.fail("a polygon must be closed ('<') or open (':'), but its flag is " + std::to_string(int{closed}));
        in_.requireRows(size, corner_bytes_, "corners of a polygon");
        const std::byte* corners = in_.take(size * corner_bytes_, "corners of a polygon");
        if (!options_.faces) {
            contents_.unread_polygons += closed == '<';
            return;
        }
        polygon_.resize(size);
        for (std::size_t i = 0; i < size; ++i) {
            polygon_[i] = cornerAt(corners + i * corner_bytes_);
            if (polygon_[i] >= points_)
                in_.fail("a polygon has corner " + std::to_string(polygon_[i]) + ", but there are only " +
                         std::to_string(points_) + " points");
        }
        if (closed == '<') {
            // Houdini's polygons are clockwise seen from outside, ours counter-clockwise.
            if (size > 1) std::reverse(polygon_.begin() + 1, polygon_.end());
            appendFan(polygon_, contents_.triangles);
            contents_.declares_faces = true;
        } else {
            for (std::size_t i = 1; i < size; ++i) contents_.edges.push_back({polygon_[i - 1], polygon_[i]});
            contents_.declares_edges = true;
        }
    }

    std::uint32_t cornerAt(const std::byte* bytes) const {
        if (points_ < kLongIndexPoints) return loadBig<std::uint16_t>(bytes);
        return loadBig<std::uint32_t>(bytes);
    }

    Cursor& in_;
    const ReadOptions& options_;
    FileContents& contents_;
    std::uint32_t points_;
    std::uint32_t primitives_;
    std::size_t corner_bytes_ = 0;
    std::size_t primitive_bytes_ = 0;
    std::size_t component_at_ = 0;  // byte offset among a primitive's attributes
    std::vector<std::uint32_t> polygon_;
};

std::string typeName(Type type) {
    switch (type) {
        case Type::real:
            return "float";
        case Type::integer:
            return "int";
        case Type::string:
            return "string";
        case Type::vector:
            return "vector";
    }
    return "unknown";
}

// Writing.

void writeHeader(ByteWriter& out, std::size_t points, std::size_t primitives, std::size_t attributes,
                 std::size_t primitive_attributes, const std::string& file) {
    constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
    if (points > kMax || primitives > kMax)
        throw Error(file + ": " + std::to_string(points) + " points and " + std::to_string(primitives) +
                    " polygons are too many for a .bgeo file, which can store " + std::to_string(kMax) +
                    " of each. Use .ply.");
    out.text("BgeoV");
    out.big(kVersion);
    for (const std::size_t count : {points, primitives, std::size_t{0}, std::size_t{0}, attributes, std::size_t{0},
                                    primitive_attributes, std::size_t{0}})
        out.big(static_cast<std::int32_t>(count));
}

void writeDeclaration(ByteWriter& out, std::string_view name, std::uint32_t size, Type type) {
    out.big(static_cast<std::uint16_t>(name.size()));
    out.text(name);
    out.big(static_cast<std::uint16_t>(size));
    out.big(static_cast<std::int32_t>(type));
    for (std::uint32_t i = 0; i < size; ++i) out.big(std::int32_t{0});
}

void writeDeclarations(ByteWriter& out, const std::vector<Attribute>& attributes) {
    for (const Attribute& a : attributes)
        writeDeclaration(out, a.name, a.components, a.hasIntegers() ? Type::integer : Type::real);
}

template <typename Vector>
void writeVector(ByteWriter& out, const Vector& v) {
    out.big(static_cast<float>(v.x));
    out.big(static_cast<float>(v.y));
    out.big(static_cast<float>(v.z));
}

template <typename Vector>
void writePosition(ByteWriter& out, const Vector& p) {
    writeVector(out, p);
    out.big(1.0F);
}

void writeAttributeRow(ByteWriter& out, const std::vector<Attribute>& attributes, std::size_t row) {
    for (const Attribute& a : attributes)
        for (std::size_t i = row * a.components; i < (row + 1) * a.components; ++i) {
            if (a.integer.empty())
                out.big(a.real[i]);
            else
                out.big(a.integer[i]);
        }
}

void writeEnd(ByteWriter& out) {
    out.big(std::uint16_t{0x00ff});
    out.flush();
}

template <typename Index>
void writeTriangles(ByteWriter& out, const Mesh& mesh) {
    const std::vector<Triangle>& triangles = mesh.triangles;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % kMaxRun == 0) {
            out.big(kRun);
            out.big(static_cast<std::uint16_t>(std::min(kMaxRun, triangles.size() - i)));
            out.big(kPolygon);
        }
        out.big(std::int32_t{3});
        out.text("<");
        const Triangle& t = triangles[i];  // clockwise: see readPolygon
        for (const std::uint32_t corner : {t[0], t[2], t[1]}) out.big(static_cast<Index>(corner));
        if (mesh.component) out.big((*mesh.component)[i]);
    }
}

template <typename Index>
void writeLines(ByteWriter& out, const std::vector<std::span<const Edge>>& lines) {
    for (const std::span<const Edge> line : lines) {
        out.big(kPolygon);
        out.big(static_cast<std::int32_t>(line.size() + 1));
        out.text(":");
        out.big(static_cast<Index>(line.front()[0]));
        for (const Edge& edge : line) out.big(static_cast<Index>(edge[1]));
    }
}

/// Writes the points of a mesh or of curves.
template <typename Surface>
void writePoints(ByteWriter& out, const Surface& surface) {
    writeDeclaration(out, "v", 3, Type::vector);
    writeDeclarations(out, surface.attributes);
    for (std::size_t i = 0; i < surface.position.size(); ++i) {
        writePosition(out, surface.position[i]);
        writeVector(out, surface.velocity.empty() ? Vec3(0, 0, 0) : surface.velocity[i]);
        writeAttributeRow(out, surface.attributes, i);
    }
}

FileContents parseUncompressed(Cursor& in, const ReadOptions& options) {
    const Header header = readHeader(in);
    FileContents contents;
    contents.format = "bgeo V5";
    contents.declared.push_back({"P", "float", 4, {}});
    const auto declarations = readDeclarations(in, header.point_attributes);
    for (const Declaration& d : declarations) contents.declared.push_back({d.name, typeName(d.type), d.size, {}});
    if (header.point_groups > 0)
        contents.passed_over.push_back(std::to_string(header.point_groups) + " point groups of the classic format");
    const std::size_t row_bytes = 16 + rowBytes(declarations);
    const auto decode = [&](const std::byte* first, std::size_t rows) {
        return pointsFrom(first, rows, row_bytes, declarations, options);
    };
    deliverRows(in, header.points, row_bytes, decode, options, contents);
    PrimitiveReader(in, header, options, contents).readAll();
    return contents;
}

}  // namespace

FileContents parseBgeo(Cursor in, const ReadOptions& options) {
    if (!isGzip(in)) return parseUncompressed(in, options);
    Cursor unpacked = gunzipped(std::move(in));
    if (isGzip(unpacked))
        throw Error(unpacked.file() + ": is compressed with gzip twice. Decompress it once with gunzip.");
    FileContents contents = parseUncompressed(unpacked, options);
    contents.format += ", gzip";
    while (!unpacked.peek(1).empty())
        unpacked.take(unpacked.peek(1).size(), "gzip");  // to verify the checksum, which comes last
    return contents;
}

void encodeBgeo(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    const bool has_velocity = !particles.velocity.empty() || n == 0;
    const bool has_id = !particles.id.empty() || n == 0;
    requireWritable(particles, file);
    requireWritable(particles.attributes, n, {"P", "v", "id"}, file);
    writeHeader(out, n, 0, particles.attributes.size() + has_velocity + has_id, 0, file);
    if (has_velocity) writeDeclaration(out, "v", 3, Type::vector);
    if (has_id) writeDeclaration(out, "id", 1, Type::integer);
    writeDeclarations(out, particles.attributes);
    for (std::size_t i = 0; i < n; ++i) {
        writePosition(out, particles.position[i]);
        if (has_velocity) writeVector(out, particles.velocity[i]);
        if (has_id) out.big(idOf32Bits(particles.id, i, file));
        writeAttributeRow(out, particles.attributes, i);
    }
    writeEnd(out);
}

void encodeBgeo(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    const std::size_t n = mesh.position.size();
    requireWritable(mesh, file);
    requireWritable(mesh.attributes, n, {"P", "v"}, file);
    writeHeader(out, n, mesh.triangles.size(), mesh.attributes.size() + 1, mesh.component.has_value(), file);
    writePoints(out, mesh);
    if (mesh.component) writeDeclaration(out, kComponent, 1, Type::integer);
    if (n < kLongIndexPoints)
        writeTriangles<std::uint16_t>(out, mesh);
    else
        writeTriangles<std::uint32_t>(out, mesh);
    writeEnd(out);
}

void encodeBgeo(ByteWriter& out, const Curves& curves, const std::string& file) {
    const std::size_t n = curves.position.size();
    const auto lines = linesOf(curves);
    requireWritable(curves, file);
    requireWritable(curves.attributes, n, {"P", "v"}, file);
    writeHeader(out, n, lines.size(), curves.attributes.size() + 1, 0, file);
    writePoints(out, curves);
    if (n < kLongIndexPoints)
        writeLines<std::uint16_t>(out, lines);
    else
        writeLines<std::uint32_t>(out, lines);
    writeEnd(out);
}

}  // namespace betamesh
