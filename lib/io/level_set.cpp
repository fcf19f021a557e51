// Wrapper of OpenVDB: writes level sets.

#include "io/level_set.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/file_contents.h"
#include "io/vdb_file.h"
#include "mesh/components.h"
#include "mesh/mesh_edges.h"
#include "mesh/triangle_tree.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

namespace betamesh {

namespace {

namespace vdb = openvdb;

using Triangles = std::vector<Triangle>;

/// Distances to some triangles of a mesh.
class Distances {
public:
    Distances(const Mesh& mesh, double voxel, double band) : mesh_(mesh), voxel_(voxel), band_(band) {}

    /// Negative inside. Space that no path from infinity reaches is inside, whichever way the triangles face.
    vdb::FloatGrid::Ptr of(const Triangles& triangles) const {
        const auto transform = vdb::math::Transform::createLinearTransform(voxel_);
        const auto band = static_cast<float>(band_);
        if (triangles.empty()) {
            const auto grid = vdb::FloatGrid::create(band * static_cast<float>(voxel_));
            grid->setTransform(transform);
            return grid;
        }
        std::vector<vdb::Vec3s> points;  // in voxels; OpenVDB's library contains the conversion of this type
        points.reserve(mesh_.position.size());
        for (const Vec3& p : mesh_.position) points.emplace_back(vdb::Vec3d(p.x, p.y, p.z) / voxel_);
        std::vector<vdb::Vec3I> corners;
        corners.reserve(triangles.size());
        for (const Triangle& t : triangles) corners.emplace_back(t[0], t[1], t[2]);
        const vdb::tools::QuadAndTriangleDataAdapter<vdb::Vec3s, vdb::Vec3I> mesh(points, corners);
        vdb::util::NullInterrupter uninterrupted;
        // Renormalisation would smooth the surface where the mesh crosses itself, and shift it elsewhere.
        return vdb::tools::meshToVolume<vdb::FloatGrid>(uninterrupted, mesh, *transform, band, band,
                                                        vdb::tools::DISABLE_RENORMALIZATION);
    }

private:
    const Mesh& mesh_;
    double voxel_, band_;
};

/// A connected part of the mesh.
struct Shell {
    Triangles triangles;
    double volume = 0;
};

/// The shells of a mesh: those that bound liquid, and those that bound cavities in it.
struct Shells {
    std::vector<Shell> liquid, cavities;
};

Shells shellsOf(const Mesh& mesh) {
    const Components components = componentsOf(mesh.position.size(), mesh.triangles);
    std::vector<Shell> shells(components.count);
    double volume = 0;
    for (const Triangle& t : mesh.triangles) {
        Shell& shell = shells[components.of_vertex[t[0]]];
        const Vec3 origin = shell.triangles.empty() ? mesh.position[t[0]] : mesh.position[shell.triangles[0][0]];
        shell.triangles.push_back(t);
        shell.volume +=
            signedVolume(mesh.position[t[0]] - origin, mesh.position[t[1]] - origin, mesh.position[t[2]] - origin);
    }
    for (const Shell& shell : shells) volume += shell.volume;
    Shells sorted;
    for (Shell& shell : shells) {
        if (shell.triangles.empty()) continue;
        const bool is_cavity = volume < 0 ? shell.volume > 0 : shell.volume < 0;
        (is_cavity ? sorted.cavities : sorted.liquid).push_back(std::move(shell));
    }
    return sorted;
}

Triangles trianglesOf(const std::vector<Shell>& shells) {
    Triangles triangles;
    for (const Shell& shell : shells) triangles.insert(triangles.end(), shell.triangles.begin(), shell.triangles.end());
    return triangles;
}

/// Removes and returns the shells whose first vertex is inside a level set.
std::vector<Shell> takeInside(const vdb::FloatGrid& level_set, const Mesh& mesh, std::vector<Shell>& shells) {
    const auto inside = [&](const Shell& shell) {
        const Vec3& p = mesh.position[shell.triangles[0][0]];
        const vdb::Vec3d index = level_set.worldToIndex(vdb::Vec3d(p.x, p.y, p.z));
        return vdb::tools::BoxSampler::sample(level_set.tree(), index) < 0;
    };
    std::vector<Shell> taken, left;
    for (Shell& shell : shells) (inside(shell) ? taken : left).push_back(std::move(shell));
    shells = std::move(left);
    return taken;
}

/// OpenVDB fills cavities, and what is in them: they are converted by themselves and taken away.
vdb::FloatGrid::Ptr levelSetOf(const Mesh& mesh, const Distances& distances, Shells shells) {
    if (shells.cavities.empty()) return distances.of(trianglesOf(shells.liquid));
    const auto cavities = distances.of(trianglesOf(shells.cavities));
    Shells nested;  // liquid in cavities, with its own cavities
    nested.liquid = takeInside(*cavities, mesh, shells.liquid);
    if (shells.liquid.empty()) return distances.of(trianglesOf(nested.liquid));  // cavities without liquid around them
    const auto surface = distances.of(trianglesOf(shells.liquid));
    vdb::tools::csgDifference(*surface, *cavities);
    if (nested.liquid.empty()) return surface;
    nested.cavities = takeInside(*distances.of(trianglesOf(nested.liquid)), mesh, shells.cavities);
    vdb::tools::csgUnion(*surface, *levelSetOf(mesh, distances, std::move(nested)));
    return surface;
}

/// Barycentric weights of the point of a triangle that is nearest to a point: the foot of the perpendicular, or else
/// the nearest point of a side.
std::array<double, 3> nearestWeights(const Vec3& p, const std::array<Vec3, 3>& corner) {
    const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double squared = normal.length2();
    std::array<double, 3> weight{};
    bool is_above = squared > 0;
    for (std::size_t k = 0; k < 3 && is_above; ++k) {
        const Vec3 &a = corner[(k + 1) % 3], &b = corner[(k + 2) % 3];
        weight[k] = dot(cross(b - a, p - a), normal) / squared;
        is_above = weight[k] >= 0;
    }
    if (is_above) return weight;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = corner[k], &b = corner[(k + 1) % 3];
        const double length2 = (b - a).length2();
        const double along = length2 > 0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0;
        const double distance2 = (a + (b - a) * along - p).length2();
        if (distance2 >= least) continue;
        least = distance2;
        weight = {};
        weight[k] = 1 - along;
        weight[(k + 1) % 3] = along;
    }
    return weight;
}

/// Velocities of the nearest points of the mesh in the active voxels of a grid.
vdb::Vec3SGrid::Ptr velocityGrid(const Mesh& mesh, const vdb::FloatGrid& surface) {
    using Tree = vdb::Vec3STree;
    const auto tree = std::make_shared<Tree>(surface.tree(), vdb::Vec3s(0), vdb::TopologyCopy());
    const auto grid = vdb::Vec3SGrid::create(tree);
    grid->setTransform(surface.transform().copy());
    grid->setName("v");
    grid->setVectorType(vdb::VEC_CONTRAVARIANT_RELATIVE);
    if (mesh.velocity.empty()) return grid;
    std::vector<Tree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    const TriangleTree triangles(mesh.position, mesh.triangles);
    parallelFor(leaves.size(), 16, [&](std::size_t i) {
        std::size_t nearest = 0;  // a leaf begins afresh, so that it does not depend on the division of work
        for (auto voxel = leaves[i]->beginValueOn(); voxel; ++voxel) {
            const vdb::Vec3d world = grid->indexToWorld(voxel.getCoord());
            const Vec3 p(world.x(), world.y(), world.z());
            triangles.distanceTo(p, nearest);
            const Triangle& t = mesh.triangles[triangles.triangleAt(nearest)];
            const auto weight = nearestWeights(p, {mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]]});
            Vec3 v(0, 0, 0);
            for (std::size_t k = 0; k < 3; ++k) v += mesh.velocity[t[k]] * weight[k];
            voxel.setValue(vdb::Vec3s(static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)));
        }
    });
    return grid;
}

/// The median length of the sides of triangles; 1 without triangles.
double medianEdge(const Mesh& mesh) {
    std::vector<double> squared;
    squared.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            squared.push_back((mesh.position[t[(k + 1) % 3]] - mesh.position[t[k]]).length2());
    const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
    std::nth_element(squared.begin(), middle, squared.end());
    const double length = squared.empty() ? 0 : std::sqrt(*middle);
    return length > 0 ? length : 1;
}

std::string shortText(double number) {
    std::ostringstream text;
    text.precision(3);
    text << number;
    return text.str();
}

double areaOf(const Mesh& mesh) {
    double area = 0;
    for (const Triangle& t : mesh.triangles)
        area +=
            cross(mesh.position[t[1]] - mesh.position[t[0]], mesh.position[t[2]] - mesh.position[t[0]]).length() / 2;
    return area;
}

/// The edges that do not have two triangles.
std::size_t openEdges(const Mesh& mesh) {
    std::size_t open = 0;
    forEveryEdge(sortedSides(mesh.triangles), [&](std::span<const TriangleSide> sides) { open += sides.size() % 2; });
    return open;
}

bool hasInside(const vdb::FloatGrid& level_set) {
    for (auto voxel = level_set.cbeginValueOn(); voxel; ++voxel)
        if (*voxel < 0) return true;
    return false;
}

/// Warns of parts of a mesh that its level set may lack.
void notePartsMissing(const Mesh& mesh, const vdb::FloatGrid& level_set, const WarningHandler& warn) {
    if (mesh.triangles.empty() || !warn) return;
    const std::size_t open = openEdges(mesh);
    const std::string edges = std::to_string(open) + (open == 1 ? " edge" : " edges") +
                              " without a triangle on one side. Close its holes first";
    if (hasInside(level_set)) {
        if (open > 0) warn("open parts of the mesh may be missing in the level set: it has " + edges);
    } else if (open > 0) {
        warn(std::string(kNoInside) + ", so that the level set is empty: it has " + edges);
    } else {
        warn("the level set is empty: no voxel of " + shortText(level_set.voxelSize().x()) +
             " is inside the mesh. Choose smaller voxels with --voxel (output.voxel)");
    }
}

/// Whether a block of so many bytes could be allocated now.
bool canAllocate(double bytes) {
    constexpr double kMost = 1e15;
    if (!(bytes < kMost)) return false;
    void* const block = ::operator new(static_cast<std::size_t>(bytes), std::nothrow);
    ::operator delete(block);
    return block != nullptr;
}

void requireFeasible(const Mesh& mesh, const std::string& file, const LevelSetOptions& options) {
    constexpr double kMaxIndex = 1 << 30;  // within 32 bits, with the narrow band
    const std::string advice = " Choose larger voxels with --voxel (output.voxel).";
    const std::string voxels = file + ": voxels of " + shortText(options.voxel);
    if (!(options.voxel * options.band <= static_cast<double>(std::numeric_limits<float>::max())))
        throw Error(voxels + " are too large: the distances of a band of " + shortText(options.band) +
                    " voxels are stored as 32-bit floats, at most 3.4e38. Choose smaller voxels with --voxel "
                    "(output.voxel).");
    double farthest = 0;
    for (const Vec3& p : mesh.position)
        for (int axis = 0; axis < 3; ++axis) farthest = std::max(farthest, std::abs(p[axis]));
    if (!(farthest / options.voxel < kMaxIndex))
        throw Error(voxels + " are too small for coordinates up to " + shortText(farthest) +
                    ", because a grid has 2^30 of them in each direction." + advice);
    const double bytes = levelSetMemory(areaOf(mesh), options);
    const bool exceeds = options.memory_limit > 0 && bytes > static_cast<double>(options.memory_limit);
    if (exceeds || !canAllocate(bytes))
        throw MemoryError(
            voxels + " would need about " + shortText(bytes / 1e9) + " GB of memory" +
            (exceeds ? ", but " + shortText(static_cast<double>(options.memory_limit) / 1e9) + " GB are the limit."
                     : ".") +
            advice);
}

}  // namespace

double levelSetMemory(double area, const LevelSetOptions& options) {
    // Blocks of 8³ voxels along the surface, each with a distance, the nearest triangle, a share of the file and
    // perhaps a velocity.
    constexpr double kBlock = 8, kBytesPerVoxel = 4 + 4 + 4, kBytesOfVelocity = 12;
    const double blocks = area / std::pow(kBlock * options.voxel, 2) * ((2 * options.band + kBlock) / kBlock + 1);
    return blocks * std::pow(kBlock, 3) * (kBytesPerVoxel + (options.velocity ? kBytesOfVelocity : 0));
}

std::string encodeLevelSet(const Mesh& mesh, const std::string& file, const LevelSetOptions& given,
                           const WarningHandler& warn) {
    initializeVdb();
    requireWritable(mesh, file);
    LevelSetOptions options = given;
    if (options.voxel == 0) options.voxel = medianEdge(mesh);
    requireFeasible(mesh, file, options);
    try {
        const auto surface = levelSetOf(mesh, Distances(mesh, options.voxel, options.band), shellsOf(mesh));
        notePartsMissing(mesh, *surface, warn);
        surface->setName("surface");
        surface->setGridClass(vdb::GRID_LEVEL_SET);
        vdb::GridCPtrVec grids;
        if (options.velocity) grids.push_back(velocityGrid(mesh, *surface));
        grids.push_back(surface);  // last, where vdb_tool looks for it
        return archiveOf(grids);
    } catch (const vdb::Exception& error) {
        throw Error(file + ": " + error.what());
    }
}

}  // namespace betamesh
