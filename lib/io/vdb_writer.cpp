// Writes OpenVDB points.

#include "io/vdb.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/file_contents.h"
#include "io/vdb_file.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/points/PointGroup.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <string_view>
#include <tuple>
#include <utility>

namespace betamesh {

namespace {

namespace vdb = openvdb;
namespace points = openvdb::points;

constexpr double kPointsPerVoxel = 8;
constexpr int kLeafBits = 3;  // a leaf has 8 voxels along each axis
constexpr std::int32_t kInLeafMask = (1 << kLeafBits) - 1;
constexpr double kMaxVoxelIndex = 1 << 28;  // well within 32 bits
constexpr double kMinExponent = -16;        // OpenVDB treats a voxel volume below 3e-15 as zero
constexpr double kMaxExponent = 120;

/// Voxel size for about kPointsPerVoxel points per voxel, assuming that they are evenly distributed over the axes along
/// which they extend. A power of two, so that dividing by it is exact.
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
    const double min_exponent = farthest > 0 ? std::ceil(std::log2(farthest / kMaxVoxelIndex)) : exponent;
    return std::exp2(std::round(std::clamp(std::max(exponent, min_exponent), kMinExponent, kMaxExponent)));
}

/// Position of a point in the grid, and its row among the particles.
struct GridPoint {
    vdb::Coord leaf;
    std::uint32_t voxel;  ///< index in the leaf
    std::uint32_t row;
    vdb::Vec3f offset;  ///< from the voxel's centre, in voxels, each within [-0.5, 0.5]
};

GridPoint gridPoint(const Vec3f& position, double voxel_size, std::size_t row) {
    GridPoint point{};
    vdb::Coord voxel;
    for (int axis = 0; axis < 3; ++axis) {
        const double index = double{position[axis]} / voxel_size;
        const double nearest = std::floor(index + 0.5);
        voxel[axis] = static_cast<std::int32_t>(nearest);
        point.offset[axis] = static_cast<float>(index - nearest);
    }
    point.leaf = vdb::Coord(voxel.x() & ~kInLeafMask, voxel.y() & ~kInLeafMask, voxel.z() & ~kInLeafMask);
    point.voxel = points::PointDataTree::LeafNodeType::coordToOffset(voxel);
    point.row = static_cast<std::uint32_t>(row);
    return point;
}

std::vector<GridPoint> sortedGridPoints(const std::vector<Vec3f>& positions, double voxel_size) {
    std::vector<GridPoint> grid_points(positions.size());
    parallelFor(grid_points.size(), 10000,
                [&](std::size_t i) { grid_points[i] = gridPoint(positions[i], voxel_size, i); });
    parallelSort(grid_points, [](const GridPoint& a, const GridPoint& b) {
        return std::tie(a.leaf, a.voxel, a.row) < std::tie(b.leaf, b.voxel, b.row);
    });
    return grid_points;
}

using Leaf = points::PointDataTree::LeafNodeType;

/// A leaf and its points.
struct LeafRange {
    Leaf* leaf;
    std::span<const GridPoint> grid_points;
};

using PositionArray = points::TypedAttributeArray<vdb::Vec3f, points::NullCodec>;

std::vector<LeafRange> makeLeaves(points::PointDataTree& tree, std::span<const GridPoint> grid_points) {
    const auto descriptor = points::AttributeSet::Descriptor::create(PositionArray::attributeType());
    std::vector<LeafRange> leaves;
    for (std::size_t begin = 0; begin < grid_points.size();) {
        std::size_t end = begin;
        std::vector<Leaf::ValueType> ends(Leaf::SIZE, 0);  // of each voxel's range of points in the leaf
        for (; end < grid_points.size() && grid_points[end].leaf == grid_points[begin].leaf; ++end)
            ends[grid_points[end].voxel] = static_cast<vdb::Index32>(end + 1 - begin);
        for (std::size_t v = 1; v < ends.size(); ++v) ends[v] = std::max<vdb::Index32>(ends[v], ends[v - 1]);

        Leaf* leaf = tree.touchLeaf(grid_points[begin].leaf);
        leaf->initializeAttributes(descriptor, static_cast<vdb::Index>(end - begin));
        leaf->setOffsets(ends);
        points::AttributeWriteHandle<vdb::Vec3f, points::NullCodec> handle(leaf->attributeArray("P"));
        for (std::size_t i = begin; i < end; ++i) handle.set(static_cast<vdb::Index>(i - begin), grid_points[i].offset);
        leaves.push_back({leaf, grid_points.subspan(begin, end - begin)});
        begin = end;
    }
    return leaves;
}

/// valueAt(row, k): value k of particle `row`.
template <typename Value, typename ValueAt>
void addAttribute(points::PointDataTree& tree, const std::vector<LeafRange>& leaves, const std::string& name,
                  std::uint32_t stride, const ValueAt& valueAt) {
    points::appendAttribute<Value>(tree, name, vdb::zeroVal<Value>(), stride);
    for (const LeafRange& range : leaves) {
        points::AttributeWriteHandle<Value> handle(range.leaf->attributeArray(name));
        for (std::size_t i = 0; i < range.grid_points.size(); ++i)
            for (std::uint32_t k = 0; k < stride; ++k)
                handle.set(static_cast<vdb::Index>(i), k, valueAt(range.grid_points[i].row, k));
    }
}

/// member: 1 for the particles in the group, 0 for the others.
void addGroup(points::PointDataTree& tree, const std::vector<LeafRange>& leaves, const std::string& name,
              const std::vector<std::int32_t>& member) {
    points::appendGroup(tree, name);
    for (const LeafRange& range : leaves) {
        points::GroupWriteHandle handle = range.leaf->groupWriteHandle(name);
        for (std::size_t i = 0; i < range.grid_points.size(); ++i)
            if (member[range.grid_points[i].row] != 0) handle.set(static_cast<vdb::Index>(i), true);
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
        if (isPointGroup(a)) {
            addGroup(tree, leaves, a.name.substr(kGroupPrefix.size()), a.integer);
            continue;
        }
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

/// Writes an archive to memory, because OpenVDB does not report all errors of the disk.
class MemoryArchive : public vdb::io::Archive {
public:
    std::string bytesOf(const vdb::GridCPtrVec& grids) const {
        std::ostringstream out(std::ios::binary);
        Archive::write(out, grids, /*seekable=*/true);
        if (!out) throw std::bad_alloc();
        return std::move(out).str();
    }
};

/// Replaces the random UUID that OpenVDB writes by a hash of the rest of the file (two FNV-1a hashes in the form of a
/// UUID of version 4), so that the same grids give the same bytes.
void replaceUuid(std::string& bytes) {
    constexpr std::size_t kOffset = 8 + 3 * 4 + 1;  // after magic, three version numbers and a flag
    constexpr std::string_view kForm = "xxxxxxxx-xxxx-4xxx-8xxx-xxxxxxxxxxxx";
    if (bytes.size() < kOffset + kForm.size() || bytes[kOffset + 8] != '-') return;
    std::array<std::uint64_t, 2> hash{0xcbf29ce484222325, 0x84222325cbf29ce4};
    for (std::size_t i = kOffset + kForm.size(); i < bytes.size(); ++i)
        for (std::uint64_t& h : hash) h = (h ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3;
    for (std::size_t i = 0; i < kForm.size(); ++i) {
        const std::uint64_t digit = hash[i % 2] >> (3 * i % 60) & 15;
        bytes[kOffset + i] = kForm[i] == 'x' ? "0123456789abcdef"[digit] : kForm[i];
    }
}

}  // namespace

std::string archiveOf(const vdb::GridCPtrVec& grids) {
    std::string bytes = MemoryArchive().bytesOf(grids);
    replaceUuid(bytes);
    return bytes;
}

std::string encodeVdb(const Particles& particles, const std::string& file) {
    initializeVdb();
    requireWritable(particles, file);
    requireWritable(particles.attributes, particles.size(), {"P", "v", "id"}, file);
    if (particles.size() > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + ": " + std::to_string(particles.size()) +
                    " particles are too many for a .vdb file, which can store 2^32 - 1");
    try {
        const double voxel_size = voxelSize(particles.position);
        const std::vector<GridPoint> grid_points = sortedGridPoints(particles.position, voxel_size);
        auto tree = std::make_shared<points::PointDataTree>();
        addAttributes(*tree, makeLeaves(*tree, grid_points), particles);
        const auto grid = points::PointDataGrid::create(tree);
        grid->setName("points");
        grid->setTransform(vdb::math::Transform::createLinearTransform(voxel_size));
        return archiveOf({grid});
    } catch (const vdb::Exception& error) {
        throw Error(file + ": " + error.what());
    }
}

}  // namespace betamesh
