// The wrapper of OpenVDB.

#include "io/vdb.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/bytes.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <exception>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

namespace betamesh {

namespace {

namespace vdb = openvdb;
namespace points = openvdb::points;

constexpr bool kOtherOrder = std::endian::native != std::endian::little;

void initialize() {
    static std::once_flag once;
    std::call_once(once, [] { vdb::initialize(); });
}

// Reading.

std::uint32_t readNumber(Cursor& in, const char* what) {
    return loadNumber<std::uint32_t>(in.take(4, what), kOtherOrder);
}

/// A length, and as many bytes.
void skipText(Cursor& in, const char* what) { in.take(readNumber(in, what), what); }

/// A number of names, each with a type and a value.
void skipMetadata(Cursor& in) {
    for (std::uint32_t left = readNumber(in, "metadata"); left > 0; --left)
        for (int text = 0; text < 3; ++text) skipText(in, "metadata");
}

/// Fails when the file ends before the last of its grids does, or a text before its length says. OpenVDB itself
/// reads on regardless, takes gigabytes, and may end the process; files cut short by a full disk or a killed
/// simulation are no rarity.
///
/// source  OpenVDB, io/Archive.cc and io/GridDescriptor.cc: little-endian magic (8), file version, library
///         version (2 times 4), flag of grid offsets (1), UUID (36), metadata, int32 grids; of each grid name,
///         type, parent, and where its header, its blocks and the grid end, from the start of the file; the
///         header: compression (4), metadata, type of the transform
void requireComplete(const std::string& path) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;  // more than the names and metadata in any one place
    constexpr std::uint32_t kOldestKnown = 222;
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    if (!stream) throw Error("cannot be read: " + std::generic_category().message(errno));
    const auto size = static_cast<std::int64_t>(stream.tellg());
    const auto pieceAt = [&](std::int64_t at) {
        Bytes bytes(static_cast<std::size_t>(std::min<std::int64_t>(kPiece, size - at)));
        stream.seekg(at);
        stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!stream) throw Error("cannot be read");
        return bytes;
    };
    Bytes piece = pieceAt(0);
    Cursor in(piece, "file header");
    if (loadNumber<std::int64_t>(in.take(8, "magic"), kOtherOrder) != vdb::OPENVDB_MAGIC)
        throw Error("expected an OpenVDB file, the magic number is another");
    if (readNumber(in, "version") < kOldestKnown) return;
    in.take(8, "library version");
    if (*in.take(1, "flags") == std::byte{0}) return;  // written to a pipe: does not tell where its grids end
    in.take(36, "UUID");
    skipMetadata(in);
    const std::uint32_t grids = readNumber(in, "number of grids");
    std::int64_t at = static_cast<std::int64_t>(in.offset());
    for (std::uint32_t i = 0; i < grids; ++i) {
        piece = pieceAt(at);
        Cursor descriptor(piece, "grid " + std::to_string(i));
        for (int text = 0; text < 3; ++text) skipText(descriptor, "names");
        const auto position = [&](const char* what, std::int64_t least) {
            const auto place = loadNumber<std::int64_t>(descriptor.take(8, what), kOtherOrder);
            if (place < least || place > size)
                throw Error("grid " + std::to_string(i) + ": " + what + " at byte " + std::to_string(place) +
                            ", the file has " + std::to_string(size) + " (truncated, or damaged)");
            return place;
        };
        const std::int64_t header = position("header", at);
        position("blocks", 0);  // 0 in a grid that shares the tree of another
        at = position("end", header);
        const Bytes header_piece = pieceAt(header);
        Cursor in_header(header_piece, "header of grid " + std::to_string(i));
        in_header.take(4, "compression");
        skipMetadata(in_header);
        skipText(in_header, "transform");
    }
}

/// How a value type of OpenVDB becomes a column: its numbers, whole or real.
struct ColumnKind {
    std::uint32_t components = 0;  ///< 0: none of ours
    bool whole = false;
};

ColumnKind kindOf(const std::string& value_type) {
    for (const char* real : {"float", "double"})
        if (value_type == real) return {1, false};
    for (const char* whole : {"bool", "int8", "int16", "int32", "int64"})
        if (value_type == whole) return {1, true};
    for (const char* real : {"vec3s", "vec3d"})
        if (value_type == real) return {3, false};
    if (value_type == "vec3i") return {3, true};
    return {};
}

/// One attribute. Exactly one of the two is filled.
struct Column {
    std::string name;
    std::string value_type;
    std::uint32_t components = 0;
    bool whole = false;
    std::vector<float> reals{};
    std::vector<std::int64_t> wholes{};
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
                    column.wholes.push_back(static_cast<std::int64_t>(value));
            } else {
                for (int axis = 0; axis < 3; ++axis) {
                    if constexpr (std::is_floating_point_v<typename Value::ValueType>)
                        column.reals.push_back(static_cast<float>(value[axis]));
                    else
                        column.wholes.push_back(static_cast<std::int64_t>(value[axis]));
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
                     const vdb::math::Transform& transform, std::vector<Vec3f>& positions) {
    const points::AttributeHandle<Value> handle(array);
    for (auto it = leaf.beginIndexAll(); it; ++it) {
        const vdb::Vec3d p = transform.indexToWorld(it.getCoord().asVec3d() + vdb::Vec3d(handle.get(*it)));
        positions.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    }
}

/// What went wrong with whoever takes the points.
struct NotOfReading {
    std::exception_ptr what;
};

using Leaf = points::PointDataTree::LeafNodeType;

class GridReader {
public:
    GridReader(FileContents& contents, const ReadOptions& options) : contents_(contents), options_(options) {}

    /// Leaf by leaf; each goes as it has been read.
    void read(points::PointDataGrid& grid) {
        const vdb::Index64 points = vdb::points::pointCount(grid.tree());
        std::vector<Leaf*> leaves;
        for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) leaves.push_back(leaf.getLeaf());
        if (leaves.empty()) return;
        declare(leaves.front()->attributeSet());
        for (Leaf* leaf : leaves) {
            readLeaf(*leaf, grid.transform());
            leaf->clearAttributes();
            if (positions_.size() >= kRowsAtOnce || leaf == leaves.back()) handOver(points);
        }
    }

private:
    static constexpr std::size_t kRowsAtOnce = 1 << 14;

    /// Columns of this grid, in the order of its attributes. One that an earlier grid has as something else is left
    /// out.
    void declare(const points::AttributeSet& attributes) {
        std::vector<std::string> names(attributes.size());
        for (const auto& [name, position] : attributes.descriptor().map()) names.at(position) = name;
        columns_.clear();
        for (std::size_t i = 0; i < names.size(); ++i) {
            const points::AttributeArray& array = *attributes.getConst(i);
            declareInfo(names[i], array);
            const ColumnKind kind = kindOf(array.valueType());
            if (names[i] == "P" || kind.components == 0 || points::isGroup(array) || !array.hasConstantStride() ||
                !options_.attributes)
                continue;
            const std::uint32_t components = kind.components * array.stride();
            const auto first = kinds_.try_emplace(names[i], components, kind.whole).first->second;
            if (first == std::pair(components, kind.whole))
                columns_.push_back({names[i], array.valueType(), components, kind.whole});
        }
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
        if (position == nullptr) throw Error("a leaf has no attribute 'P'");
        if (position->valueType() == "vec3d")
            appendPositions<vdb::Vec3d>(leaf, *position, transform, positions_);
        else
            appendPositions<vdb::Vec3f>(leaf, *position, transform, positions_);
        for (Column& column : columns_) {
            const points::AttributeArray* array = attributes.getConst(column.name);
            if (array == nullptr) continue;
            if (array->size() != position->size())
                throw Error("attribute '" + column.name + "' has " + std::to_string(array->size()) + " rows, 'P' " +
                            std::to_string(position->size()));
            appendValues(*array, column.value_type, column);
        }
    }

    /// A column that some leaf lacks has no row for every point: it is left out.
    void handOver(std::uint64_t all) {
        FileContents rows;
        rows.position = std::exchange(positions_, {});
        for (Column& column : columns_) {
            const std::vector<float> reals = std::exchange(column.reals, {});
            std::vector<std::int64_t> wholes = std::exchange(column.wholes, {});
            const std::size_t numbers = column.whole ? wholes.size() : reals.size();
            if (numbers != rows.position.size() * column.components) continue;
            if (column.whole && column.components == 1 && column.name == options_.id) {
                const bool short_id = column.value_type != "int64";
                for (const std::int64_t id : wholes)
                    rows.id.push_back(short_id ? static_cast<std::uint32_t>(static_cast<std::int32_t>(id))
                                               : static_cast<std::uint64_t>(id));
            } else if (column.whole) {
                rows.attributes.push_back(integerAttribute(column.name, column.components, std::move(wholes)));
            } else {
                rows.attributes.push_back({column.name, column.components, reals, {}});
            }
        }
        try {
            deliver(std::move(rows), all, options_, contents_);
        } catch (...) {
            throw NotOfReading{std::current_exception()};
        }
    }

    FileContents& contents_;
    const ReadOptions& options_;
    std::map<std::string, std::pair<std::uint32_t, bool>> kinds_;  // of columns: components, whether whole
    std::vector<Vec3f> positions_;
    std::vector<Column> columns_;
};

/// The grids of a file, read one at a time. Unlike vdb::io::File it fails at the end of the file: OpenVDB does not
/// check its streams while it reads a grid, and goes on with the last size it has read until memory runs out.
class GridFile : public vdb::io::Archive {
public:
    using Descriptor = vdb::io::GridDescriptor;

    explicit GridFile(const std::string& path) : stream_(path, std::ios::binary) {
        stream_.exceptions(std::ios::failbit | std::ios::badbit);
        stream_state_->setSeekable(true);
        vdb::io::setStreamMetadataPtr(stream_, stream_state_, /*transfer=*/false);
        readHeader(stream_);
        setFormatVersion(stream_);
        setLibraryVersion(stream_);
        setDataCompression(stream_);
        vdb::MetaMap().readMeta(stream_);
        for (std::int32_t left = readGridCount(stream_); left > 0; --left) {
            Descriptor descriptor;
            descriptor.read(stream_);
            if (inputHasGridOffsets())
                descriptor.seekToEnd(stream_);
            else  // the grid itself follows, and tells its end in no other way
                loaded_[descriptor.uniqueName()] = readHere(descriptor);
            descriptors_.emplace(descriptor.gridName(), descriptor);
        }
    }

    /// Sorted by name.
    const std::multimap<std::string, Descriptor>& descriptors() const { return descriptors_; }

    vdb::GridBase::Ptr read(const Descriptor& descriptor) {
        const vdb::GridBase::Ptr grid = readTree(descriptor);
        if (!descriptor.isInstance()) return grid;
        for (const auto& [name, parent] : descriptors_)
            if (parent.uniqueName() == descriptor.instanceParentName()) {
                grid->setTree(readTree(parent)->baseTreePtr());
                return grid;
            }
        throw Error("grid '" + descriptor.gridName() + "' shares the tree of a grid that is missing");
    }

private:
    vdb::GridBase::Ptr readTree(const Descriptor& descriptor) {
        if (!inputHasGridOffsets()) return loaded_.at(descriptor.uniqueName());
        descriptor.seekToGrid(stream_);
        return readHere(descriptor);
    }

    vdb::GridBase::Ptr readHere(const Descriptor& descriptor) {
        const vdb::GridBase::Ptr grid = vdb::GridBase::createGrid(descriptor.gridType());
        grid->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
        readGrid(grid, descriptor, stream_);
        return grid;
    }

    vdb::io::StreamMetadata::Ptr stream_state_ = std::make_shared<vdb::io::StreamMetadata>();
    std::ifstream stream_;  // refers to stream_state_
    std::multimap<std::string, Descriptor> descriptors_;
    std::map<std::string, vdb::GridBase::Ptr> loaded_;  // by unique name; only of files that cannot be read in parts
};

FileContents readGrids(const std::string& path, const ReadOptions& options) {
    requireComplete(path);
    GridFile file(path);
    FileContents contents;
    GridReader reader(contents, options);
    std::size_t point_grids = 0;
    std::string others;
    for (const auto& [name, descriptor] : file.descriptors()) {
        if (descriptor.gridType() != points::PointDataGrid::gridType()) {
            others += (others.empty() ? "'" : ", '") + name + "'";
            continue;
        }
        ++point_grids;
        const auto grid = vdb::gridPtrCast<points::PointDataGrid>(file.read(descriptor));
        const auto compression = grid->getMetadata<vdb::StringMetadata>(vdb::GridBase::META_FILE_COMPRESSION);
        if (compression && contents.format.empty()) contents.format = "vdb points, " + compression->value();
        reader.read(*grid);
    }
    if (point_grids == 0)
        throw Error("has no grid of points, expected one; found " + (others.empty() ? "no grid" : others));
    if (contents.format.empty()) contents.format = "vdb points";
    if (point_grids > 1) contents.format += ", " + std::to_string(point_grids) + " grids";
    return contents;
}

// Writing.

constexpr double kPointsPerVoxel = 8;
constexpr int kLeafBits = 3;  // a leaf has 8 voxels along each axis
constexpr std::int32_t kInLeaf = (1 << kLeafBits) - 1;
constexpr double kFarthestVoxel = 1 << 28;  // far within 32 bits
constexpr double kLeastExponent = -16;      // OpenVDB takes a volume below 3e-15 for zero
constexpr double kMostExponent = 120;

/// About kPointsPerVoxel points in each voxel, were they spread evenly over the axes they extend along; a power
/// of two, so that dividing by it loses nothing.
double voxelSize(const std::vector<Vec3f>& positions) {
    if (positions.empty()) return 1;
    Vec3 lower(positions[0]), upper(positions[0]);
    double farthest = 0;
    for (const Vec3f& p : positions)
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], double{p[axis]});
            upper[axis] = std::max(upper[axis], double{p[axis]});
            farthest = std::max(farthest, std::abs(double{p[axis]}));
        }
    double log_volume = 0;
    int axes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (upper[axis] == lower[axis]) continue;
        log_volume += std::log2(upper[axis] - lower[axis]);
        ++axes;
    }
    const double voxels = std::max(1.0, static_cast<double>(positions.size()) / kPointsPerVoxel);
    const double exponent = axes == 0 ? 0 : (log_volume - std::log2(voxels)) / axes;
    const double least = farthest > 0 ? std::ceil(std::log2(farthest / kFarthestVoxel)) : exponent;
    return std::exp2(std::round(std::clamp(std::max(exponent, least), kLeastExponent, kMostExponent)));
}

/// Where a point goes: leaf, voxel in it, row it came from.
struct Place {
    vdb::Coord leaf;
    std::uint32_t voxel;
    std::uint32_t row;
    vdb::Vec3f offset;  ///< from the voxel's centre, in voxels, each within [-0.5, 0.5]
};

Place placeOf(const Vec3f& position, double voxel_size, std::size_t row) {
    Place place{};
    vdb::Coord voxel;
    for (int axis = 0; axis < 3; ++axis) {
        const double index = double{position[axis]} / voxel_size;
        const double nearest = std::floor(index + 0.5);
        voxel[axis] = static_cast<std::int32_t>(nearest);
        place.offset[axis] = static_cast<float>(index - nearest);
    }
    place.leaf = vdb::Coord(voxel.x() & ~kInLeaf, voxel.y() & ~kInLeaf, voxel.z() & ~kInLeaf);
    place.voxel = points::PointDataTree::LeafNodeType::coordToOffset(voxel);
    place.row = static_cast<std::uint32_t>(row);
    return place;
}

std::vector<Place> sortedPlaces(const std::vector<Vec3f>& positions, double voxel_size) {
    std::vector<Place> places(positions.size());
    parallelFor(places.size(), 10000, [&](std::size_t i) { places[i] = placeOf(positions[i], voxel_size, i); });
    parallelSort(places, [](const Place& a, const Place& b) {
        return std::tie(a.leaf, a.voxel, a.row) < std::tie(b.leaf, b.voxel, b.row);
    });
    return places;
}

using Leaf = points::PointDataTree::LeafNodeType;

/// A leaf and the places that fall in it.
struct LeafRange {
    Leaf* leaf;
    std::span<const Place> places;
};

using PositionArray = points::TypedAttributeArray<vdb::Vec3f, points::NullCodec>;

std::vector<LeafRange> makeLeaves(points::PointDataTree& tree, std::span<const Place> places) {
    const auto descriptor = points::AttributeSet::Descriptor::create(PositionArray::attributeType());
    std::vector<LeafRange> leaves;
    for (std::size_t begin = 0; begin < places.size();) {
        std::size_t end = begin;
        std::vector<Leaf::ValueType> ends(Leaf::SIZE, 0);  // of each voxel's points within the leaf
        for (; end < places.size() && places[end].leaf == places[begin].leaf; ++end)
            ends[places[end].voxel] = static_cast<vdb::Index32>(end + 1 - begin);
        for (std::size_t v = 1; v < ends.size(); ++v) ends[v] = std::max<vdb::Index32>(ends[v], ends[v - 1]);

        Leaf* leaf = tree.touchLeaf(places[begin].leaf);
        leaf->initializeAttributes(descriptor, static_cast<vdb::Index>(end - begin));
        leaf->setOffsets(ends);
        points::AttributeWriteHandle<vdb::Vec3f, points::NullCodec> handle(leaf->attributeArray("P"));
        for (std::size_t i = begin; i < end; ++i) handle.set(static_cast<vdb::Index>(i - begin), places[i].offset);
        leaves.push_back({leaf, places.subspan(begin, end - begin)});
        begin = end;
    }
    return leaves;
}

/// valueAt(row, k): the k-th value of a row of the particles.
template <typename Value, typename ValueAt>
void addAttribute(points::PointDataTree& tree, const std::vector<LeafRange>& leaves, const std::string& name,
                  std::uint32_t stride, const ValueAt& valueAt) {
    points::appendAttribute<Value>(tree, name, vdb::zeroVal<Value>(), stride);
    for (const LeafRange& range : leaves) {
        points::AttributeWriteHandle<Value> handle(range.leaf->attributeArray(name));
        for (std::size_t i = 0; i < range.places.size(); ++i)
            for (std::uint32_t k = 0; k < stride; ++k)
                handle.set(static_cast<vdb::Index>(i), k, valueAt(range.places[i].row, k));
    }
}

void addAttributes(points::PointDataTree& tree, const std::vector<LeafRange>& leaves, const Particles& particles) {
    if (leaves.empty()) return;
    const auto vectorOf = [](const auto& numbers, std::size_t row) {
        return vdb::math::Vec3(numbers[3 * row], numbers[3 * row + 1], numbers[3 * row + 2]);
    };
    if (!particles.velocity.empty())
        addAttribute<vdb::Vec3f>(tree, leaves, "v", 1, [&](std::size_t row, std::uint32_t) {
            const Vec3f& v = particles.velocity[row];
            return vdb::Vec3f(v.x, v.y, v.z);
        });
    if (!particles.id.empty())
        addAttribute<std::int64_t>(tree, leaves, "id", 1, [&](std::size_t row, std::uint32_t) {
            return static_cast<std::int64_t>(particles.id[row]);
        });
    for (const Attribute& a : particles.attributes) {
        const bool vectors = a.components == 3;
        if (vectors && a.integer.empty())
            addAttribute<vdb::Vec3f>(tree, leaves, a.name, 1,
                                     [&](std::size_t row, std::uint32_t) { return vectorOf(a.real, row); });
        else if (vectors)
            addAttribute<vdb::Vec3i>(tree, leaves, a.name, 1,
                                     [&](std::size_t row, std::uint32_t) { return vectorOf(a.integer, row); });
        else if (a.integer.empty())
            addAttribute<float>(tree, leaves, a.name, a.components,
                                [&](std::size_t row, std::uint32_t k) { return a.real[row * a.components + k]; });
        else
            addAttribute<std::int32_t>(tree, leaves, a.name, a.components, [&](std::size_t row, std::uint32_t k) {
                return a.integer[row * a.components + k];
            });
    }
}

/// Writes a file into memory, where every error of the disk is ours to see.
class MemoryArchive : public vdb::io::Archive {
public:
    std::string bytesOf(const vdb::GridBase::ConstPtr& grid) const {
        std::ostringstream out(std::ios::binary);
        Archive::write(out, vdb::GridCPtrVec{grid}, /*seekable=*/true);
        if (!out) throw std::bad_alloc();
        return std::move(out).str();
    }
};

/// OpenVDB stamps every file with a random number. Ours is one of the rest of the file, so that the same
/// particles give the same bytes: FNV-1a, twice, written as a UUID of version 4.
void stamp(std::string& bytes) {
    constexpr std::size_t kAt = 8 + 3 * 4 + 1;  // after magic, three version numbers and a flag
    constexpr std::string_view kForm = "xxxxxxxx-xxxx-4xxx-8xxx-xxxxxxxxxxxx";
    if (bytes.size() < kAt + kForm.size() || bytes[kAt + 8] != '-') return;
    std::array<std::uint64_t, 2> hash{0xcbf29ce484222325, 0x84222325cbf29ce4};
    for (std::size_t i = kAt + kForm.size(); i < bytes.size(); ++i)
        for (std::uint64_t& h : hash) h = (h ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3;
    for (std::size_t i = 0; i < kForm.size(); ++i) {
        const std::uint64_t digit = hash[i % 2] >> (3 * i % 60) & 15;
        bytes[kAt + i] = kForm[i] == 'x' ? "0123456789abcdef"[digit] : kForm[i];
    }
}

/// Whether so many bytes for every byte of a file, and some for unpacking, could be had at this moment.
bool memoryFor(const std::filesystem::path& path, std::uintmax_t bytes_per_byte) {
    constexpr std::uintmax_t kUnpacking = std::uintmax_t{16} << 20;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) return true;
    void* const block = ::operator new(static_cast<std::size_t>(size * bytes_per_byte + kUnpacking), std::nothrow);
    ::operator delete(block);
    return block != nullptr;
}

}  // namespace

FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options) {
    // A frame takes far more than this in the end.
    constexpr std::uintmax_t kLeast = 8, kMost = 64;
    initialize();
    if (!memoryFor(path, kLeast)) throw std::bad_alloc();  // Blosc would end the process
    try {
        return readGrids(path.string(), options);
    } catch (const NotOfReading& error) {
        std::rethrow_exception(error.what);
    } catch (const std::ios_base::failure&) {
        throw Error(path.string() + ": the file is damaged, or cannot be read to its end");
    } catch (const std::bad_alloc&) {
        if (!memoryFor(path, kMost)) throw;
        throw Error(path.string() + ": the file is damaged and asks for too much memory");
    } catch (const std::exception& error) {
        throw Error(path.string() + ": " + error.what());
    }
}

std::string encodeVdb(const Particles& particles, const std::string& file) {
    initialize();
    requireWritable(particles, file);
    requireWritable(particles.attributes, particles.size(), {"P", "v", "id"}, file);
    if (particles.size() > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + ": " + std::to_string(particles.size()) + " particles, expected less than 2^32");
    try {
        const double voxel_size = voxelSize(particles.position);
        const std::vector<Place> places = sortedPlaces(particles.position, voxel_size);
        auto tree = std::make_shared<points::PointDataTree>();
        addAttributes(*tree, makeLeaves(*tree, places), particles);
        const auto grid = points::PointDataGrid::create(tree);
        grid->setName("points");
        grid->setTransform(vdb::math::Transform::createLinearTransform(voxel_size));
        std::string bytes = MemoryArchive().bytesOf(grid);
        stamp(bytes);
        return bytes;
    } catch (const vdb::Exception& error) {
        throw Error(file + ": " + error.what());
    }
}

}  // namespace betamesh
