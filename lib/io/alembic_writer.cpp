// Writes Alembic files.

#include "io/alembic.h"

#include "base/parallel.h"
#include "io/alembic_layout.h"
#include "io/digest.h"
#include "io/ogawa.h"
#include "mesh/normals.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace betamesh {

namespace {

using Write = OgawaWriter::Write;

constexpr std::int32_t kLayoutVersion = 0;
constexpr std::int32_t kLibraryVersion = 10800;  // of Alembic whose layout this is: 1.8.0
constexpr std::uint32_t kTimeOfFrame = 1;        // index of its time sampling

/// The bytes of numbers in a string.
template <typename... Numbers>
std::string packed(const Numbers&... numbers) {
    std::string text;
    ByteWriter out([&](std::span<const std::byte> piece) {
        text.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    });
    (out.little(numbers), ...);
    out.flush();
    return text;
}

std::string packed(const Digest& digest) { return packed(digest[0], digest[1]); }

/// What the rows of an array are.
struct RowType {
    AlembicType number;
    std::uint32_t extent;             ///< numbers per row
    std::string interpretation{};     ///< "vector", "rgb"; empty: plain numbers
    std::uint32_t rows_per_item = 1;  ///< for numbers of which no row type has so many
};

AlembicType typeOf(const Attribute& a) {
    if (!a.hasIntegers()) return AlembicType::float32;
    switch (writtenType(a)) {
        case IntegerType::int8:
            return AlembicType::int8;
        case IntegerType::uint8:
            return AlembicType::uint8;
        case IntegerType::int16:
            return AlembicType::int16;
        case IntegerType::uint16:
            return AlembicType::uint16;
        case IntegerType::int32:
            break;
    }
    return AlembicType::int32;
}

RowType rowTypeOf(const Attribute& a) {
    const AlembicType type = typeOf(a);
    const bool has_vectors = type == AlembicType::float32 || type == AlembicType::int32 || type == AlembicType::int16;
    const bool is_colour = a.name == "Cd" && type == AlembicType::float32;
    if (is_colour && (a.components == 3 || a.components == 4))
        return {type, a.components, a.components == 3 ? "rgb" : "rgba"};
    if (has_vectors && (a.components == 2 || a.components == 3)) return {type, a.components, "vector"};
    return {type, 1, "", a.components};
}

/// The numbers of an attribute in its type.
Write rowsOf(const Attribute& a, AlembicType type) {
    return [&a, type](ByteWriter& out) {
        for (const float x : a.real) out.little(x);
        for (const std::int32_t x : a.integer) {
            if (bytesOf(type) == 1)
                out.little(static_cast<std::uint8_t>(x));
            else if (bytesOf(type) == 2)
                out.little(static_cast<std::uint16_t>(x));
            else
                out.little(x);
        }
    };
}

template <typename Vector>
Write rowsOf(const std::vector<Vector>& rows) {
    return [&rows](ByteWriter& out) {
        for (const Vector& v : rows)
            out.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    };
}

/// Metadata of an array that readers take for a parameter of the geometry. scope: "vtx" a row per vertex, "uni" per
/// face.
std::string parameterMetadata(const RowType& type, const std::string& scope) {
    return "arrayExtent=" + std::to_string(type.rows_per_item) + ";geoScope=" + scope +
           (type.interpretation.empty() ? "" : ";interpretation=" + type.interpretation) +
           ";isGeomParam=true;podExtent=" + std::to_string(type.extent) + ";podName=" + nameOf(type.number);
}

/// An archive of one object with one sample.
class ArchiveWriter {
public:
    /// The properties of a compound: their groups and headers.
    struct Compound {
        std::vector<OgawaChild> groups;
        std::string headers;
    };

    void scalar(Compound& parent, const std::string& name, const std::string& metadata, AlembicType type,
                std::uint32_t extent, Write write) {
        parent.groups.push_back(file_.group({sample(extent * bytesOf(type), std::move(write))}));
        header(parent, name, metadata, kScalar | flagsOf(type, extent), true);
    }

    void array(Compound& parent, const std::string& name, const std::string& metadata, const RowType& type,
               std::uint64_t rows, Write write) {
        const std::uint64_t all_rows = rows * type.rows_per_item;
        const OgawaChild numbers = sample(all_rows * type.extent * bytesOf(type.number), std::move(write));
        parent.groups.push_back(file_.group({numbers, kEmptyData}));
        header(parent, name, metadata, kArray | (all_rows == 1 ? kScalar : 0) | flagsOf(type.number, type.extent),
               true);
    }

    void compound(Compound& parent, const std::string& name, const std::string& metadata, Compound child) {
        parent.groups.push_back(groupOf(std::move(child)));
        header(parent, name, metadata, 0, false);
    }

    /// Attributes as parameters of the geometry. left_out: one that is written otherwise, or null.
    void attributes(Compound& parameters, const std::vector<Attribute>& attributes, const Attribute* left_out,
                    std::size_t rows) {
        for (const Attribute& a : attributes) {
            if (&a == left_out) continue;
            const RowType type = rowTypeOf(a);
            array(parameters, a.name, parameterMetadata(type, "vtx"), type, rows, rowsOf(a, type.number));
        }
    }

    /// Writes the file, whose only object has this name, schema and geometry.
    void write(ByteWriter& out, const std::string& name, std::string_view schema, Compound geometry,
               const WriteOptions& options) {
        const std::string schema_text = "schema=" + std::string(schema) + ";schemaBaseType=AbcGeom_GeomBase_v1";
        Compound properties, none;
        compound(properties, ".geom", schema_text, std::move(geometry));
        const OgawaChild object = file_.group({groupOf(std::move(properties)), objectHeaders("")});
        std::string child = packed(static_cast<std::uint32_t>(name.size())) + name;
        putMetadata(schema_text + ";schemaObjTitle=" + std::string(schema) + ":.geom", child);
        const OgawaChild top = file_.group({kEmptyGroup, object, objectHeaders(child)});
        const double step = 1 / options.frames_per_second;
        const std::string samplings =
            packed(std::uint32_t{0}, 1.0, std::uint32_t{1}, 0.0) +
            packed(std::uint32_t{1}, step, std::uint32_t{1}, options.frame.value_or(0) * step);
        const OgawaChild root = file_.group(
            {file_.data(packed(kLayoutVersion)), file_.data(packed(kLibraryVersion)), top,
             file_.data("_ai_Application=betamesh;_ai_DCC_FPS=" + std::to_string(options.frames_per_second)),
             file_.data(samplings), file_.data(metadata_table_)});
        file_.write(out, root);
    }

private:
    static constexpr std::uint32_t flagsOf(AlembicType type, std::uint32_t extent) {
        return static_cast<std::uint32_t>(type) << kTypeShift | kHasTimeSampling | kSameSize | kConstant |
               extent << kExtentShift;
    }

    /// A sample: its digest, by which readers recognise data that they have already, and its numbers.
    OgawaChild sample(std::uint64_t bytes, Write write) {
        if (bytes == 0) return kEmptyData;
        return file_.data(kDigestBytes + bytes, [this, write = std::move(write)](ByteWriter& out) {
            Digester digester;
            ByteWriter hashed([&](std::span<const std::byte> piece) { digester.add(piece); });
            write(hashed);
            hashed.flush();
            const std::string digest = packed(digester.value());
            digest_of_samples_.add(std::as_bytes(std::span(digest)));
            out.text(digest);
            write(out);
        });
    }

    /// Metadata by its index in the table, or itself if the table is full.
    void putMetadata(const std::string& metadata, std::string& header) {
        const std::uint32_t index = indexOf(metadata);
        header += static_cast<char>(index);
        if (index == kInlineMetadata) header += packed(static_cast<std::uint32_t>(metadata.size())) + metadata;
    }

    std::uint32_t indexOf(const std::string& metadata) {
        if (metadata.empty()) return 0;
        if (const auto known = indices_.find(metadata); known != indices_.end()) return known->second;
        const auto index = static_cast<std::uint32_t>(indices_.size() + 1);
        if (index >= kInlineMetadata) return kInlineMetadata;
        indices_[metadata] = index;
        metadata_table_ += static_cast<char>(metadata.size()) + metadata;
        return index;
    }

    /// has_samples: of one sample, at the time of the frame. Names and metadata have fewer than 256 characters.
    void header(Compound& parent, const std::string& name, const std::string& metadata, std::uint32_t flags,
                bool has_samples) {
        const std::uint32_t index = indexOf(metadata);
        parent.headers += packed(flags | index << kMetadataShift);
        if (has_samples) parent.headers += packed(std::uint8_t{1}, static_cast<std::uint8_t>(kTimeOfFrame));
        parent.headers += static_cast<char>(name.size()) + name;
        if (index == kInlineMetadata) parent.headers += static_cast<char>(metadata.size()) + metadata;
    }

    OgawaChild groupOf(Compound compound) {
        if (compound.groups.empty()) return kEmptyGroup;
        compound.groups.push_back(file_.data(std::move(compound.headers)));
        return file_.group(compound.groups);
    }

    /// Headers of child objects, and the digests by which readers compare objects.
    OgawaChild objectHeaders(const std::string& children) {
        return file_.data(children.size() + 2 * kDigestBytes, [this, children](ByteWriter& out) {
            const std::string digest = packed(digest_of_samples_.value());
            out.text(children);
            out.text(children.empty() ? digest : std::string(kDigestBytes, '\0'));
            out.text(children.empty() ? std::string(kDigestBytes, '\0') : digest);
        });
    }

    OgawaWriter file_;
    std::map<std::string, std::uint32_t> indices_;  // of metadata in the table
    std::string metadata_table_;
    Digester digest_of_samples_;  // of those that are written
};

using Compound = ArchiveWriter::Compound;

const RowType kFloat{AlembicType::float32, 1};
const RowType kVector{AlembicType::float32, 3, "vector"};
const RowType kNormal{AlembicType::float32, 3, "normal"};
const RowType kInteger{AlembicType::int32, 1};
const std::string kVectorMetadata = "interpretation=vector";

void requireWritableAbc(const std::vector<Attribute>& attributes, std::size_t n, std::vector<std::string> reserved,
                        const std::string& file) {
    requireWritable(attributes, n, std::move(reserved), file);
    for (const Attribute& a : attributes)
        if (a.name.find('/') != std::string::npos)
            throw Error(file + ": attribute '" + a.name + "': Alembic allows no '/' in names. Rename the attribute.");
}

/// Bounds and positions, with which the geometry of every object begins.
template <typename Vector>
void addPositions(ArchiveWriter& archive, Compound& geometry, const std::vector<Vector>& positions,
                  const std::string& scope) {
    constexpr double kMost = std::numeric_limits<double>::max();  // the bounds of nothing, as Imath writes them
    std::array<double, 6> bounds{kMost, kMost, kMost, -kMost, -kMost, -kMost};
    for (const Vector& p : positions)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = static_cast<float>(p[static_cast<int>(axis)]);
            bounds[axis] = std::min(bounds[axis], x);
            bounds[axis + 3] = std::max(bounds[axis + 3], x);
        }
    archive.scalar(geometry, ".selfBnds", "interpretation=box", AlembicType::float64, 6, [bounds](ByteWriter& out) {
        for (const double x : bounds) out.little(x);
    });
    archive.array(geometry, "P", "geoScope=" + scope + ";interpretation=point", kVector, positions.size(),
                  rowsOf(positions));
}

/// The radius of particles; null: they have none.
const Attribute* radiusIn(const std::vector<Attribute>& attributes) {
    for (const char* name : {"radius", "pscale"})
        for (const Attribute& a : attributes)
            if (a.name == name && a.components == 1 && a.integer.empty()) return &a;
    return nullptr;
}

}  // namespace

void encodeAbc(ByteWriter& out, const Mesh& mesh, const std::string& file, const WriteOptions& options) {
    const std::size_t n = mesh.position.size(), triangles = mesh.triangles.size();
    requireWritable(mesh, file);
    std::vector<std::string> reserved{"P", "v"};
    if (mesh.component) reserved.emplace_back(kComponent);
    requireWritableAbc(mesh.attributes, n, reserved, file);
    if (n > std::numeric_limits<std::int32_t>::max())
        throw Error(file + ": " + std::to_string(n) +
                    " vertices are too many for an .abc file, which can store 2^31 - 1");
    ArchiveWriter archive;
    Compound geometry, parameters;
    addPositions(archive, geometry, mesh.position, "vtx");
    archive.array(geometry, ".faceIndices", "", kInteger, 3 * triangles, [&](ByteWriter& bytes) {
        for (const Triangle& t : mesh.triangles) bytes.little(Triangle{t[0], t[2], t[1]});
    });
    archive.array(geometry, ".faceCounts", "", kInteger, triangles, [&](ByteWriter& bytes) {
        for (std::size_t t = 0; t < triangles; ++t) bytes.little(std::int32_t{3});
    });
    const std::vector<Vec3> zeros(mesh.velocity.empty() ? n : 0, Vec3(0, 0, 0));
    archive.array(geometry, ".velocities", kVectorMetadata, kVector, n,
                  rowsOf(mesh.velocity.empty() ? zeros : mesh.velocity));
    const bool has_name =
        std::any_of(mesh.attributes.begin(), mesh.attributes.end(), [](const Attribute& a) { return a.name == "N"; });
    const Attribute* const given = normalsIn(mesh.attributes);
    std::vector<Vec3> normals;
    if (given != nullptr || !has_name) {
        normals = normalsOf(mesh);
        archive.array(geometry, "N", parameterMetadata(kNormal, "vtx"), kNormal, n, rowsOf(normals));
    }
    archive.attributes(parameters, mesh.attributes, given, n);
    if (mesh.component)
        archive.array(parameters, kComponent, parameterMetadata(kInteger, "uni"), kInteger, triangles,
                      [&](ByteWriter& bytes) {
                          for (const std::int32_t c : *mesh.component) bytes.little(c);
                      });
    if (!parameters.groups.empty()) archive.compound(geometry, ".arbGeomParams", "", std::move(parameters));
    archive.write(out, "mesh", kMeshSchema, std::move(geometry), options);
}

void encodeAbc(ByteWriter& out, const Particles& particles, const std::string& file, const WriteOptions& options) {
    const std::size_t n = particles.size();
    requireWritable(particles, file);
    requireWritableAbc(particles.attributes, n, {"P", "v", "id"}, file);
    ArchiveWriter archive;
    Compound geometry, parameters;
    addPositions(archive, geometry, particles.position, "var");
    archive.array(geometry, ".pointIds", "", {AlembicType::uint64, 1}, particles.id.size(), [&](ByteWriter& bytes) {
        for (const std::uint64_t id : particles.id) bytes.little(id);
    });
    if (!particles.velocity.empty() || n == 0)
        archive.array(geometry, ".velocities", kVectorMetadata, kVector, n, rowsOf(particles.velocity));
    if (const Attribute* const radius = radiusIn(particles.attributes); radius != nullptr)
        archive.array(geometry, ".widths", parameterMetadata(kFloat, "vtx"), kFloat, n, [radius](ByteWriter& bytes) {
            for (const float r : radius->real) bytes.little(2 * r);
        });
    archive.attributes(parameters, particles.attributes, nullptr, n);
    if (!parameters.groups.empty()) archive.compound(geometry, ".arbGeomParams", "", std::move(parameters));
    archive.write(out, "points", kPointsSchema, std::move(geometry), options);
}

}  // namespace betamesh
