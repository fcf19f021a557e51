#include "io/houdini_primitives.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

// source  files of Houdini 13.0 to 21.0. A primitive is an array of its definition and its data. Polygons refer to
//         vertices, whose points the topology lists, and run clockwise seen from outside:
//   p_r, Polygon_run       n_p (nprimitives) closed polygons of consecutive vertices from s_v (startvertex) on; the
//                          numbers of their vertices are listed (n_v, nvertices) or run-length encoded as pairs of
//                          vertices and polygons (r_v, nvertices_rle)
//   c_r, PolygonCurve_run  the same of open polygons
//   Poly                   `vertex` lists the vertices; `closed`
//   run                    an array of primitives of the `runtype`, of each the values of the `varyingfields`

constexpr std::int64_t kMostPolygons = std::numeric_limits<std::int32_t>::max();  // and vertices

bool isClosedRun(const std::string& type) { return type == "p_r" || type == "Polygon_run"; }
bool isOpenRun(const std::string& type) { return type == "c_r" || type == "PolygonCurve_run"; }
bool isPolygon(const std::string& type) { return isClosedRun(type) || isOpenRun(type) || type == "Poly"; }
bool isPacked(const std::string& type) { return type.starts_with("Packed") || type == "AlembicRef"; }
bool isVolume(const std::string& type) { return type == "Volume" || type == "VDB"; }
bool isParticleSystem(const std::string& type) { return type == "Part"; }

std::string printable(std::string text) {
    text.resize(std::min<std::size_t>(text.size(), 60));
    for (char& c : text)
        if (c < ' ' || c > '~') c = '?';
    return text;
}

}  // namespace

void readHoudiniIndices(HoudiniJsonReader& json, const char* what, std::uint64_t end,
                        std::vector<std::uint32_t>& indices) {
    json.forNumbers<std::int64_t>(what, [&](std::span<const std::int64_t> numbers) {
        for (const std::int64_t number : numbers) {
            if (number < 0 || static_cast<std::uint64_t>(number) >= end)
                json.fail(std::string(what) + " is " + std::to_string(number) + ", expected 0 or more and less than " +
                          std::to_string(end));
            indices.push_back(static_cast<std::uint32_t>(number));
        }
    });
}

void HoudiniPrimitiveReader::read() {
    json_.forElements("primitives", [&] {
        int part = 0;
        Definition definition;
        json_.forElements("primitive", [&] {
            if (part == 0)
                definition = readDefinition();
            else if (part == 1)
                readPrimitive(definition);
            else
                json_.skip();
            ++part;
        });
    });
    for (const auto& [type, count] : left_out_)
        contents_.passed_over.push_back(std::to_string(count) + " primitives of type " + printable(type));
}

HoudiniPrimitiveReader::Definition HoudiniPrimitiveReader::readDefinition() {
    Definition definition;
    std::string run_type;
    json_.forKeys("definition of a primitive", [&](const std::string& key) {
        if (key == "type") {
            definition.type = json_.text("type of a primitive");
        } else if (key == "runtype") {
            run_type = json_.text("runtype of primitives");
        } else if (key == "varyingfields") {
            json_.forElements("varyingfields",
                              [&] { definition.varying_fields.push_back(json_.text("varyingfields")); });
        } else if (key == "uniformfields") {
            json_.forKeys("uniformfields", [&](const std::string& field) {
                if (field == "closed")
                    definition.closed = json_.boolean("closed");
                else
                    json_.skip();
            });
        } else {
            json_.skip();
        }
    });
    definition.is_run = definition.type == "run";
    if (definition.is_run) definition.type = run_type;
    return definition;
}

void HoudiniPrimitiveReader::readPrimitive(const Definition& definition) {
    const std::string& type = definition.type;
    const bool strict = !options_.skip_unknown_faces;
    const auto fail = [&](const std::string& text) {
        json_.fail("primitive " + std::to_string(primitive_) + " is '" + printable(type) + "', " + text);
    };
    has_polygons_ = has_polygons_ || isPolygon(type);
    if (isPacked(type) && strict)
        fail("a packed primitive, whose points are stored elsewhere. Unpack it in Houdini before the file is written");
    if (!isPolygon(type) && !isParticleSystem(type) && options_.faces && strict)
        fail("expected polygons or particle systems");
    if (isVolume(type) && !definition.is_run) return readVolume();
    if (isPolygon(type) && !options_.faces) return countPolygons(definition);
    if (!isPolygon(type)) {
        const std::uint64_t before = primitive_;
        skip(definition);
        if (!isParticleSystem(type) && !strict) left_out_[type] += primitive_ - before;
        return;
    }
    if (definition.is_run) return readOldRun(definition);
    if (type == "Poly") return readPolygon();
    readPolygonRun(isClosedRun(type));
}

void HoudiniPrimitiveReader::skip(const Definition& definition) {
    if (!definition.is_run) {
        json_.skip();
        ++primitive_;
    } else {
        json_.forElements("run of primitives", [&] {
            json_.skip();
            ++primitive_;
        });
    }
}

void HoudiniPrimitiveReader::countPolygons(const Definition& definition) {
    std::uint64_t polygons = 1;
    bool closed = definition.closed && !isOpenRun(definition.type);
    if (definition.is_run) {
        const std::uint64_t before = primitive_;
        skip(definition);
        polygons = primitive_ - before;
    } else {
        json_.forKeys("polygons", [&](const std::string& key) {
            if (key == "n_p" || key == "nprimitives")
                polygons = static_cast<std::uint64_t>(readNumber("number of polygons", kMostPolygons));
            else if (key == "closed")
                closed = json_.boolean("closed");
            else
                json_.skip();
        });
        primitive_ += polygons;
    }
    if (closed) contents_.unread_polygons += polygons;
}

std::int64_t HoudiniPrimitiveReader::readNumber(const char* what, std::int64_t end) {
    const std::int64_t number = json_.integer(what);
    if (number < 0 || number >= end)
        json_.fail(std::string(what) + " is " + std::to_string(number) + ", expected 0 or more and less than " +
                   std::to_string(end));
    return number;
}

void HoudiniPrimitiveReader::readVolume() {
    json_.forKeys("volume", [&](const std::string& key) {
        if (key != "vertex") return json_.skip();
        const std::int64_t vertex = readNumber("vertex of a volume", static_cast<std::int64_t>(vertices_.size()));
        volume_points_.push_back(vertices_[static_cast<std::size_t>(vertex)]);
    });
    ++primitive_;
}

void HoudiniPrimitiveReader::readPolygonRun(bool closed) {
    std::uint64_t vertex = 0, polygons = 0;
    std::vector<std::int64_t> sizes, runs;
    const auto readSizes = [&](std::vector<std::int64_t>& numbers) {
        numbers.clear();
        json_.forNumbers<std::int64_t>("vertices of polygons", [&](std::span<const std::int64_t> more) {
            for (const std::int64_t number : more)
                if (number < 0 || number > kMostPolygons)
                    json_.fail("polygons have " + std::to_string(number) + " vertices, expected 0 or more");
            numbers.insert(numbers.end(), more.begin(), more.end());
        });
    };
    json_.forKeys("polygons", [&](const std::string& key) {
        if (key == "s_v" || key == "startvertex")
            vertex = static_cast<std::uint64_t>(readNumber("first vertex of polygons", kMostPolygons));
        else if (key == "n_p" || key == "nprimitives")
            polygons = static_cast<std::uint64_t>(readNumber("number of polygons", kMostPolygons));
        else if (key == "n_v" || key == "nvertices")
            readSizes(sizes);
        else if (key == "r_v" || key == "nvertices_rle")
            readSizes(runs);
        else
            json_.skip();
    });
    if (runs.size() % 2 != 0) json_.fail("vertices of polygons are an odd number of numbers, expected pairs");
    std::uint64_t listed = sizes.size();
    for (std::size_t i = 1; i < runs.size(); i += 2) listed += static_cast<std::uint64_t>(runs[i]);
    if (listed != polygons)
        json_.fail("vertices are given of " + std::to_string(listed) + " polygons, expected " +
                   std::to_string(polygons));
    for (const std::int64_t size : sizes) addPolygons(1, static_cast<std::uint64_t>(size), closed, vertex);
    for (std::size_t i = 0; i < runs.size(); i += 2)
        addPolygons(static_cast<std::uint64_t>(runs[i + 1]), static_cast<std::uint64_t>(runs[i]), closed, vertex);
}

/// Polygons of so many corners each, of consecutive vertices from `vertex` on, which is moved behind them.
void HoudiniPrimitiveReader::addPolygons(std::uint64_t count, std::uint64_t corners, bool closed,
                                         std::uint64_t& vertex) {
    if (corners == 0) {
        primitive_ += count;
        return;
    }
    if (vertex > vertices_.size() || count > (vertices_.size() - vertex) / corners)
        json_.fail(std::to_string(count) + " polygons of " + std::to_string(corners) + " vertices from vertex " +
                   std::to_string(vertex) +
                   " on, expected no more than there are: " + std::to_string(vertices_.size()));
    const std::span<const std::uint32_t> vertices(vertices_);
    for (std::uint64_t i = 0; i < count; ++i, vertex += corners)
        addPolygon(vertices.subspan(static_cast<std::size_t>(vertex), static_cast<std::size_t>(corners)), closed);
}

std::vector<std::uint32_t> HoudiniPrimitiveReader::pointsOf(const std::vector<std::uint32_t>& vertices) const {
    std::vector<std::uint32_t> points;
    points.reserve(vertices.size());
    for (const std::uint32_t vertex : vertices) points.push_back(vertices_[vertex]);
    return points;
}

void HoudiniPrimitiveReader::readPolygon() {
    bool closed = true;
    std::vector<std::uint32_t> vertices;
    json_.forKeys("polygon", [&](const std::string& key) {
        if (key == "closed") {
            closed = json_.boolean("closed");
        } else if (key == "vertex") {
            vertices.clear();
            readHoudiniIndices(json_, "vertex of a polygon", vertices_.size(), vertices);
        } else {
            json_.skip();
        }
    });
    addPolygon(pointsOf(vertices), closed);
}

void HoudiniPrimitiveReader::readOldRun(const Definition& definition) {
    json_.forElements("run of polygons", [&] {
        bool closed = definition.closed;
        std::vector<std::uint32_t> vertices;
        std::size_t field = 0;
        json_.forElements("polygon of a run", [&] {
            const std::string name = field < definition.varying_fields.size() ? definition.varying_fields[field] : "";
            ++field;
            if (name == "closed") {
                closed = json_.boolean("closed");
            } else if (name == "vertex") {
                vertices.clear();
                readHoudiniIndices(json_, "vertex of a polygon", vertices_.size(), vertices);
            } else {
                json_.skip();
            }
        });
        addPolygon(pointsOf(vertices), closed);
    });
}

void HoudiniPrimitiveReader::addPolygon(std::span<const std::uint32_t> points, bool closed) {
    if (closed) {
        // Houdini's polygons run clockwise seen from outside, ours the other way.
        polygon_.assign(points.begin(), points.end());
        if (!polygon_.empty()) std::reverse(polygon_.begin() + 1, polygon_.end());
        appendFan(polygon_, contents_.triangles);
        contents_.declares_faces = true;
    } else {
        for (std::size_t i = 1; i < points.size(); ++i) contents_.edges.push_back({points[i - 1], points[i]});
        contents_.declares_edges = true;
    }
    const std::int32_t component = primitive_ < component_.size() ? component_[primitive_] : 0;
    if (contents_.component) contents_.component->resize(contents_.triangles.size(), component);
    ++primitive_;
}

}  // namespace betamesh
