// Writes PLY files.

#include "io/ply.h"

#include <algorithm>
#include <array>
#include <limits>

namespace betamesh {

namespace {

/// The property of one component of an attribute: a, a_x to a_w, or a_0 …. Normals are nx ny nz, as other programs
/// expect.
std::string propertyName(const Attribute& a, std::uint32_t component) {
    if (a.components == 1) return a.name;
    if (a.name == "N" && a.components == 3 && !a.hasIntegers()) return std::string("n") + "xyz"[component];
    if (a.components <= 4) return a.name + "_" + "xyzw"[component];
    return a.name + "_" + std::to_string(component);
}

const char* nameOf(IntegerType type) {
    switch (type) {
        case IntegerType::int8:
            return "char";
        case IntegerType::uint8:
            return "uchar";
        case IntegerType::int16:
            return "short";
        case IntegerType::uint16:
            return "ushort";
        case IntegerType::int32:
            break;
    }
    return "int";
}

/// Writes the header and rows. Construction starts the header; calls must be in the order of the format.
class PlyWriter {
public:
    PlyWriter(ByteWriter& out, std::size_t points) : out_(out) {
        out_.text("ply\nformat binary_little_endian 1.0\ncomment betamesh: world units, seconds\nelement vertex " +
                  std::to_string(points) + "\n");
        scalars("float", {"x", "y", "z"});
    }
    void scalars(const std::string& type, const std::vector<std::string>& names) {
        for (const std::string& name : names) out_.text("property " + type + " " + name + "\n");
    }
    void attributes(const std::vector<Attribute>& attributes) {
        for (const Attribute& a : attributes) {
            types_.push_back(writtenType(a));
            for (std::uint32_t c = 0; c < a.components; ++c)
                scalars(a.hasIntegers() ? nameOf(types_.back()) : "float", {propertyName(a, c)});
        }
    }
    void faces(std::size_t count, bool components) {
        out_.text("element face " + std::to_string(count) + "\nproperty list uchar int vertex_indices\n");
        if (components) scalars("int", {kComponent});
    }
    void edges(std::size_t count) {
        out_.text("element edge " + std::to_string(count) + "\n");
        scalars("int", {"vertex1", "vertex2"});
    }
    void endHeader() { out_.text("end_header\n"); }

    template <typename Vector>
    void vector(const Vector& v) {
        out_.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    }
    void attributeRow(const std::vector<Attribute>& attributes, std::size_t row) {
        for (std::size_t k = 0; k < attributes.size(); ++k) {
            const Attribute& a = attributes[k];
            for (std::size_t i = row * a.components; i < (row + 1) * a.components; ++i) {
                if (a.integer.empty())
                    out_.little(a.real[i]);
                else
                    integer(types_[k], a.integer[i]);
            }
        }
    }

private:
    void integer(IntegerType type, std::int32_t number) {
        switch (type) {
            case IntegerType::int8:
            case IntegerType::uint8:
                return out_.little(static_cast<std::uint8_t>(number));
            case IntegerType::int16:
            case IntegerType::uint16:
                return out_.little(static_cast<std::uint16_t>(number));
            case IntegerType::int32:
                return out_.little(number);
        }
    }

    ByteWriter& out_;
    std::vector<IntegerType> types_;  // of the attributes' integers
};

/// Throws Error unless the names of attributes and of the properties that they become are unique in this format.
void requireWritableAttributes(const std::vector<Attribute>& attributes, std::size_t n, const std::string& file) {
    std::vector<std::string> reserved{"x", "y", "z", "vx", "vy", "vz", "v", "id"};
    requireWritable(attributes, n, reserved, file);
    std::vector<Attribute> properties;
    for (const Attribute& a : attributes)
        for (std::uint32_t c = 0; c < a.components; ++c) properties.push_back({propertyName(a, c), 1, {}, {}});
    requireWritable(properties, 0, reserved, file);
}

}  // namespace

void encodePly(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    const bool has_velocity = !particles.velocity.empty() || n == 0;
    const bool has_id = !particles.id.empty() || n == 0;
    requireWritable(particles, file);
    requireWritableAttributes(particles.attributes, n, file);
    PlyWriter ply(out, n);
    if (has_velocity) ply.scalars("float", {"vx", "vy", "vz"});
    const bool is_signed = !std::all_of(particles.id.begin(), particles.id.end(), [](std::uint64_t id) {
        return id <= std::numeric_limits<std::uint32_t>::max();
    }) && haveSigned32Bits(particles.id);
    if (has_id) ply.scalars(is_signed ? "int" : "uint", {"id"});
    ply.attributes(particles.attributes);
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(particles.position[i]);
        if (has_velocity) ply.vector(particles.velocity[i]);
        if (has_id)
            out.little(is_signed ? static_cast<std::uint32_t>(particles.id[i]) : idOf32Bits(particles.id, i, file));
        ply.attributeRow(particles.attributes, i);
    }
    out.flush();
}

void encodePly(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    const std::size_t n = mesh.position.size();
    requireWritable(mesh, file);
    requireWritableAttributes(mesh.attributes, n, file);
    if (n > std::numeric_limits<std::int32_t>::max())
        throw Error(file + ": " + std::to_string(n) +
                    " vertices are too many for a .ply file, which can store 2^31 - 1");
    PlyWriter ply(out, n);
    ply.scalars("float", {"vx", "vy", "vz"});
    ply.attributes(mesh.attributes);
    ply.faces(mesh.triangles.size(), mesh.component.has_value());
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(mesh.position[i]);
        ply.vector(mesh.velocity.empty() ? Vec3(0, 0, 0) : mesh.velocity[i]);
        ply.attributeRow(mesh.attributes, i);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        out.little(std::uint8_t{3});
        out.little(mesh.triangles[i]);
        if (mesh.component) out.little((*mesh.component)[i]);
    }
    out.flush();
}

void encodePly(ByteWriter& out, const Curves& curves, const std::string& file) {
    const std::size_t n = curves.position.size();
    requireWritable(curves, file);
    requireWritableAttributes(curves.attributes, n, file);
    PlyWriter ply(out, n);
    ply.scalars("float", {"vx", "vy", "vz"});
    ply.attributes(curves.attributes);
    ply.edges(curves.edges.size());
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(curves.position[i]);
        ply.vector(curves.velocity.empty() ? Vec3(0, 0, 0) : curves.velocity[i]);
        ply.attributeRow(curves.attributes, i);
    }
    for (const Edge& edge : curves.edges) out.little(edge);
    out.flush();
}

void encodePly(ByteWriter& out, const Spheres& spheres, const std::string& file) {
    encodePly(out, particlesOf(spheres, "radius", file), file);
}

}  // namespace betamesh
