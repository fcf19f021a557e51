#include "io/houdini_geo.h"

#include "base/parallel.h"
#include "io/bgeo.h"
#include "io/gzip.h"
#include "io/houdini_attributes.h"
#include "io/houdini_json.h"
#include "io/houdini_primitives.h"
#include "io/houdini_scf.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

// source  files of Houdini 13.0 to 21.0. The document lists keys and values: pointcount, vertexcount, primitivecount,
//         topology (the point of each vertex), attributes, primitives, pointgroups, …
constexpr std::uint64_t kMaxRows = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kPointsAtOnce = 4096;
constexpr std::string_view kClassicText = "PGEOMETRY";

class GeometryReader {
public:
    GeometryReader(Cursor in, const ReadOptions& options) : json_(std::move(in)), options_(options) {}

    FileContents read() {
        contents_.format = json_.isBinary() ? "houdini json binary" : "houdini json text";
        json_.forKeys("geometry", [&](const std::string& key) { readSection(key); });
        json_.readToEnd();
        if (!point_count_) json_.fail("the geometry has no pointcount");
        if (points_.position.size() != *point_count_)
            json_.fail("the geometry has no point attribute 'P', expected positions of " +
                       std::to_string(*point_count_) + " points");
        if (contents_.component) contents_.component->resize(contents_.triangles.size());
        leaveOutVolumes();
        const std::size_t all = points_.position.size();
        deliver(std::move(points_), all, options_, contents_);
        return std::move(contents_);
    }

private:
    void readSection(const std::string& key) {
        if (key == "pointcount")
            readCount("pointcount", point_count_);
        else if (key == "primitivecount")
            readCount("primitivecount", primitive_count_);
        else if (key == "topology")
            readTopology();
        else if (key == "attributes")
            readAttributes();
        else if (key == "primitives")
            primitives_.read();
        else if (key == "pointgroups" && options_.attributes)
            readPointGroups();
        else
            json_.skip();
    }

    void readCount(const char* what, std::optional<std::uint64_t>& count) {
        const std::int64_t found = json_.integer(what);
        if (found < 0 || static_cast<std::uint64_t>(found) > kMaxRows)
            json_.fail(std::string(what) + " is " + std::to_string(found) + ", expected 0 to " +
                       std::to_string(kMaxRows));
        if (count) json_.fail(std::string(what) + " is there twice, expected it once");
        count = static_cast<std::uint64_t>(found);
    }

    std::uint64_t pointCount() const {
        if (!point_count_) json_.fail("expected pointcount before what is said of points");
        return *point_count_;
    }

    /// The point of each vertex.
    void readTopology() {
        json_.forKeys("topology", [&](const std::string& key) {
            if (key != "pointref") return json_.skip();
            json_.forKeys("pointref", [&](const std::string& inner) {
                if (inner != "indices") return json_.skip();
                vertices_.clear();
                readHoudiniIndices(json_, "point of a vertex", pointCount(), vertices_);
            });
        });
    }

    // Attributes.

    void readAttributes() {
        json_.forKeys("attributes", [&](const std::string& key) {
            if (key == "pointattributes")
                json_.forElements("pointattributes", [&] { readPointAttribute(); });
            else if (key == "primitiveattributes" && options_.faces)
                json_.forElements("primitiveattributes", [&] { readPrimitiveAttribute(); });
            else if (key == "vertexattributes" && options_.attributes)
                passOver("vertex", key);
            else if (key == "globalattributes" && options_.attributes)
                passOver("detail", key);
            else
                json_.skip();
        });
    }

    /// Notes the names of attributes that are not read.
    void passOver(const std::string& owner, const std::string& key) {
        json_.forElements(key.c_str(), [&] {
            const HoudiniAttribute a = readHoudiniAttribute(json_, 0, [](const HoudiniAttribute&) { return false; });
            contents_.passed_over.push_back(owner + " attribute '" + a.name + "'");
        });
    }

    void readPointAttribute() {
        HoudiniAttribute a = readHoudiniAttribute(json_, pointCount(), [&](const HoudiniAttribute& declared) {
            return declared.name == "P" || options_.attributes;
        });
        contents_.declared.push_back({a.name, a.type == "numeric" ? a.storage : a.type, a.size, {}});
        if (a.name == "P") return takePosition(a);
        if (!options_.attributes || a.type != "numeric" || a.size == 0 || !(a.isReal() || a.isInteger())) return;
        const std::size_t numbers = a.real.size() + a.integer.size() + a.integer64.size();
        if (numbers != pointCount() * a.size) return;  // wider than is read
        if (a.isInteger() && a.size == 1 && a.name == options_.id && points_.id.empty()) return takeId(a);
        if (a.storage == "int64")
            points_.attributes.push_back(integerAttribute(std::move(a.name), a.size, std::move(a.integer64)));
        else
            points_.attributes.push_back({std::move(a.name), a.size, std::move(a.real), std::move(a.integer)});
    }

    void takePosition(const HoudiniAttribute& a) {
        if (a.size < 3 || a.real.size() + a.real64.size() != pointCount() * a.size)
            json_.fail("the point attribute 'P' has " + std::to_string(a.size) + " numbers of storage '" + a.storage +
                       "', expected 3 or 4 of fpreal32");
        points_.has_double_positions = !a.real64.empty();
        points_.position.clear();
        firstTouchResize(points_.position, static_cast<std::size_t>(pointCount()));
        const auto take = [&](const auto& numbers) {
            parallelFor(points_.position.size(), kPointsAtOnce, [&](std::size_t i) {
                for (int axis = 0; axis < 3; ++axis) {
                    const auto number = static_cast<double>(numbers[i * a.size + static_cast<std::size_t>(axis)]);
                    points_.position[i][axis] = static_cast<float>(number - options_.origin[axis]);
                }
            });
        };
        a.real64.empty() ? take(a.real) : take(a.real64);
    }

    void takeId(const HoudiniAttribute& a) {
        const auto take = [&](const auto& numbers) {
            for (const std::int64_t number : numbers) points_.id.push_back(static_cast<std::uint64_t>(number));
        };
        take(a.integer);
        take(a.integer64);
    }

    void readPrimitiveAttribute() {
        if (!primitive_count_) json_.fail("expected primitivecount before primitiveattributes");
        HoudiniAttribute a = readHoudiniAttribute(json_, *primitive_count_, [](const HoudiniAttribute& declared) {
            return declared.name == kComponent && declared.size == 1 && declared.isInteger() &&
                   declared.storage != "int64";
        });
        if (a.name != kComponent || a.size != 1 || !a.isInteger() || a.integer.size() != *primitive_count_) {
            contents_.passed_over.push_back("primitive attribute '" + a.name + "'");
            return;
        }
        component_ = std::move(a.integer);
        contents_.component.emplace();
    }

    void readPointGroups() {
        json_.forElements("pointgroups", [&] {
            HoudiniGroup group = readHoudiniGroup(json_, pointCount());
            const std::string name = std::string(kGroupPrefix) + group.name;
            contents_.declared.push_back({name, "group", 1, {}});
            contents_.groups.push_back(group.name);
            points_.attributes.push_back({name, 1, {}, std::move(group.member)});
        });
    }

    /// Where no polygons refer to points, those that place volumes are left out.
    void leaveOutVolumes() {
        if (primitives_.volumePoints().empty() || primitives_.hasPolygons()) return;
        std::vector<bool> places_volume(points_.position.size());
        for (const std::uint32_t point : primitives_.volumePoints()) places_volume[point] = true;
        std::vector<std::uint32_t> rows;
        for (std::uint32_t i = 0; i < places_volume.size(); ++i)
            if (!places_volume[i]) rows.push_back(i);
        keepRows(rows, points_);
    }

    HoudiniJsonReader json_;
    const ReadOptions& options_;
    FileContents contents_, points_;
    std::optional<std::uint64_t> point_count_, primitive_count_;
    std::vector<std::uint32_t> vertices_;  // the point of each
    std::vector<std::int32_t> component_;  // of each primitive, or none
    HoudiniPrimitiveReader primitives_{json_, options_, vertices_, component_, contents_};
};

/// Of a file that is not inside gzip.
FileContents parsePlain(Cursor in, const ReadOptions& options) {
    if (isScf(in)) {
        Cursor unpacked = scfUnpacked(std::move(in));
        if (!isHoudiniJson(unpacked))
            unpacked.fail("expected Houdini's JSON in the container, which begins with 7f 4e 53 4a 62 or [");
        FileContents contents = GeometryReader(std::move(unpacked), options).read();
        contents.format += ", blosc";
        return contents;
    }
    if (isHoudiniJson(in)) return GeometryReader(std::move(in), options).read();
    if (in.peek(kClassicText.size()).starts_with(kClassicText))
        throw Error(in.file() +
                    ": is classic Houdini geometry as text, expected another format of Houdini. Save it as "
                    ".bgeo in Houdini, or as .bhclassic");
    return parseBgeo(std::move(in), options);
}

}  // namespace

FileContents parseHoudini(Cursor in, const ReadOptions& options) {
    if (!isGzip(in)) return parsePlain(std::move(in), options);
    Cursor plain = gunzipped(std::move(in));
    if (isGzip(plain)) throw Error(plain.file() + ": is compressed twice, expected geometry inside gzip");
    const auto rest = std::make_shared<Cursor>(std::move(plain));
    const auto read = [rest](std::byte* to, std::size_t count) {
        const std::size_t got = std::min(count, rest->peek(1).size());
        std::copy_n(rest->take(got, "gzip"), got, to);
        return got;
    };
    FileContents contents = parsePlain({read, rest->remaining(), rest->file()}, options);
    contents.format += ", gzip";
    while (!rest->peek(1).empty()) rest->take(rest->peek(1).size(), "gzip");  // whose checksum comes last
    return contents;
}

}  // namespace betamesh
