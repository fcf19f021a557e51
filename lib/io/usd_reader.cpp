// Text files of USD: .usda in.

#include "betamesh/error.h"
#include "io/frame_number.h"
#include "io/number_columns.h"
#include "io/usd.h"
#include "io/usda_parser.h"
#include "io/usda_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>

namespace betamesh {

namespace {

std::string wholeText(Cursor& in) {
    std::string text;
    while (in.remaining() > 0) {
        const std::string_view some = in.peek(1);
        if (some.empty()) break;
        text += some;
        in.skip(some.size(), "text");
    }
    return text;
}

/// The frame of splash.0012.usda.
std::optional<double> numberInName(const std::string& file) {
    const std::string name = std::filesystem::path(file).filename().string();
    const std::string_view digits = frameNumberIn(name);
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    return error == std::errc() ? std::optional(number) : std::nullopt;
}

bool isNamed(std::string_view type, std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), type) != names.end();
}

/// Attributes of the schemas that are used in another way, or say nothing about points.
bool isOfSchema(std::string_view name) {
    return name.starts_with("xformOp") ||
           isNamed(name, {"points", "extent", "visibility", "purpose", "doubleSided", "orientation",
                          "subdivisionScheme", "interpolateBoundary", "faceVaryingLinearInterpolation",
                          "triangleSubdivisionRule", "faceVertexCounts", "faceVertexIndices", "holeIndices",
                          "cornerIndices", "cornerSharpnesses", "creaseIndices", "creaseLengths", "creaseSharpnesses"});
}

/// A finite number above 0.
std::optional<double> positiveNumber(std::string_view text) {
    double number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number > 0 && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

FileUnits unitsOf(const UsdaStage& stage) {
    FileUnits units{positiveNumber(stage.frame_rate), std::nullopt, positiveNumber(stage.meters_per_unit)};
    const std::string up = stage.up_axis.empty() ? "" : unquoted(stage.up_axis);
    if (up == "Y" || up == "Z") units.up_axis = up == "Z" ? UpAxis::z : UpAxis::y;
    if (up == "Z") units.up_axis_note = "upAxis = \"Z\" (--up-axis z, input.up_axis, turns it to y)";
    if (!stage.meters_per_unit.empty() && stage.meters_per_unit != "1")
        units.meters_per_unit_note = "metersPerUnit = " + std::string(stage.meters_per_unit);
    return units;
}

class Reader {
public:
    Reader(const UsdaStage& stage, const std::string& file, const ReadOptions& options)
        : stage_(stage), file_(file), options_(options) {}

    FileContents read() {
        contents_.format = "USD, text";
        const std::vector<std::size_t> chosen = choosePrims();
        contents_.units = unitsOf(stage_);
        for (const std::size_t prim : chosen) readPrim(prim);
        joinBlocks();
        if (any_component_ && !faces_without_component_) contents_.component = std::move(component_);
        return deliverWhole(std::move(contents_), options_);
    }

    std::vector<double> sampleTimes() {
        std::set<double> times;
        const auto add = [&](const UsdaAttribute& attribute) {
            for (const UsdaAttribute::Sample& sample : attribute.samples)
                if (std::isfinite(sample.time)) times.insert(sample.time);
        };
        for (const std::size_t prim : choosePrims()) {
            if (const UsdaAttribute* points = stage_.prims[prim].find("points")) add(*points);
            for (std::size_t i = prim; i != kNoPrim; i = stage_.prims[i].parent)
                for (const UsdaAttribute& attribute : stage_.prims[i].attributes)
                    if (attribute.name.starts_with("xformOp:")) add(attribute);
        }
        return {times.begin(), times.end()};
    }

private:
    [[noreturn]] void fail(const std::string& text) const { throw Error(file_ + ": " + text); }

    /// Lists the geometry of the file, and returns the prims to read.
    std::vector<std::size_t> choosePrims() {
        std::vector<std::size_t> points, meshes, named;
        std::string all;
        std::set<std::string> unknown(options_.grids.begin(), options_.grids.end());
        for (std::size_t i = 0; i < stage_.prims.size(); ++i) {
            const UsdaPrim& prim = stage_.prims[i];
            if (prim.type == "Points") points.push_back(i);
            if (prim.type == "Mesh") meshes.push_back(i);
            if (!isNamed(prim.type, {"Points", "Mesh", "BasisCurves", "NurbsCurves", "PointInstancer", "Volume"}))
                continue;
            const std::string path = stage_.pathOf(i);
            contents_.grids.push_back({path, std::string(prim.type), false});
            index_.push_back(i);
            if (all.size() < 1000) all += (all.empty() ? "" : ", ") + path + " (" + std::string(prim.type) + ")";
            const std::size_t found = unknown.erase(path) + unknown.erase(std::string(prim.name));
            if (found > 0 && isNamed(prim.type, {"Points", "Mesh"})) named.push_back(i);
        }
        if (!unknown.empty() && !options_.grids.empty())
            fail("has no prim '" + *unknown.begin() + "' of points (input.grid). The file has " +
                 (all.empty() ? "no geometry" : all) + ".");
        if (points.empty() && meshes.empty())
            fail("has no prim of type Points or Mesh. The file has " + (all.empty() ? "no geometry" : all) + ".");
        const bool as_mesh = options_.faces && !meshes.empty() && options_.grids.empty();
        std::vector<std::size_t> chosen = !options_.grids.empty() ? named : as_mesh || points.empty() ? meshes : points;
        contents_.declares_faces = options_.faces && stage_.prims[chosen.front()].type == "Mesh";
        for (const std::size_t prim : chosen) {
            const auto listed = std::lower_bound(index_.begin(), index_.end(), prim);
            contents_.grids[static_cast<std::size_t>(listed - index_.begin())].is_read = true;
        }
        for (const GridInfo& grid : contents_.grids)
            if (!grid.is_read && options_.faces) contents_.passed_over.push_back(grid.name + " (" + grid.type + ")");
        return chosen;
    }

    void readPrim(std::size_t index) {
        const UsdaPrim& prim = stage_.prims[index];
        path_ = stage_.pathOf(index);
        const UsdaAttribute* points = prim.find("points");
        if (points == nullptr) fail(path_ + ": the prim has no points");
        time_ = timeOf(*points);
        const UsdaType type = typeOf(*points);
        if (type.components != 3 || !isReal(type.number)) fail(path_ + ": points are not of the type point3f[]");
        const UsdaTransform to_world = transformOf(index);
        NumberColumn column = numbersOf(*points, type);
        const std::size_t n = column.size() / 3;
        if (n + points_ > std::numeric_limits<std::uint32_t>::max()) fail("more than 2^32 - 1 points");
        transformRows(
            column.real, [&](const Vec3& p) { return to_world.point(p); }, to_world);
        FileContents block;
        block.has_double_positions = type.number == NumberType::float64;
        block.position = positionsFrom(column, 3, options_.origin);
        names_ = {"P"};
        declare("P", type);
        for (const UsdaAttribute& attribute : prim.attributes)
            if (!isOfSchema(attribute.name))
                readAttribute(attribute, prim.find(std::string(attribute.name) + ":indices") != nullptr, n, block);
        transformAttributes(to_world, block.attributes);
        if (contents_.declares_faces) readFaces(prim, n, to_world.determinant() < 0);
        if (!options_.faces && prim.find("faceVertexCounts") != nullptr)
            contents_.unread_polygons += integersOf(prim, "faceVertexCounts").size();
        contents_.has_double_positions |= block.has_double_positions;
        blocks_.push_back({path_, std::move(block)});
        points_ += n;
    }

    /// The points of a prim.
    struct Block {
        std::string path;
        FileContents points;
    };

    /// Appends the blocks to the contents. Prims that lack a velocity or acceleration which others have get zeros; of
    /// other attributes only those of all prims are kept. Prims without points lack nothing.
    void joinBlocks() {
        for (const Attribute& a : attributesOfBlocks()) completeInBlocks(a);
        const auto lacksIds = [](const Block& b) { return b.points.id.empty() && !b.points.position.empty(); };
        const auto lacking = std::find_if(blocks_.begin(), blocks_.end(), lacksIds);
        const auto owner =
            std::find_if(blocks_.begin(), blocks_.end(), [](const Block& b) { return !b.points.id.empty(); });
        if (lacking != blocks_.end() && owner != blocks_.end()) leaveOut(owner->path, options_.id, lacking->path);
        for (Block& block : blocks_) append(std::move(block.points), points_, contents_);
    }

    /// The attributes that any prim with points has, or any prim if none has points; without rows.
    std::vector<Attribute> attributesOfBlocks() const {
        std::vector<Attribute> all;
        for (const Block& block : blocks_) {
            if (block.points.position.empty() && points_ > 0) continue;
            for (const Attribute& a : block.points.attributes)
                if (std::none_of(all.begin(), all.end(), [&](const Attribute& known) { return known.name == a.name; }))
                    all.push_back({a.name, a.components, {}, {}, a.integer_type, a.hasIntegers()});
        }
        return all;
    }

    /// Adds an attribute without rows to the blocks that lack it, as joinBlocks() says, or else notes that it is lost.
    void completeInBlocks(const Attribute& attribute) {
        std::string owner, first, lacking;
        std::vector<FileContents*> incomplete;
        std::size_t count = 0;  // prims with points that lack it
        for (Block& block : blocks_) {
            const bool has_it = std::any_of(
                block.points.attributes.begin(), block.points.attributes.end(),
                [&](const Attribute& a) { return a.name == attribute.name && a.components == attribute.components; });
            if (has_it) {
                if (owner.empty()) owner = block.path;
                continue;
            }
            incomplete.push_back(&block.points);
            if (block.points.position.empty()) continue;
            if (count++ == 0) first = block.path;
            lacking += (lacking.empty() ? "" : ", ") + block.path;
        }
        const bool is_velocity = isNamed(attribute.name, {"v", "vel", "velocity"});
        const bool is_motion =
            attribute.components == 3 && (is_velocity || isNamed(attribute.name, {"accel", "acceleration"}));
        if (count > 0 && !is_motion) return leaveOut(owner, attribute.name, first);
        for (FileContents* points : incomplete) {
            points->attributes.push_back(attribute);
            points->attributes.back().real.resize(points->position.size() * attribute.components);
        }
        if (count > 0)
            contents_.warnings.push_back(lacking + (count > 1 ? " have no " : " has no ") +
                                         (is_velocity ? "velocities" : "accelerations") + ", unlike " + owner +
                                         ": zero is taken for them");
    }

    void leaveOut(const std::string& owner, const std::string& attribute, const std::string& lacking) {
        contents_.passed_over.push_back(owner + '.' + attribute + " (" + lacking + " does not have it)");
    }

    /// The time of the sample to read.
    double timeOf(const UsdaAttribute& points) {
        const std::optional<double> wanted = options_.frame ? options_.frame : numberInName(file_);
        const bool is_there = std::ranges::any_of(points.samples, [&](const auto& s) { return s.time == wanted; });
        if (points.samples.size() > 1 && !(options_.frame && is_there))
            contents_.passed_over.push_back(std::to_string(points.samples.size() - 1) + " other time samples of " +
                                            path_);
        if (options_.frame || is_there) return *wanted;
        double earliest = points.samples.empty() ? 0 : points.samples.front().time;
        for (const UsdaAttribute::Sample& sample : points.samples) earliest = std::min(earliest, sample.time);
        return earliest;
    }

    UsdaType typeOf(const UsdaAttribute& attribute) const {
        const auto type = usdaType(attribute.type);
        if (!type) fail(where(attribute) + ": the type " + std::string(attribute.type) + " is not made of numbers");
        return *type;
    }

    std::string where(const UsdaAttribute& attribute) const { return path_ + "." + std::string(attribute.name); }

    NumberColumn numbersOf(const UsdaAttribute& attribute, const UsdaType& type) const {
        return usdaNumbers(attribute.valueAt(time_), type, file_ + ": " + where(attribute));
    }

    void declare(const std::string& name, const UsdaType& type, std::size_t components = 0) {
        const bool is_known = std::any_of(contents_.declared.begin(), contents_.declared.end(),
                                          [&](const AttributeInfo& a) { return a.name == name; });
        if (is_known) return;
        contents_.declared.push_back({name, std::string(type.name),
                                      static_cast<std::uint32_t>(components > 0 ? components : type.components), ""});
    }

    void passOver(const UsdaAttribute& attribute, const std::string& why) {
        contents_.passed_over.push_back(where(attribute) + " (" + why + ")");
    }

    /// The name that this program gives to an attribute; empty: it is not one of points.
    static std::string nameOf(const UsdaAttribute& attribute) {
        if (!attribute.display_name.empty()) {
            const std::string given = unquoted(attribute.display_name);
            if (!given.empty() && given.find_first_of(" \t\r\n\v\f") == std::string::npos) return given;
        }
        const std::string_view name = attribute.name;
        for (const auto& [usd, own] : {std::pair("velocities", "v"), std::pair("accelerations", "accel"),
                                       std::pair("normals", "N"), std::pair("widths", "pscale"), std::pair("ids", "id"),
                                       std::pair("primvars:displayColor", "Cd"), std::pair("primvars:normals", "N")})
            if (name == usd) return own;
        return std::string(name.starts_with("primvars:") ? name.substr(9) : name);
    }

    /// is_indexed: a second attribute has indices into the values of this one.
    void readAttribute(const UsdaAttribute& attribute, bool is_indexed, std::size_t n, FileContents& block) {
        const std::string name = nameOf(attribute);
        const bool is_primvar = attribute.name.starts_with("primvars:");
        const std::string interpolation = unquoted(attribute.interpolation);
        if (is_primvar && name == kComponent && interpolation == "uniform") return;  // read with the faces
        const auto type = usdaType(attribute.type);
        if (!type) return passOver(attribute, std::string(attribute.type));
        if (attribute.name.ends_with(":indices")) return;
        if (is_indexed) return passOver(attribute, "the primvar is indexed");
        if (isNamed(interpolation, {"uniform", "faceVarying", "constant"}) && attribute.name != "widths")
            return passOver(attribute, interpolation + " interpolation");
        const std::string_view value = attribute.valueAt(time_);
        std::size_t components = type->components;
        if (!attribute.element_size.empty()) {
            std::size_t size = 0;
            const char* end = attribute.element_size.data() + attribute.element_size.size();
            std::from_chars(attribute.element_size.data(), end, size);
            if (size == 0 || size > 1000) fail(where(attribute) + ": elementSize is not a number from 1 to 1000");
            components *= size;
        }
        if (!names_.insert(name).second) return passOver(attribute, "a second attribute of this name");
        declare(name, *type, components);
        if (value.empty() || (!options_.attributes && name != options_.id)) return;
        NumberColumn column = usdaNumbers(value, *type, file_ + ": " + where(attribute));
        if (column.size() == 0 && n > 0) return;
        const bool is_single = column.size() == components && n != 1;
        if (attribute.name == "widths") {
            if (is_single) column.real.resize(n, column.number(0));
            for (double& width : column.real) width /= 2;
        } else if (is_single && is_primvar && interpolation.empty()) {
            return passOver(attribute, "constant interpolation");
        } else if (!is_primvar && column.size() != n * components && !isNamed(name, {"v", "accel", "N", "id"})) {
            return passOver(attribute, "not one value for each point");
        }
        if (column.size() != n * components)
            fail(where(attribute) + " has " + std::to_string(column.size()) + " numbers, but needs " +
                 std::to_string(components) + " for each of " + std::to_string(n) + " points");
        addColumn(name, components, std::move(column), n, options_, file_, block);
    }

    template <typename Map>
    static void transformRows(std::vector<double>& numbers, const Map& map, const UsdaTransform& transform) {
        if (transform == UsdaTransform{}) return;
        for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
            const Vec3 v = map(Vec3(numbers[i], numbers[i + 1], numbers[i + 2]));
            for (std::size_t k = 0; k < 3; ++k) numbers[i + k] = v[static_cast<int>(k)];
        }
    }

    static void transformAttributes(const UsdaTransform& transform, std::vector<Attribute>& attributes) {
        if (transform == UsdaTransform{}) return;
        const double scale = std::cbrt(std::abs(transform.determinant()));
        for (Attribute& a : attributes) {
            const bool is_vector = a.components == 3 && !a.real.empty();
            std::vector<double> numbers(a.real.begin(), a.real.end());
            if (is_vector && isNamed(a.name, {"v", "accel"}))
                transformRows(
                    numbers, [&](const Vec3& v) { return transform.vector(v); }, transform);
            else if (is_vector && a.name == "N")
                transformRows(
                    numbers, [&](const Vec3& v) { return transform.normal(v); }, transform);
            else if (a.name == "pscale")
                for (double& radius : numbers) radius *= scale;
            std::transform(numbers.begin(), numbers.end(), a.real.begin(),
                           [](double x) { return static_cast<float>(x); });
        }
    }

    /// The transform from a prim to the world.
    UsdaTransform transformOf(std::size_t prim) const {
        UsdaTransform map;
        for (; prim != kNoPrim; prim = stage_.prims[prim].parent) {
            const UsdaAttribute* order = stage_.prims[prim].find("xformOpOrder");
            if (order == nullptr) continue;
            std::vector<std::string> operations = usdaStrings(order->valueAt(time_));
            const auto reset = std::find(operations.begin(), operations.end(), "!resetXformStack!");
            const bool resets = reset != operations.end();
            if (resets) operations.erase(operations.begin(), reset + 1);
            // The last operation is the first that is applied to a point.
            for (auto operation = operations.rbegin(); operation != operations.rend(); ++operation)
                map = map.followedBy(operationOf(prim, *operation));
            if (resets) break;
        }
        return map;
    }

    UsdaTransform operationOf(std::size_t prim, const std::string& name) const {
        const std::string prim_path = stage_.pathOf(prim);
        const auto refuse = [&](const std::string& why) {
            fail(prim_path + ": the transform " + name + " " + why +
                 ". Only translations, scales and matrices are applied. Bake it into the points, or remove it.");
        };
        const UsdaAttribute* attribute = stage_.prims[prim].find(name);
        if (attribute == nullptr) refuse("is not there, or inverted");
        const std::string_view kind = std::string_view(name).substr(std::min<std::size_t>(name.size(), 8));
        const auto is = [&](std::string_view word) {
            return kind == word || kind.starts_with(std::string(word) + ":");
        };
        if (!is("translate") && !is("scale") && !is("transform")) refuse("is not read");
        const bool is_animated = attribute->samples.size() > 1;
        if (is_animated && std::none_of(attribute->samples.begin(), attribute->samples.end(),
                                        [&](const auto& sample) { return sample.time == time_; }))
            refuse("is animated, and has no sample at " + std::to_string(time_));
        const auto type = usdaType(attribute->type);
        const std::size_t expected = is("transform") ? 16 : 3;
        if (!type || type->is_array || type->components != expected || !isReal(type->number))
            refuse("has the type " + std::string(attribute->type));
        const std::vector<double> numbers =
            usdaNumbers(attribute->valueAt(time_), *type, file_ + ": " + prim_path + "." + name).real;
        UsdaTransform map;
        if (numbers.empty()) return map;
        for (std::size_t k = 0; k < 3; ++k) {
            if (is("translate")) map.rows[3][k] = numbers[k];
            if (is("scale")) map.rows[k][k] = numbers[k];
            if (is("transform"))
                for (std::size_t i = 0; i < 4; ++i) map.rows[i][k] = numbers[4 * i + k];
        }
        if (is("transform") && (numbers[3] != 0 || numbers[7] != 0 || numbers[11] != 0 || numbers[15] != 1))
            refuse("is not an affine matrix");
        return map;
    }

    std::vector<std::int64_t> integersOf(const UsdaPrim& prim, const char* name) {
        const UsdaAttribute* attribute = prim.find(name);
        if (attribute == nullptr) fail(path_ + ": the mesh has no " + name);
        const UsdaType type = typeOf(*attribute);
        if (isReal(type.number) || type.components != 1) fail(where(*attribute) + " is not of the type int[]");
        return numbersOf(*attribute, type).integer;
    }

    void readFaces(const UsdaPrim& prim, std::size_t n, bool is_mirrored) {
        const std::vector<std::int64_t> counts = integersOf(prim, "faceVertexCounts"),
                                        indices = integersOf(prim, "faceVertexIndices");
        const UsdaAttribute* orientation = prim.find("orientation");
        const bool is_left = orientation != nullptr && unquoted(orientation->valueAt(time_)) == "leftHanded";
        const UsdaAttribute* component = prim.find("primvars:" + std::string(kComponent));
        std::vector<std::int64_t> components;
        if (component != nullptr && unquoted(component->interpolation) == "uniform" && component->type == "int[]") {
            components = numbersOf(*component, typeOf(*component)).integer;
            if (components.size() != counts.size())
                fail(where(*component) + " has " + std::to_string(components.size()) + " numbers, but there are " +
                     std::to_string(counts.size()) + " faces");
            any_component_ = true;
        } else {
            faces_without_component_ |= !counts.empty();
        }
        const auto first = static_cast<std::uint32_t>(points_);
        std::size_t at = 0;
        std::vector<std::uint32_t> corners;
        for (std::size_t face = 0; face < counts.size(); ++face) {
            const std::int64_t count = counts[face];
            if (count < 0 || static_cast<std::uint64_t>(count) > indices.size() - at)
                fail(path_ + ": face " + std::to_string(face) + " has " + std::to_string(count) +
                     " corners, but only " + std::to_string(indices.size() - at) + " faceVertexIndices are left");
            corners.clear();
            for (std::int64_t k = 0; k < count; ++k, ++at) {
                if (indices[at] < 0 || static_cast<std::uint64_t>(indices[at]) >= n)
                    fail(path_ + ": face " + std::to_string(face) + " has point " + std::to_string(indices[at]) +
                         ", but there are only " + std::to_string(n) + " points");
                corners.push_back(first + static_cast<std::uint32_t>(indices[at]));
            }
            if (is_left != is_mirrored) std::reverse(corners.begin(), corners.end());
            appendFan(corners, contents_.triangles);
            component_.resize(contents_.triangles.size(),
                              components.empty() ? 0 : static_cast<std::int32_t>(components[face]));
        }
        if (at < indices.size())
            fail(path_ + ": " + std::to_string(indices.size() - at) + " faceVertexIndices belong to no face");
    }

    const UsdaStage& stage_;
    const std::string& file_;
    const ReadOptions& options_;
    FileContents contents_;
    std::vector<Block> blocks_;       // of the prims read so far
    std::size_t points_ = 0;          // in them
    std::vector<std::size_t> index_;  // of the prim of each of contents_.grids
    std::string path_;                // of the prim that is read
    double time_ = 0;                 // of its values
    std::set<std::string> names_;     // of its attributes
    std::vector<std::int32_t> component_;
    bool any_component_ = false, faces_without_component_ = false;
};

}  // namespace

FileContents parseUsda(Cursor in, const ReadOptions& options) {
    const std::string text = wholeText(in);
    const UsdaStage stage = parseUsdaStage(text, in.file());
    return Reader(stage, in.file(), options).read();
}

std::vector<double> usdaSampleTimes(Cursor in, const ReadOptions& options) {
    const std::string text = wholeText(in);
    const UsdaStage stage = parseUsdaStage(text, in.file());
    return Reader(stage, in.file(), options).sampleTimes();
}

}  // namespace betamesh
