// A mesh on its way to the skin: where its vertices are, what they stand for, and means over what is near them.

#pragma once

#include "base/compressed_rows.h"
#include "skin/beta_mesh.h"
#include "skin/neighbourhoods.h"

#include <utility>
#include <vector>

namespace betamesh {

/// How often edges of a DeformingMesh can be split: each time at two groups of vertices that fade in.
inline constexpr std::size_t kRefinements = (std::tuple_size_v<FadingVertices> - kTessellationGroups) / 2;

/// A mesh whose vertices are moved step by step, with the area and the normal that each vertex stands for.
///
/// A vertex stands for a third of the triangles round it. One that fades in hands as much of that to the vertices that
/// it rises from as its share is short of 1, and goes as far as they do by as much: areas, normals and steps then
/// change continuously as vertices appear and vanish and as edges flip, because neither changes how a plane polygon is
/// shared out. Lengths are in particle spacings, positions in world units.
class DeformingMesh {
public:
    /// Brings the vertices of the mesh into an order in space. The mesh has to stay where it is; spacing: of the
    /// particles, world units.
    DeformingMesh(BetaMesh& mesh, double spacing);

    std::size_t size() const { return position_.size(); }
    double spacing() const { return spacing_; }
    const std::vector<Vec3>& position() const { return position_; }
    float area(std::size_t v) const { return area_[v]; }
    const std::vector<Vec3f>& normals() const { return normal_; }  ///< unit vectors; zero without triangles
    const BetaMesh& mesh() const { return mesh_; }

    /// Makes values of vertices that fade in those of what they rise from, by what their share is short of 1.
    template <typename Value>
    void hold(std::vector<Value>& values) const {
        std::vector<Value> free, held;
        for (const HeldVertices& group : held_) {
            held.resize(group.all.size());
            for (int round = 0; round < group.rounds(); ++round) {
                // Later rounds change nothing but what rises from others of the group.
                const std::vector<HeldVertex>& some = round == 0 ? group.all : group.from_one_another;
                if (round == 0) free.resize(some.size());
                parallelFor(some.size(), 1024, [&](std::size_t i) {
                    const HeldVertex& v = some[i];
                    Value from(0);
                    for (std::size_t k = 0; k < 4; ++k) from += values[v.from[k]] * v.weight[k];
                    if (round == 0) free[i] = values[v.vertex];
                    held[i] = free[v.row] * v.share + from * (1 - v.share);
                });
                for (std::size_t i = 0; i < some.size(); ++i) values[some[i].vertex] = held[i];
            }
        }
    }
    /// Moves every vertex by its step, held. Areas and normals stay what they were.
    void move(std::vector<Vec3f>& step);
    /// Works areas and normals out anew.
    void measure();
    /// Splits edges that are long for how strongly the surface is curved there, kRefinements times, at vertices that
    /// fade in with the edges' length, and brings all into order again. To be called once.
    /// radius: of the balls that the mesh comes from, particle spacings; coarser: so many times as long as by default.
    void refine(double radius, double coarser);
    /// Draws vertices whose triangles face very different ways towards the vertices round them, and turns triangles
    /// that lie upside down on the surface. Works areas and normals out anew afterwards.
    void unfold();
    /// Sets the velocities of the mesh to these, held; world units per second.
    void setVelocities(std::vector<Vec3f>& velocity);
    /// Writes the positions to the mesh.
    void writePositions();

    /// Of vertices, where they are now.
    const PointGroups& groups() const { return groups_; }
    /// As forGroups, with the vertices within reach.
    template <std::size_t kFields, typename Fill, typename Visit>
    void forVicinities(double reach, const Fill& fill, const Visit& visit) const {
        constexpr std::size_t kMostNear = 2048;  // of a surface in good order some 300 are near
        forGroups<kFields>(
            groups_, position_, groups_, position_, spacing_, kMostNear, [&](std::size_t) { return reach * spacing_; },
            fill, visit);
    }

    /// Kernel means over what is near in space, whichever way it faces: (1 - d²/width²)² times area is the weight.
    std::vector<Vec3f> means(double width, const std::vector<Vec3f>& values) const;

    /// Narrow means of normals, of what faces any way: a vertex of slivers may do so.
    std::vector<Vec3f> meanNormals() const;
    struct SoftNormals {
        std::vector<Vec3f> normal;  ///< unit vectors
        std::vector<float> bend;    ///< 0 where all that is near faces one way, 1 where it faces all ways
    };
    /// Kernel means of normals over what is near and faces the way of `from`.
    SoftNormals softNormals(double width, const std::vector<Vec3f>& from) const;

private:
    // A FadingVertex in a fifth of the memory, and its place in its group.
    struct HeldVertex {
        std::uint32_t vertex, row;
        std::array<std::uint32_t, 4> from;
        std::array<float, 4> weight;
        float share;
    };
    // A group of them. On facets they rise from one another: what is held to what is held itself takes several rounds.
    struct HeldVertices {
        std::vector<HeldVertex> all, from_one_another, lent_to_others;
        int rounds() const { return from_one_another.empty() ? 1 : 4; }
    };

    void listHeld();
    void arrange();
    std::vector<float> shares() const;
    void weighDiagonals(const std::vector<float>& share);
    void placeBetween(FadingVertex& rising, double of_other, double middle);
    struct Need;
    void splitLongEdges(std::size_t refinement, Need& need);
    void turnBack(std::uint32_t triangle, std::vector<Vec3f>& step) const;

    BetaMesh& mesh_;
    double spacing_;
    std::vector<Vec3> position_;
    IndexRows triangles_of_;  // of each vertex
    struct Facing {
        Vec3f third;  // of a triangle's vector area
        float area;   // a third of it
    };
    std::vector<Facing> facing_;
    std::vector<float> area_, agreement_;  // agreement: of the normals of a vertex' triangles, 1 where they are one
    std::vector<Vec3f> normal_;

    std::array<HeldVertices, std::tuple_size_v<FadingVertices>> held_;
    PointGroups groups_;
};

}  // namespace betamesh
