// XML files of VTK: .vtp out.

#include "io/vtk.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/vtk_cells.h"
#include "mesh/normals.h"

#include <functional>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

using WriteRows = std::function<void(ByteWriter&)>;

/// Arrays are declared in the XML first, then written one after the other behind it.
class VtpWriter {
public:
    VtpWriter(ByteWriter& out, std::size_t points) : out_(out), points_(points) {}

    void begin(const std::string& section, const std::string& more = "") { xml_ += "      <" + section + more + ">\n"; }
    void end(const std::string& section) { xml_ += "      </" + section + ">\n"; }

    /// type_bytes: of one number.
    void array(const std::string& name, const char* type, std::size_t components, std::uint64_t numbers,
               std::size_t type_bytes, WriteRows write) {
        xml_ += "        <DataArray type=\"" + std::string(type) + "\" Name=\"" + escaped(name) +
                "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"appended\" offset=\"" +
                std::to_string(offset_) + "\"/>\n";
        const std::uint64_t bytes = numbers * type_bytes;
        offset_ += sizeof(std::uint64_t) + bytes;
        arrays_.push_back({bytes, std::move(write)});
    }

    template <typename Vector>
    void vectors(const std::string& name, const std::vector<Vector>& rows) {
        array(name, "Float32", 3, 3 * points_, sizeof(float), [&rows](ByteWriter& out) {
            for (const Vector& v : rows)
                out.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
        });
    }

    void attribute(const Attribute& a, const std::string& name) {
        if (!a.hasIntegers())
            array(name, "Float32", a.components, points_ * a.components, sizeof(float), [&a](ByteWriter& out) {
                for (const float x : a.real) out.little(x);
            });
        else
            array(name, "Int32", a.components, points_ * a.components, sizeof(std::int32_t), [&a](ByteWriter& out) {
                for (const std::int32_t x : a.integer) out.little(x);
            });
    }

    /// Point arrays: attributes, and what `others` writes before them. has_normals: others writes normals.
    void pointData(const std::vector<Attribute>& attributes, bool has_normals, const std::function<void()>& others) {
        has_normals |= normalsIn(attributes) != nullptr;
        begin("PointData", has_normals ? " Vectors=\"velocity\" Normals=\"Normals\"" : " Vectors=\"velocity\"");
        others();
        for (const Attribute& a : attributes) attribute(a, &a == normalsIn(attributes) ? kVtkNormals : a.name);
        end("PointData");
    }

    /// Cells of a fixed number of corners, or of their own sizes. Corners: as out.little takes them.
    void cells(const char* section, std::uint64_t count, std::uint64_t corners, WriteRows write_corners,
               WriteRows write_offsets) {
        begin(section);
        array("connectivity", "Int64", 1, corners, sizeof(std::int64_t), std::move(write_corners));
        array("offsets", "Int64", 1, count, sizeof(std::int64_t), std::move(write_offsets));
        end(section);
    }

    void write(const char* cells, std::size_t count) {
        out_.text(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n  <PolyData>\n    <Piece NumberOfPoints=\"" +
            std::to_string(points_) + "\"");
        for (const char* kind : {"Verts", "Lines", "Strips", "Polys"})
            out_.text(std::string(" NumberOf") + kind + "=\"" + std::to_string(std::string(kind) == cells ? count : 0) +
                      "\"");
        out_.text(">\n" + xml_ + "    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n   _");
        for (const auto& [bytes, rows] : arrays_) {
            out_.little(bytes);
            rows(out_);
        }
        out_.text("\n  </AppendedData>\n</VTKFile>\n");
        out_.flush();
    }

private:
    static std::string escaped(const std::string& name) {
        std::string text;
        for (const char c : name)
            if (c == '&')
                text += "&amp;";
            else if (c == '<')
                text += "&lt;";
            else if (c == '"')
                text += "&quot;";
            else
                text += c;
        return text;
    }

    ByteWriter& out_;
    std::size_t points_;
    std::string xml_;
    std::uint64_t offset_ = 0;
    std::vector<std::pair<std::uint64_t, WriteRows>> arrays_;
};

/// Offsets of cells that all have so many corners.
WriteRows offsetsOf(std::size_t count, std::int64_t corners) {
    return [count, corners](ByteWriter& out) {
        for (std::size_t c = 1; c <= count; ++c) out.little(static_cast<std::int64_t>(c) * corners);
    };
}

/// normals: written unless null.
template <typename Surface>
void writePoints(VtpWriter& vtp, const Surface& surface, const std::vector<Vec3>* normals) {
    const std::size_t n = surface.position.size();
    vtp.pointData(surface.attributes, normals != nullptr, [&] {
        vtp.array("velocity", "Float32", 3, 3 * n, sizeof(float), [&surface, n](ByteWriter& out) {
            for (std::size_t i = 0; i < n; ++i) {
                const Vec3 v = surface.velocity.empty() ? Vec3(0, 0, 0) : surface.velocity[i];
                out.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
            }
        });
        if (normals != nullptr) vtp.vectors(kVtkNormals, *normals);
    });
}

template <typename Surface>
void requireWritableVtp(const Surface& surface, const std::string& file) {
    requireWritable(surface, file);
    requireWritable(surface.attributes, surface.position.size(), {"velocity", "Points", kVtkNormals}, file);
}

}  // namespace

void encodeVtp(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    requireWritable(particles, file);
    requireWritable(particles.attributes, n, {"velocity", "id", "Points", kVtkNormals}, file);
    // A number of 2^63 or more is a negative one in all likelihood. The bits are the same.
    const bool has_negative = std::any_of(particles.id.begin(), particles.id.end(), [](auto id) { return id >> 63; });
    VtpWriter vtp(out, n);
    vtp.pointData(particles.attributes, false, [&] {
        if (!particles.velocity.empty()) vtp.vectors("velocity", particles.velocity);
        if (!particles.id.empty())
            vtp.array("id", has_negative ? "Int64" : "UInt64", 1, n, sizeof(std::uint64_t), [&](ByteWriter& bytes) {
                for (const std::uint64_t id : particles.id) bytes.little(id);
            });
    });
    vtp.begin("Points");
    vtp.vectors("Points", particles.position);
    vtp.end("Points");
    const WriteRows corners = [n](ByteWriter& bytes) {
        for (std::size_t i = 0; i < n; ++i) bytes.little(static_cast<std::int64_t>(i));
    };
    vtp.cells("Verts", n, n, corners, offsetsOf(n, 1));
    vtp.write("Verts", n);
}

void encodeVtp(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    const std::size_t triangles = mesh.triangles.size();
    requireWritableVtp(mesh, file);
    const bool has_name =
        std::any_of(mesh.attributes.begin(), mesh.attributes.end(), [](const Attribute& a) { return a.name == "N"; });
    const std::vector<Vec3> normals = has_name ? std::vector<Vec3>{} : normalsOf(mesh);
    VtpWriter vtp(out, mesh.position.size());
    writePoints(vtp, mesh, has_name ? nullptr : &normals);
    if (mesh.component) {
        vtp.begin("CellData");
        vtp.array(kComponent, "Int32", 1, triangles, sizeof(std::int32_t), [&](ByteWriter& bytes) {
            for (const std::int32_t c : *mesh.component) bytes.little(c);
        });
        vtp.end("CellData");
    }
    vtp.begin("Points");
    vtp.vectors("Points", mesh.position);
    vtp.end("Points");
    const WriteRows corners = [&](ByteWriter& bytes) {
        for (const Triangle& t : mesh.triangles) bytes.little(std::array<std::int64_t, 3>{t[0], t[1], t[2]});
    };
    vtp.cells("Polys", triangles, 3 * triangles, corners, offsetsOf(triangles, 3));
    vtp.write("Polys", triangles);
}

void encodeVtp(ByteWriter& out, const Curves& curves, const std::string& file) {
    requireWritableVtp(curves, file);
    VtpWriter vtp(out, curves.position.size());
    writePoints(vtp, curves, nullptr);
    vtp.begin("Points");
    vtp.vectors("Points", curves.position);
    vtp.end("Points");
    // Each line with its first corner again at the end where it is closed.
    const std::vector<std::span<const Edge>> lines = linesOf(curves);
    std::uint64_t count = 0;
    for (const auto& line : lines) count += line.size() + 1;
    const WriteRows corners = [&lines](ByteWriter& bytes) {
        for (const auto& line : lines) {
            bytes.little(std::int64_t{line.front()[0]});
            for (const Edge& edge : line) bytes.little(std::int64_t{edge[1]});
        }
    };
    const WriteRows offsets = [&lines](ByteWriter& bytes) {
        std::int64_t end = 0;
        for (const auto& line : lines) bytes.little(end += static_cast<std::int64_t>(line.size()) + 1);
    };
    vtp.cells("Lines", lines.size(), count, corners, offsets);
    vtp.write("Lines", lines.size());
}

}  // namespace betamesh
