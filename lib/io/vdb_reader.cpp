// Wrapper of OpenVDB: reads OpenVDB points.
//
// Read: all grids of type PointDataGrid, with any codec.
// Format: sources of OpenVDB, points/.

#include "io/vdb.h"

#include "base/lower_case.h"
#include "betamesh/error.h"
#include "io/vdb_file.h"
#include "io/vdb_grid_file.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <array>
#include <exception>
#include <ios>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <string_view>
#include <utility>

namespace betamesh {

namespace {

namespace vdb = openvdb;
namespace points = openvdb::points;

/// The numbers that a value type of OpenVDB consists of.
struct ColumnKind {
    std::uint32_t components = 0;  ///< 0: not supported
    bool is_integer = false;
};

ColumnKind kindOf(const std::string& value_type) {
    for (const char* real : {"float", "double"})
        if (value_type == real) return {1, false};
    for (const char* integer : {"bool", "int8", "int16", "int32", "int64"})
        if (value_type == integer) return {1, true};
    for (const char* real : {"vec3s", "vec3d"})
        if (value_type == real) return {3, false};
    if (value_type == "vec3i") return {3, true};
    return {};
}

/// One attribute; either `reals` or `integers` is filled.
struct Column {
    std::string name;
    std::string value_type;
    std::uint32_t components = 0;
    bool is_integer = false;
    std::vector<float> reals{};
    std::vector<std::int64_t> integers{};
};

template <typename Value>
void appendValues(const points::AttributeArray& array, Column& column) {
    const points::AttributeHandle<Value> handle(array);
    const vdb::Index stride = array.stride();
    for (vdb::Index i = 0; i < handle.size(); ++i)
        for (vdb::Index k = 0; k < stride; ++k) {
            const Value value = handle.get(i, k);
            if constexpr (std::is_arithmetic_v<Value>) {
                if constexpr (std::is_floating_point_v<Value>)
                    column.reals.push_back(static_cast<float>(value));
                else
                    column.integers.push_back(static_cast<std::int64_t>(value));
            } else {
                for (int axis = 0; axis < 3; ++axis) {
                    if constexpr (std::is_floating_point_v<typename Value::ValueType>)
                        column.reals.push_back(static_cast<float>(value[axis]));
                    else
                        column.integers.push_back(static_cast<std::int64_t>(value[axis]));
                }
            }
        }
}

void appendValues(const points::AttributeArray& array, const std::string& value_type, Column& column) {
    if (value_type == "float") return appendValues<float>(array, column);
    if (value_type == "double") return appendValues<double>(array, column);
    if (value_type == "bool") return appendValues<bool>(array, column);
    if (value_type == "int8") return appendValues<std::int8_t>(array, column);
    if (value_type == "int16") return appendValues<std::int16_t>(array, column);
    if (value_type == "int32") return appendValues<std::int32_t>(array, column);
    if (value_type == "int64") return appendValues<std::int64_t>(array, column);
    if (value_type == "vec3s") return appendValues<vdb::Vec3f>(array, column);
    if (value_type == "vec3d") return appendValues<vdb::Vec3d>(array, column);
    if (value_type == "vec3i") return appendValues<vdb::Vec3i>(array, column);
}

template <typename Value>
void appendPositions(const points::PointDataTree::LeafNodeType& leaf, const points::AttributeArray& array,
                     const vdb::math::Transform& transform, const Vec3& origin, std::vector<Vec3f>& positions) {
    const points::AttributeHandle<Value> handle(array);
    for (auto it = leaf.beginIndexAll(); it; ++it) {
        const vdb::Vec3d p = transform.indexToWorld(it.getCoord().asVec3d() + vdb::Vec3d(handle.get(*it)));
        positions.emplace_back(static_cast<float>(p.x() - origin.x), static_cast<float>(p.y() - origin.y),
                               static_cast<float>(p.z() - origin.z));
    }
}

/// An exception thrown by the function that receives the points; wrapped so that it is not reported as a reading error.
struct ReceiverError {
    std::exception_ptr exception;
};

using Leaf = points::PointDataTree::LeafNodeType;

class GridReader {
public:
    GridReader(FileContents& contents, const ReadOptions& options) : contents_(contents), options_(options) {}

    /// Reads leaf by leaf and frees each leaf's attributes afterwards.
    void read(points::PointDataGrid& grid, const std::string& name) {
        const vdb::Index64 points = vdb::points::pointCount(grid.tree());
        std::vector<Leaf*> leaves;
        for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) leaves.push_back(leaf.getLeaf());
        has_points_ |= points > 0;
        if (leaves.empty()) return;
        declare(leaves.front()->attributeSet());
        if (points == 0) return;  // so that it does not take away attributes that it lacks
        setColumns(leaves.front()->attributeSet(), name);
        for (Leaf* leaf : leaves) {
            readLeaf(*leaf, grid.transform());
            leaf->clearAttributes();
            if (positions_.size() >= kRowsAtOnce || leaf == leaves.back()) deliverPoints(points);
        }
    }

    bool hasPoints() const { return has_points_; }

    /// Tells which attributes are left out because not all grids have them.
    void reportIncomplete() const {
        for (const auto& [attribute, why] : incomplete_) {
            const bool is_motion = std::ranges::count(kMotion, lowerCase(attribute)) > 0;
            std::vector<std::string>& list = is_motion ? contents_.warnings : contents_.passed_over;
            list.push_back("attribute '" + attribute + "'" + (is_motion ? " is left out: " : ": ") + why);
        }
    }

private:
    static constexpr std::size_t kRowsAtOnce = 1 << 14;
    static constexpr const char* kGroupType = "group";
    static constexpr std::array<std::string_view, 5> kMotion = {"v", "vel", "velocity", "accel", "acceleration"};

    /// An attribute as the first grid that has it stores it.
    struct FirstSeen {
        std::string grid;
        std::uint32_t components = 0;
        bool is_integer = false;
    };

    /// Ones for the points of a leaf that are members of a group, zeros for the others.
    static void appendMembers(const Leaf& leaf, Column& column) {
        const std::string group = column.name.substr(kGroupPrefix.size());
        const points::AttributeSet& attributes = leaf.attributeSet();
        const vdb::Index n = attributes.getConst("P")->size();
        if (!attributes.descriptor().hasGroup(group)) {
            column.integers.resize(column.integers.size() + n);
            return;
        }
        const points::GroupHandle members = leaf.groupHandle(group);
        for (vdb::Index i = 0; i < n; ++i) column.integers.push_back(members.get(i));
    }

    static std::vector<std::string> namesIn(const points::AttributeSet& attributes) {
        std::vector<std::string> names(attributes.size());
        for (const auto& [name, position] : attributes.descriptor().map()) names.at(position) = name;
        return names;
    }

    /// Notes which attributes and groups a grid has.
    void declare(const points::AttributeSet& attributes) {
        const std::vector<std::string> names = namesIn(attributes);
        for (std::size_t i = 0; i < names.size(); ++i) declareInfo(names[i], *attributes.getConst(i));
        for (const auto& [name, position] : attributes.descriptor().groupMap()) {
            if (std::find(contents_.groups.begin(), contents_.groups.end(), name) != contents_.groups.end()) continue;
            contents_.groups.push_back(name);
            if (options_.all_groups && has_delivered_)  // the points of earlier grids came without it
                contents_.passed_over.push_back("group '" + name + "', which the first point grid does not have");
        }
    }

    /// Sets up the columns of a grid, in the order of its attributes. Leaves out attributes that have a different type
    /// in an earlier grid.
    void setColumns(const points::AttributeSet& attributes, const std::string& grid) {
        const std::vector<std::string> names = namesIn(attributes);
        columns_.clear();
        std::set<std::string> readable;
        const auto leaveOut = [&](const std::string& name, const std::string& with, const std::string& without,
                                  const char* why) {
            incomplete_.try_emplace(name, "grid '" + with + "' has it, but in grid '" + without + "' it " + why);
        };
        for (std::size_t i = 0; i < names.size(); ++i) {
            const points::AttributeArray& array = *attributes.getConst(i);
            const ColumnKind kind = kindOf(array.valueType());
            if (names[i] == "P" || kind.components == 0 || points::isGroup(array) || !array.hasConstantStride() ||
                !options_.attributes)
                continue;
            const std::uint32_t components = kind.components * array.stride();
            const auto [known, is_new] = known_.try_emplace(names[i], FirstSeen{grid, components, kind.is_integer});
            const FirstSeen& first = known->second;
            readable.insert(names[i]);
            if (is_new && has_delivered_) leaveOut(names[i], grid, first_grid_, "is missing");
            if (first.components == components && first.is_integer == kind.is_integer)
                columns_.push_back({names[i], array.valueType(), components, kind.is_integer});
            else
                leaveOut(names[i], first.grid, grid, "has another type");
        }
        for (const auto& [name, first] : known_)
            if (!readable.contains(name)) leaveOut(name, first.grid, grid, "is missing");
        if (!has_delivered_) first_grid_ = grid;
        std::set<std::string> groups(options_.groups.begin(), options_.groups.end());
        if (options_.all_groups) groups.insert(contents_.groups.begin(), contents_.groups.end());
        for (const std::string& name : groups)
            columns_.push_back({std::string(kGroupPrefix) + name, kGroupType, 1, true});
    }

    void declareInfo(const std::string& name, const points::AttributeArray& array) {
        for (const AttributeInfo& known : contents_.declared)
            if (known.name == name) return;
        const std::string codec = array.codecType() == "null" ? "" : array.codecType();
        const std::uint32_t components = std::max(1U, kindOf(array.valueType()).components);
        contents_.declared.push_back(
            {name, points::isGroup(array) ? "group" : array.valueType(), components * array.stride(), codec});
    }

    void readLeaf(const Leaf& leaf, const vdb::math::Transform& transform) {
        leaf.validateOffsets();
        const points::AttributeSet& attributes = leaf.attributeSet();
        const points::AttributeArray* position = attributes.getConst("P");
        if (position == nullptr) throw Error("the point positions (attribute 'P') are missing in a part of the grid");
        if (position->valueType() == "vec3d")
            appendPositions<vdb::Vec3d>(leaf, *position, transform, options_.origin, positions_);
        else
            appendPositions<vdb::Vec3f>(leaf, *position, transform, options_.origin, positions_);
        for (Column& column : columns_) {
            if (column.value_type == kGroupType) {
                appendMembers(leaf, column);
                continue;
            }
            const points::AttributeArray* array = attributes.getConst(column.name);
            if (array == nullptr) continue;
            if (array->size() != position->size())
                throw Error("attribute '" + column.name + "' has " + std::to_string(array->size()) +
                            " rows, but 'P' has " + std::to_string(position->size()));
            appendValues(*array, column.value_type, column);
        }
    }

    /// Delivers the points read so far. Leaves out attributes that are missing in some leaves.
    void deliverPoints(std::uint64_t total) {
        has_delivered_ = true;
        FileContents rows;
        rows.position = std::exchange(positions_, {});
        for (Column& column : columns_) {
            const std::vector<float> reals = std::exchange(column.reals, {});
            std::vector<std::int64_t> integers = std::exchange(column.integers, {});
            const std::size_t numbers = column.is_integer ? integers.size() : reals.size();
            if (numbers != rows.position.size() * column.components) continue;
            if (column.is_integer && column.components == 1 && column.name == options_.id) {
                rows.id.assign(integers.begin(), integers.end());
            } else if (column.is_integer) {
                rows.attributes.push_back(integerAttribute(column.name, column.components, std::move(integers)));
            } else {
                rows.attributes.push_back({column.name, column.components, reals, {}});
            }
        }
        try {
            deliver(std::move(rows), total, options_, contents_);
        } catch (...) {
            throw ReceiverError{std::current_exception()};
        }
    }

    FileContents& contents_;
    const ReadOptions& options_;
    std::map<std::string, FirstSeen> known_;         // by attribute name
    std::map<std::string, std::string> incomplete_;  // why attributes are left out, by their names
    std::string first_grid_;                         // that has points
    std::vector<Vec3f> positions_;
    std::vector<Column> columns_;
    bool has_points_ = false;
    bool has_delivered_ = false;
};

/// The names of the grids of a type in quotes. type: empty: of all types.
std::string gridNames(const std::vector<GridInfo>& grids, const std::string& type) {
    std::string names;
    for (const GridInfo& grid : grids)
        if (type.empty() || grid.type == type) names += (names.empty() ? "'" : ", '") + grid.name + "'";
    return names.empty() ? "no grids" : names;
}

VolumeInfo volumeInfo(const vdb::GridBase& grid, const std::string& name) {
    VolumeInfo info{name, grid.valueType(), vdb::GridBase::gridClassToString(grid.getGridClass()), grid.voxelSize().x(),
                    grid.activeVoxelCount()};
    if (info.voxels == 0) return info;
    const vdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    const vdb::Vec3d lower = grid.indexToWorld(box.min()), upper = grid.indexToWorld(box.max());
    info.lower = Vec3(lower.x(), lower.y(), lower.z());
    info.upper = Vec3(upper.x(), upper.y(), upper.z());
    return info;
}

FileContents readGrids(const std::string& path, const ReadOptions& options) {
    GridFile file(path);
    FileContents contents;
    GridReader reader(contents, options);
    std::size_t point_grids = 0, grids_read = 0;
    for (const auto& [name, descriptor] : file.descriptors()) {
        const bool has_points = descriptor.gridType() == points::PointDataGrid::gridType();
        point_grids += has_points;
        const bool is_wanted =
            options.grids.empty() || std::find(options.grids.begin(), options.grids.end(), name) != options.grids.end();
        contents.grids.push_back({name, has_points ? "points" : descriptor.gridType(), has_points && is_wanted});
        if (!has_points || !is_wanted) continue;
        ++grids_read;
        const auto grid = vdb::gridPtrCast<points::PointDataGrid>(file.read(descriptor));
        const auto compression = grid->getMetadata<vdb::StringMetadata>(vdb::GridBase::META_FILE_COMPRESSION);
        if (compression && contents.format.empty()) contents.format = "vdb points, " + compression->value();
        reader.read(*grid, name);
    }
    reader.reportIncomplete();
    if (point_grids == 0 && options.summary && !file.descriptors().empty()) {
        for (const auto& [name, descriptor] : file.descriptors())
            contents.volumes.push_back(volumeInfo(*file.read(descriptor), name));
        contents.format = "vdb volumes";
        return contents;
    }
    if (point_grids == 0)
        throw Error("contains no point grid (found " + gridNames(contents.grids, "") +
                    "). Export the particles as OpenVDB points.");
    for (const std::string& wanted : options.grids)
        if (std::none_of(contents.grids.begin(), contents.grids.end(),
                         [&](const GridInfo& grid) { return grid.is_read && grid.name == wanted; }))
            throw Error("has no point grid '" + wanted + "'. The point grids are " +
                        gridNames(contents.grids, "points") + ".");
    for (const std::string& wanted : options.groups)
        if (reader.hasPoints() &&
            std::find(contents.groups.begin(), contents.groups.end(), wanted) == contents.groups.end())
            throw Error(unknownGroup(wanted, contents.groups));
    if (contents.format.empty()) contents.format = "vdb points";
    if (grids_read > 1) contents.format += ", " + std::to_string(grids_read) + " grids";
    return contents;
}

/// Whether a block of bytes_per_byte times the size of a file, plus some for decompression, could be allocated now.
bool hasMemoryFor(const std::filesystem::path& path, std::uintmax_t bytes_per_byte) {
    constexpr std::uintmax_t kDecompression = std::uintmax_t{16} << 20;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) return true;
    void* const block = ::operator new(static_cast<std::size_t>(size * bytes_per_byte + kDecompression), std::nothrow);
    ::operator delete(block);
    return block != nullptr;
}

}  // namespace

FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options) {
    // Bytes per byte of the file: fewer than any frame needs, and more than any undamaged file needs.
    constexpr std::uintmax_t kMinMemory = 8, kMaxMemory = 64;
    initializeVdb();
    if (!hasMemoryFor(path, kMinMemory)) throw std::bad_alloc();  // otherwise Blosc would terminate the process
    try {
        return readGrids(path.string(), options);
    } catch (const ReceiverError& error) {
        std::rethrow_exception(error.exception);
    } catch (const std::ios_base::failure&) {
        throw Error(path.string() + ": the file is damaged, or cannot be read to its end");
    } catch (const std::bad_alloc&) {
        if (!hasMemoryFor(path, kMaxMemory)) throw;
        throw Error(path.string() + ": the file is damaged: it asks for too much memory");
    } catch (const FileError& error) {
        throw FileError(path.string() + ": " + error.what(), error.errorNumber());
    } catch (const std::exception& error) {
        throw Error(path.string() + ": " + error.what());
    }
}

void initializeVdb() {
    static std::once_flag once;
    std::call_once(once, [] { vdb::initialize(); });
}

}  // namespace betamesh
