// The mesh while it is moved to the skin: positions, areas and normals of its vertices, and kernel means over them.

#pragma once

#include "base/compressed_rows.h"
#include "skin/beta_mesh.h"
#include "skin/neighbourhoods.h"

#include <utility>
#include <vector>

namespace betamesh {

/// A vector, shortened to the length `longest` if it is longer.
template <typename Number>
Imath::Vec3<Number> limitedTo(const Imath::Vec3<Number>& vector, Number longest) {
    const Number length = vector.length();
    return length > longest ? vector * (longest / length) : vector;
}

/// A mesh whose vertices are moved step by step, with the area and the normal that each vertex represents.
///
/// A vertex represents a third of the triangles of its one-ring. One that fades in with weight s (FadingVertex::fade)
/// passes 1 - s of that to its supports, and takes 1 - s of its displacements from them. Areas,
/// normals and displacements therefore change continuously when vertices appear or vanish and when edges flip, because
/// a plane polygon's area is distributed alike before and after. Lengths are in particle spacings of the frame,
/// positions in world units. Widths of kernels are in particle spacings at the vertex.
class DeformingMesh {
public:
    /// Sorts the vertices of the mesh in space. The mesh is referenced and must outlive this object; spacing: of the
    /// particles, world units.
    DeformingMesh(BetaMesh& mesh, double spacing);
    /// The same for a finished mesh, whose vertices in quads are where they belong. former_row: set to the row that
    /// each vertex had.
    DeformingMesh(BetaMesh& finished, double spacing, std::vector<std::uint32_t>& former_row);

    std::size_t size() const { return position_.size(); }
    double spacing() const { return spacing_; }
    const std::vector<Vec3>& position() const { return position_; }
    float area(std::size_t v) const { return area_[v]; }
    const std::vector<Vec3f>& normals() const { return normal_; }  ///< unit vectors; zero without triangles
    /// Particle spacing at a vertex, in spacings of the frame.
    float scale(std::size_t v) const { return mesh_.scale.empty() ? 1 : mesh_.scale[v]; }
    /// The largest among the vertices of a group.
    float largestScale(std::size_t group) const;
    /// Sets 1 / width² for each vertex of a group; the width is given in particle spacings at the vertex.
    void setInverseSquares(const PointGroup& group, double width, Lanes& inverse) const;
    const BetaMesh& mesh() const { return mesh_; }

    /// Constrains the values of vertices that fade in: v = s · v + (1 - s) · Σ weight · value of its supports, s its
    /// fade weight.
    template <typename Value>
    void constrainFading(std::vector<Value>& values) const {
        std::vector<Value> free, constrained;
        for (const ConstraintGroup& group : constraints_) {
            constrained.resize(group.all.size());
            for (int round = 0; round < group.rounds(); ++round) {
                // Later rounds only affect vertices whose supports are in the group, too.
                const std::vector<Constraint>& some = round == 0 ? group.all : group.dependent;
                if (round == 0) free.resize(some.size());
                parallelFor(some.size(), 1024, [&](std::size_t i) {
                    const Constraint& v = some[i];
                    Value from(0);
                    for (std::size_t k = 0; k < 4; ++k) from += values[v.support[k]] * v.weight[k];
                    if (round == 0) free[i] = values[v.vertex];
                    constrained[i] = free[v.row] * v.fade + from * (1 - v.fade);
                });
                for (std::size_t i = 0; i < some.size(); ++i) values[some[i].vertex] = constrained[i];
            }
        }
    }
    /// Constrains the steps of vertices that fade in and moves every vertex by its step. Areas and normals are not
    /// updated.
    void move(std::vector<Vec3f>& step);
    /// Moves vertices by narrow kernel means of their steps, blended with their own steps; own: weight of these per
    /// vertex, 0 if empty. Overwrites `step` with the displacements.
    void moveAveraged(std::vector<Vec3f>& step, const std::vector<float>& own = {});
    /// Recomputes areas and normals.
    void measure();
    /// Makes the particle spacings at the vertices vary smoothly along the surface.
    void smoothScales();
    /// Splits edges that are long for the local curvature at vertices that fade in with the length of the edge, and
    /// sorts the vertices again. To be called once. radius: of the balls that the mesh comes from, particle spacings;
    /// edge_factor: scales the longest edges.
    void refine(double radius, double edge_factor);
    /// The same for a surface that is smooth, whose new vertices lie on curves over the edges (Vlachos et al. 2001).
    /// They come last (addLastRefinement()). Those that already fade in on long edges move onto the curves, all others
    /// stay in place. Areas and normals are those of the new mesh. To be called once, after which vertices cannot be
    /// moved any more.
    void refineOnCurves(double radius);
    /// Moves vertices with folded one-rings towards the mean of their one-ring, and turns triangles that are inverted
    /// relative to the surface. Vertices that nearly coincide share their one-rings. Recomputes areas and normals
    /// afterwards.
    void relaxFolds();
    /// Rounds what is sharper than kernels can follow, such as the rims of holes, pits and creases, together with what
    /// is beside it: kFairingSteps steps of a bi-Laplacian over one-rings, in all directions. Polygons become round;
    /// what is smooth over some ten edges stays. The means over one-rings are those of the mesh as it is at first, and
    /// triangles without area do not count. Recomputes areas and normals afterwards.
    ///
    /// in      largest_share: 0 to 1 for each vertex: how far it takes part at most
    /// cost    O(vertices) + O(steps · vertices that take part)
    /// source  Kobbelt et al. 1998, Interactive multi-resolution modeling on arbitrary meshes
    void fairSharpParts(const std::vector<float>& largest_share);
    /// Constrains the velocities and writes them to the mesh; world units per second.
    void setVelocities(std::vector<Vec3f>& velocity);
    /// Writes the positions to the mesh.
    void writePositions();

    /// Groups of the vertices at their current positions.
    const PointGroups& groups() const { return groups_; }
    /// How far the widest kernel of a group of vertices reaches, world units.
    double reach(double width, std::size_t group) const {
        return width * spacing_ * static_cast<double>(largestScale(group));
    }
    /// forGroups() with vertices as points and as samples. Of a well-shaped surface some 300 samples are near a group.
    template <std::size_t kFields, typename ReachOf, typename Fill, typename Visit>
    void forNeighbourhoods(const ReachOf& reachOf, const Fill& fill, const Visit& visit) const {
        constexpr std::size_t kMaxSamples = 2048;
        const SampleTable<kFields> table(groups_, position_, spacing_, fill);
        forGroups(groups_, position_, table, kMaxSamples, reachOf, visit);
    }
    /// The same for kernels of a width at all vertices.
    template <std::size_t kFields, typename Fill, typename Visit>
    void forNeighbourhoods(double width, const Fill& fill, const Visit& visit) const {
        forNeighbourhoods<kFields>([&](std::size_t group) { return reach(width, group); }, fill, visit);
    }

    /// Kernel means over space, whatever the normals; the weight is (1 - d²/width²)² times area.
    std::vector<Vec3f> kernelMeans(double width, const std::vector<Vec3f>& values) const;
    /// The same, faster where most values are zero.
    std::vector<Vec3f> kernelMeansOfFew(double width, const std::vector<Vec3f>& values) const;

    /// Narrow kernel means of the normals, whatever they are: the normal of a vertex of slivers may be arbitrary.
    std::vector<Vec3f> meanNormals() const;
    struct KernelNormals {
        std::vector<Vec3f> normal;     ///< unit vectors
        std::vector<float> variation;  ///< 0 where all normals near agree, 1 where they cancel
    };
    /// Kernel means of `normals` over what faces the same way as the vertex' own.
    KernelNormals kernelNormals(double width, const std::vector<Vec3f>& normals) const;
    /// The normals along which smoothing moves vertices: kernel means of the mean normals.
    std::vector<Vec3f> smoothNormals() const;

private:
    // A FadingVertex in a fifth of the memory, and its row and the number of its group.
    struct Constraint {
        std::uint32_t vertex, row;
        std::array<std::uint32_t, 4> support;
        std::array<float, 4> weight;
        float fade;
        std::uint32_t group;
    };
    // A group of FadingVertices. On facets they are supports of each other, and constraints take several rounds to
    // settle.
    struct ConstraintGroup {
        std::vector<Constraint> all;
        std::vector<Constraint> dependent;   // those with supports in the group
        std::vector<Constraint> supporting;  // those that are supports of others of the group
        int rounds() const { return dependent.empty() ? 1 : 4; }
    };

    void listConstraints();
    void listConnections();
    void passOnAreas(std::vector<Vec3f>& vector_area);
    std::vector<std::uint32_t> arrange();
    std::vector<float> fadeWeights() const;
    void weighDiagonals(const std::vector<float>& fade);
    void placeOnDiagonals(FadingVertex& fading, double of_other, double middle);
    struct SplitDemand;
    class EdgeSplitter;
    SplitDemand splitDemand(double radius, double edge_factor) const;
    void fadeInOnLongEdges(SplitDemand& demand, bool on_curves);
    Vec3 curveOffset(std::uint32_t from, std::uint32_t to, double t, const std::vector<Vec3f>& normal) const;
    void splitLongEdges(SplitDemand& demand, std::size_t group);
    std::vector<std::uint8_t> groupsNear(double width, const std::vector<Vec3f>& values) const;
    template <typename ReachOf>
    std::vector<Vec3f> kernelMeansWithin(double width, const std::vector<Vec3f>& values, const ReachOf& reachOf) const;
    // A neighbour in a one-ring.
    struct RingVertex {
        std::uint32_t vertex;
        double share;  // of the mean
    };
    // Of a one-ring, with those of vertices that nearly coincide.
    struct RingShape {
        float area, flatness;
    };
    RingShape ringShape(std::uint32_t v) const;
    double triangleWeight(std::uint32_t triangle) const;
    template <typename Visit>
    void forCoincident(std::uint32_t v, const Visit& visit) const;
    void listOneRing(std::uint32_t v, std::vector<RingVertex>& ring) const;
    std::vector<float> fairingShares(const std::vector<float>& largest) const;
    // The vertices that fairing moves, then their other neighbours.
    struct LocalRings {
        std::vector<std::uint32_t> vertex;
        std::size_t moving;
        std::vector<std::vector<RingVertex>> neighbours;  // rows among these, with their shares of the mean
        std::vector<Vec3f> to_mean;                       // from each vertex to the mean over its whole one-ring
    };
    LocalRings localRings(const std::vector<float>& share) const;
    template <typename Visit>
    void visitNeighbour(std::uint32_t v, std::uint32_t neighbour, double weight, const Visit& visit) const;
    void turnInverted(std::uint32_t triangle, std::vector<Vec3f>& step) const;

    BetaMesh& mesh_;
    double spacing_;
    std::vector<Vec3> position_;
    IndexRows triangles_of_;  // of each vertex
    struct TriangleThird {
        Vec3f vector_area{0};         // a third of the triangle's
        float area = 0;               // likewise
        bool has_short_edge = false;  // whose ends count as one vertex in part
    };
    std::vector<TriangleThird> third_;
    std::vector<float> area_, flatness_;  // flatness: |Σ vector areas| / Σ areas of the one-ring, 1 where it is plane
    std::vector<Vec3f> normal_;
    std::vector<std::uint8_t> has_short_edges_;  // whether a vertex is in a triangle with one

    std::array<ConstraintGroup, std::tuple_size_v<FadingVertices>> constraints_;
    std::vector<const Constraint*> constraint_of_;  // of each vertex; null: none
    PointGroups groups_;
};

}  // namespace betamesh
