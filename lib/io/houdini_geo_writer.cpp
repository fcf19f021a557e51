#include "io/houdini_attributes.h"
#include "io/houdini_geo.h"
#include "io/houdini_json_writer.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace betamesh {

namespace {

// source  files of Houdini 16.0 to 21.0, whose order of keys this keeps.
constexpr const char* kVersion = "16.0.450";  // the first that has runs of polygons; later ones read it, too
constexpr std::int64_t kPageRows = 1024;

/// What Houdini calls the meaning of the numbers, which it transforms accordingly; empty: none.
std::string_view meaningOf(const std::string& name, std::uint32_t components) {
    if (components == 3 && name == "N") return "normal";
    if (components == 3 && (name == "Cd" || name == "Cs")) return "color";
    return {};
}

class GeometryWriter {
public:
    explicit GeometryWriter(ByteWriter& out) : out_(out), json_(out) {}

    /// All that comes before the attributes. vertices: points of the corners of primitives.
    template <typename Vertices>
    void begin(std::size_t points, std::size_t vertex_count, std::size_t primitives, const Vertices& vertices) {
        json_.beginArray();
        json_.text("fileversion");
        json_.text(kVersion);
        json_.text("hasindex");
        json_.boolean(false);
        count("pointcount", points);
        count("vertexcount", vertex_count);
        count("primitivecount", primitives);
        json_.text("info");
        json_.beginMap();
        json_.text("software");
        json_.text("betamesh");
        json_.endMap();
        json_.text("topology");
        json_.beginArray();
        json_.text("pointref");
        json_.beginArray();
        json_.text("indices");
        json_.beginNumbers<std::int32_t>(vertex_count);
        vertices([&](std::uint32_t point) { json_.number(static_cast<std::int32_t>(point)); });
        json_.endArray();
        json_.endArray();
        json_.text("attributes");
        json_.beginArray();
        json_.text("pointattributes");
        json_.beginArray();
    }

    template <typename Vector>
    void vectors(std::string_view name, std::string_view meaning, const std::vector<Vector>& rows, std::size_t n) {
        attribute<float>(name, meaning, 3, n, [&](std::size_t i) {
            const Vector row = rows.empty() ? Vector(0, 0, 0) : rows[i];
            for (const auto number : {row.x, row.y, row.z}) json_.number(static_cast<float>(number));
        });
    }

    /// As 32 bits where all of them fit, as most programs write them.
    void ids(const std::vector<std::uint64_t>& ids) {
        constexpr std::uint64_t kMax32 = std::numeric_limits<std::int32_t>::max();
        const auto write = [&]<typename T>(T) {
            attribute<T>("id", "nonarithmetic_integer", 1, ids.size(),
                         [&](std::size_t i) { json_.number(static_cast<T>(ids[i])); });
        };
        if (std::all_of(ids.begin(), ids.end(), [](std::uint64_t id) { return id <= kMax32; }))
            write(std::int32_t{});
        else
            write(std::int64_t{});
    }

    void attributes(const std::vector<Attribute>& attributes, std::size_t n) {
        for (const Attribute& a : attributes) {
            if (isPointGroup(a)) continue;
            const auto write = [&](const auto& numbers) {
                using T = typename std::decay_t<decltype(numbers)>::value_type;
                attribute<T>(a.name, meaningOf(a.name, a.components), a.components, n, [&](std::size_t i) {
                    for (std::size_t c = i * a.components; c < (i + 1) * a.components; ++c) json_.number(numbers[c]);
                });
            };
            if (a.hasIntegers())
                write(a.integer);
            else
                write(a.real);
        }
    }

    void component(const std::optional<std::vector<std::int32_t>>& component) {
        if (!component) return;
        json_.endArray();
        json_.text("primitiveattributes");
        json_.beginArray();
        attribute<std::int32_t>(kComponent, "nonarithmetic_integer", 1, component->size(),
                                [&](std::size_t i) { json_.number((*component)[i]); });
    }

    /// Ends the attributes.
    void beginPrimitives() {
        json_.endArray();
        json_.endArray();
        json_.text("primitives");
        json_.beginArray();
    }

    /// Polygons of all vertices: of three each, or as many as `sizes` says.
    void polygons(const char* type, std::size_t polygons, const char* key, const std::vector<std::int32_t>& sizes) {
        if (polygons == 0) return;
        json_.beginArray();
        json_.beginArray();
        json_.text("type");
        json_.text(type);
        json_.endArray();
        json_.beginArray();
        json_.text("s_v");
        json_.integer(0);
        count("n_p", polygons);
        json_.text(key);
        json_.beginNumbers<std::int32_t>(sizes.size());
        for (const std::int32_t size : sizes) json_.number(size);
        json_.endArray();
        json_.endArray();
    }

    /// Ends the primitives; writes the groups among the attributes.
    void end(const std::vector<Attribute>& attributes) {
        json_.endArray();
        if (std::any_of(attributes.begin(), attributes.end(), isPointGroup)) {
            json_.text("pointgroups");
            json_.beginArray();
            for (const Attribute& a : attributes)
                if (isPointGroup(a)) group(a.name.substr(kGroupPrefix.size()), a.integer);
            json_.endArray();
        }
        json_.endArray();
        out_.flush();
    }

private:
    void count(const char* key, std::size_t number) {
        json_.text(key);
        json_.integer(static_cast<std::int64_t>(number));
    }

    /// write(row) writes the numbers of one row.
    template <typename T, typename WriteRow>
    void attribute(std::string_view name, std::string_view meaning, std::uint32_t size, std::size_t rows,
                   const WriteRow& write) {
        const char* storage = std::is_same_v<T, float>          ? "fpreal32"
                              : std::is_same_v<T, std::int32_t> ? "int32"
                                                                : "int64";
        json_.beginArray();
        definition(name, meaning);
        json_.beginArray();
        count("size", size);
        json_.text("storage");
        json_.text(storage);
        json_.text("defaults");
        defaults(std::is_same_v<T, float>);
        json_.text("values");
        json_.beginArray();
        count("size", size);
        json_.text("storage");
        json_.text(storage);
        json_.text("pagesize");
        json_.integer(kPageRows);
        json_.text("rawpagedata");
        json_.beginNumbers<T>(static_cast<std::uint64_t>(rows) * size);
        for (std::size_t i = 0; i < rows; ++i) write(i);
        json_.endArray();
        json_.endArray();
        json_.endArray();
    }

    void definition(std::string_view name, std::string_view meaning) {
        json_.beginArray();
        for (const std::string_view word :
             {std::string_view("scope"), std::string_view("public"), std::string_view("type"),
              std::string_view("numeric"), std::string_view("name"), name, std::string_view("options")})
            json_.text(word);
        json_.beginMap();
        if (!meaning.empty()) {
            json_.text("type");
            json_.beginMap();
            json_.text("type");
            json_.text("string");
            json_.text("value");
            json_.text(meaning);
            json_.endMap();
        }
        json_.endMap();
        json_.endArray();
    }

    void defaults(bool real) {
        json_.beginArray();
        count("size", 1);
        json_.text("storage");
        json_.text(real ? "fpreal64" : "int64");
        json_.text("values");
        json_.beginArray();
        if (real)
            json_.real(0);
        else
            json_.integer(0);
        json_.endArray();
        json_.endArray();
    }

    void group(std::string_view name, const std::vector<std::int32_t>& member) {
        json_.beginArray();
        json_.beginArray();
        json_.text("name");
        json_.text(name);
        json_.text("type");
        json_.text("point");
        json_.endArray();
        json_.beginArray();
        json_.text("selection");
        json_.beginArray();
        json_.text("defaults");
        defaults(false);
        json_.text("unordered");
        json_.beginArray();
        json_.text("i8");
        json_.beginNumbers<std::int8_t>(member.size());
        for (const std::int32_t is_member : member) json_.number(static_cast<std::int8_t>(is_member));
        json_.endArray();
        json_.endArray();
        json_.endArray();
        json_.endArray();
    }

    ByteWriter& out_;
    HoudiniJsonWriter json_;
};

void requireCounts(std::size_t points, std::size_t vertices, const std::string& file) {
    constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
    if (points > kMax || vertices > kMax)
        throw Error(file + ": " + std::to_string(points) + " points and " + std::to_string(vertices) +
                    " corners of polygons, expected at most " + std::to_string(kMax) + " in a .bgeo file");
}

}  // namespace

void encodeBgeoJson(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    requireWritable(particles, file);
    requireWritable(particles.attributes, n, {"P", "v", "id"}, file);
    requireCounts(n, 0, file);
    GeometryWriter writer(out);
    writer.begin(n, 0, 0, [](const auto&) {});
    writer.vectors("P", "point", particles.position, n);
    if (!particles.velocity.empty() || n == 0) writer.vectors("v", "vector", particles.velocity, n);
    if (!particles.id.empty() || n == 0) writer.ids(particles.id);
    writer.attributes(particles.attributes, n);
    writer.beginPrimitives();
    writer.end(particles.attributes);
}

void encodeBgeoJson(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    const std::size_t n = mesh.position.size(), triangles = mesh.triangles.size();
    requireWritable(mesh, file);
    requireWritable(mesh.attributes, n, {"P", "v"}, file);
    requireCounts(n, 3 * triangles, file);
    GeometryWriter writer(out);
    writer.begin(n, 3 * triangles, triangles, [&](const auto& write) {
        for (const Triangle& t : mesh.triangles)
            for (const std::uint32_t corner : {t[0], t[2], t[1]}) write(corner);  // Houdini's are clockwise
    });
    writer.vectors("P", "point", mesh.position, n);
    writer.vectors("v", "vector", mesh.velocity, n);
    writer.attributes(mesh.attributes, n);
    writer.component(mesh.component);
    writer.beginPrimitives();
    writer.polygons("p_r", triangles, "r_v", {3, static_cast<std::int32_t>(triangles)});
    writer.end(mesh.attributes);
}

void encodeBgeoJson(ByteWriter& out, const Curves& curves, const std::string& file) {
    const std::size_t n = curves.position.size();
    const auto lines = linesOf(curves);
    const std::size_t vertices = curves.edges.size() + lines.size();
    requireWritable(curves, file);
    requireWritable(curves.attributes, n, {"P", "v"}, file);
    requireCounts(n, vertices, file);
    GeometryWriter writer(out);
    writer.begin(n, vertices, lines.size(), [&](const auto& write) {
        for (const std::span<const Edge> line : lines) {
            write(line.front()[0]);
            for (const Edge& edge : line) write(edge[1]);
        }
    });
    writer.vectors("P", "point", curves.position, n);
    writer.vectors("v", "vector", curves.velocity, n);
    writer.attributes(curves.attributes, n);
    writer.beginPrimitives();
    std::vector<std::int32_t> sizes;
    for (const std::span<const Edge> line : lines) sizes.push_back(static_cast<std::int32_t>(line.size() + 1));
    writer.polygons("c_r", lines.size(), "n_v", sizes);
    writer.end(curves.attributes);
}

}  // namespace betamesh
