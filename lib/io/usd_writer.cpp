// Text files of USD: .usda out.

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/usd.h"
#include "mesh/normals.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kRowsPerBlock = std::size_t{1} << 12;
constexpr std::size_t kBlocksAtOnce = 64;
constexpr std::size_t kNumberCharacters = 24;  // of the longest float or 64-bit integer, and a comma

std::string textOf(double number) {
    std::array<char, 64> buffer{};
    return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr};
}

template <typename Number>
char* put(char* to, Number number) {
    return std::to_chars(to, to + kNumberCharacters, number).ptr;
}

/// The shortest text that gives the same float again, also where it is read as a double, which is then rounded. Of all
/// floats that makes a difference for 7.038531e-26 alone.
char* put(char* to, float number) {
    constexpr float kRoundedTwice = 0x1.5c87fap-84F;
    if (std::abs(number) == kRoundedTwice) return put(to, double{number});
    return std::to_chars(to, to + kNumberCharacters, number).ptr;
}

/// A tuple, or a number alone.
template <typename Number>
char* putTuple(char* to, const Number* numbers, std::size_t count) {
    if (count == 1) return put(to, numbers[0]);
    *to++ = '(';
    for (std::size_t k = 0; k < count; ++k) {
        if (k > 0) *to++ = ',', *to++ = ' ';
        to = put(to, numbers[k]);
    }
    *to++ = ')';
    return to;
}

/// Writes `[row, row, …]`. putRow(to, i) writes row i of at most row_characters and returns its end. Several threads
/// write blocks of rows to memory, which go to the file in their order.
template <typename PutRow>
void writeArray(ByteWriter& out, std::size_t rows, std::size_t row_characters, const PutRow& putRow) {
    out.text("[");
    std::vector<std::vector<char>> blocks(kBlocksAtOnce);
    std::vector<std::size_t> sizes(kBlocksAtOnce);
    for (std::size_t first = 0; first < rows; first += kBlocksAtOnce * kRowsPerBlock) {
        const std::size_t count = std::min(kBlocksAtOnce, (rows - first + kRowsPerBlock - 1) / kRowsPerBlock);
        parallelFor(count, 1, [&](std::size_t b) {
            const std::size_t begin = first + b * kRowsPerBlock, end = std::min(rows, begin + kRowsPerBlock);
            blocks[b].resize((end - begin) * (row_characters + 2));
            char* to = blocks[b].data();
            for (std::size_t i = begin; i < end; ++i) {
                if (i > 0) *to++ = ',', *to++ = ' ';
                to = putRow(to, i);
            }
            sizes[b] = static_cast<std::size_t>(to - blocks[b].data());
        });
        for (std::size_t b = 0; b < count; ++b) out.text({blocks[b].data(), sizes[b]});
    }
    out.text("]");
}

/// Writes an array of `components` numbers per row.
template <typename Number>
void writeRows(ByteWriter& out, const std::vector<Number>& numbers, std::size_t components, bool as_tuples) {
    const std::size_t per_row = as_tuples ? components : 1;
    writeArray(out, numbers.size() / per_row, per_row * kNumberCharacters + 2,
               [&](char* to, std::size_t i) { return putTuple(to, numbers.data() + i * per_row, per_row); });
}

template <typename Vector>
void writeVectors(ByteWriter& out, std::size_t rows, const std::vector<Vector>& vectors) {
    writeArray(out, rows, 3 * kNumberCharacters + 2, [&](char* to, std::size_t i) {
        const Vector v = vectors.empty() ? Vector(0, 0, 0) : vectors[i];
        const std::array numbers{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
        return putTuple(to, numbers.data(), 3);
    });
}

/// The attributes of one prim: all declarations, then all values.
class PrimWriter {
public:
    PrimWriter(const WriteOptions& options, std::string type, std::string name)
        : options_(options), type_(std::move(type)), name_(std::move(name)) {}

    /// A value that is the same in all frames: `uniform bool doubleSided = 0`.
    void constant(const std::string& line) { constants_.push_back(line); }

    /// declaration: type and name, as in "point3f[] points". metadata: as in `interpolation = "vertex"`.
    void attribute(const std::string& declaration, std::string metadata, std::function<void(ByteWriter&)> write) {
        attributes_.push_back({declaration, std::move(metadata), std::move(write)});
    }

    /// Attributes of points, each under the name that USD has for it, or as a primvar.
    ///
    /// in      other: is written otherwise; may be null
    void attributes(const std::vector<Attribute>& all, const Attribute* other = nullptr) {
        std::vector<std::string> names;
        for (const Attribute& a : all) names.push_back(a.name);
        names = usdNames(names);
        for (std::size_t i = 0; i < all.size(); ++i)
            if (&all[i] != other) attribute(all[i], names[i]);
    }

    void write(ByteWriter& out) const {
        out.text(usdaHeader(options_, options_.frame, options_.frame, "    defaultPrim = \"geometry\"\n") +
                 "\ndef Xform \"geometry\" (\n    kind = \"component\"\n)\n{\n    def " + type_ + " \"" + name_ +
                 "\"\n    {\n");
        for (const std::string& line : constants_) out.text("        " + line + "\n");
        for (const Column& column : attributes_) {
            out.text("        " + column.declaration);
            if (!column.metadata.empty()) out.text(" (\n            " + column.metadata + "\n        )");
            out.text("\n");
        }
        for (const Column& column : attributes_) {
            out.text("        " + column.declaration);
            if (options_.frame)
                out.text(".timeSamples = {\n            " + std::to_string(*options_.frame) + ": ");
            else
                out.text(" = ");
            column.write(out);
            out.text(options_.frame ? ",\n        }\n" : "\n");
        }
        out.text("    }\n}\n");
        out.flush();
    }

private:
    struct Column {
        std::string declaration, metadata;
        std::function<void(ByteWriter&)> write;
    };

    /// name: of the primvar that it is unless USD has a name for it.
    void attribute(const Attribute& a, const std::string& name) {
        const bool is_vector = a.components == 3 && !a.hasIntegers();
        const auto write = [&a](bool as_tuples) {
            return [&a, as_tuples](ByteWriter& out) {
                if (a.integer.empty())
                    writeRows(out, a.real, a.components, as_tuples);
                else
                    writeRows(out, a.integer, a.components, as_tuples);
            };
        };
        const std::string vertex = "interpolation = \"vertex\"";
        if (is_vector && a.name == "N") return attribute("normal3f[] normals", vertex, write(true));
        if (is_vector && a.name == "accel") return attribute("vector3f[] accelerations", "", write(true));
        if (is_vector && a.name == "Cd") return attribute("color3f[] primvars:displayColor", vertex, write(true));
        const bool has_tuple_type = a.components >= 1 && a.components <= 4;
        std::string type = a.hasIntegers() ? "int" : "float", metadata;
        if (has_tuple_type && a.components > 1) type += std::to_string(a.components);
        if (name != a.name) metadata += "displayName = \"" + escaped(a.name) + "\"\n            ";
        if (!has_tuple_type) metadata += "elementSize = " + std::to_string(a.components) + "\n            ";
        attribute(type + "[] primvars:" + name, metadata + vertex, write(has_tuple_type));
    }

    static std::string escaped(const std::string& name) {
        std::string text;
        for (const char c : name) {
            if (c == '"' || c == '\\') text += '\\';
            text += c;
        }
        return text;
    }

    const WriteOptions& options_;
    std::string type_, name_;
    std::vector<std::string> constants_;
    std::vector<Column> attributes_;
};

/// The bounding box of positions with half of the widths around it; that of no points is empty.
template <typename Vector>
void addExtent(PrimWriter& prim, const std::vector<Vector>& positions, const std::vector<float>* widths = nullptr) {
    Boxf box;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vec3f p(positions[i]);
        const float half = widths != nullptr ? (*widths)[i] / 2 : 0.0F;
        box.extendBy(p - Vec3f(half));
        box.extendBy(p + Vec3f(half));
    }
    if (positions.empty()) {
        constexpr float kMost = std::numeric_limits<float>::max();
        box.min = Vec3f(kMost);
        box.max = Vec3f(-kMost);
    }
    prim.attribute("float3[] extent", "", [box](ByteWriter& out) {
        writeVectors(out, 2, std::vector<Vec3f>{box.min, box.max});
    });
}

}  // namespace

std::string usdaHeader(const WriteOptions& options, std::optional<int> first, std::optional<int> last,
                       const std::string& more) {
    std::string text = "#usda 1.0\n(\n" + more;
    if (last) text += "    endTimeCode = " + std::to_string(*last) + "\n";
    text += "    framesPerSecond = " + textOf(options.frames_per_second) + "\n";
    text += "    metersPerUnit = " + textOf(options.meters_per_unit) + "\n";
    if (first) text += "    startTimeCode = " + std::to_string(*first) + "\n";
    text += "    timeCodesPerSecond = " + textOf(options.frames_per_second) + "\n";
    return text + "    upAxis = \"" + (options.up_axis == UpAxis::z ? "Z" : "Y") + "\"\n)\n";
}

std::vector<std::string> usdNames(const std::vector<std::string>& names) {
    std::vector<std::string> plain = names;
    for (std::string& name : plain) {
        for (char& c : name)
            if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9')) c = '_';
        if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, "_");
        if (name == "indices") name += '_';  // `primvars:indices` is a keyword
    }
    return distinctNames(names, std::move(plain), {"displayColor", kComponent});
}

void encodeUsda(ByteWriter& out, const Mesh& mesh, const std::string& file, const WriteOptions& options) {
    requireWritable(mesh, file);
    const std::size_t n = mesh.position.size();
    requireWritable(mesh.attributes, n, {"points", "velocities"}, file);
    PrimWriter prim(options, "Mesh", "mesh");
    prim.constant("uniform bool doubleSided = 0");
    prim.constant("uniform token orientation = \"rightHanded\"");
    prim.constant("uniform token subdivisionScheme = \"none\"");
    addExtent(prim, mesh.position);
    prim.attribute("int[] faceVertexCounts", "", [&](ByteWriter& text) {
        writeArray(text, mesh.triangles.size(), 1, [](char* to, std::size_t) { return *to = '3', to + 1; });
    });
    prim.attribute("int[] faceVertexIndices", "", [&](ByteWriter& text) {
        writeArray(text, mesh.triangles.size(), 3 * kNumberCharacters, [&](char* to, std::size_t i) {
            const Triangle& t = mesh.triangles[i];
            for (std::size_t k = 0; k < 3; ++k) {
                if (k > 0) *to++ = ',', *to++ = ' ';
                to = put(to, t[k]);
            }
            return to;
        });
    });
    prim.attribute("point3f[] points", "", [&](ByteWriter& text) { writeVectors(text, n, mesh.position); });
    prim.attribute("vector3f[] velocities", "", [&](ByteWriter& text) { writeVectors(text, n, mesh.velocity); });
    if (normalsIn(mesh.attributes) == nullptr)
        prim.attribute("normal3f[] normals", "interpolation = \"vertex\"",
                       [&](ByteWriter& text) { writeVectors(text, n, normalsOf(mesh)); });
    prim.attributes(mesh.attributes);
    if (mesh.component)
        prim.attribute("int[] primvars:" + std::string(kComponent), "interpolation = \"uniform\"",
                       [&](ByteWriter& text) { writeRows(text, *mesh.component, 1, false); });
    prim.write(out);
}

void encodeUsda(ByteWriter& out, const Particles& particles, const std::string& file, const WriteOptions& options) {
    requireWritable(particles, file);
    const std::size_t n = particles.size();
    requireWritable(particles.attributes, n, {"points", "velocities", "ids", "widths"}, file);
    const std::vector<std::int64_t> ids(particles.id.begin(), particles.id.end());
    PrimWriter prim(options, "Points", "points");
    // A width is a diameter. A radius whose double is infinite stays a primvar.
    const auto isRadius = [](const Attribute& a) {
        return a.name == "pscale" && a.components == 1 && a.integer.empty() &&
               std::all_of(a.real.begin(), a.real.end(), [](float r) { return std::isfinite(2 * r); });
    };
    const auto radius = std::find_if(particles.attributes.begin(), particles.attributes.end(), isRadius);
    std::vector<float> widths;
    if (radius != particles.attributes.end())
        for (const float r : radius->real) widths.push_back(2 * r);
    const bool has_widths = radius != particles.attributes.end();
    addExtent(prim, particles.position, has_widths ? &widths : nullptr);
    if (!particles.id.empty() || n == 0)
        prim.attribute("int64[] ids", "", [&](ByteWriter& text) { writeRows(text, ids, 1, false); });
    prim.attribute("point3f[] points", "", [&](ByteWriter& text) { writeVectors(text, n, particles.position); });
    if (!particles.velocity.empty() || n == 0)
        prim.attribute("vector3f[] velocities", "",
                       [&](ByteWriter& text) { writeVectors(text, n, particles.velocity); });
    if (has_widths)
        prim.attribute("float[] widths", "interpolation = \"vertex\"",
                       [&](ByteWriter& text) { writeRows(text, widths, 1, false); });
    prim.attributes(particles.attributes, has_widths ? &*radius : nullptr);
    prim.write(out);
}

}  // namespace betamesh
