// What may be exposed of one ball: its sphere clipped by the bisector planes of its neighbours.

#pragma once

#include "base/index.h"
#include "exact/snapped_particles.h"

#include <array>
#include <span>

namespace betamesh {

/// Finds which neighbours of a ball bound the exposed part of its sphere. Conservative by 1e-5 radii: a neighbour that
/// matters is never missed. One object serves many balls in turn.
///
/// A neighbour covers what lies beyond the plane in which the two spheres meet, their bisector, so the exposed part is
/// the sphere within the ball's cell of the power diagram (with one radius, the Voronoi diagram). Only the part of that
/// cell outside the ball is constructed: a tetrahedron round the ball is clipped by bisectors until no vertex outside
/// the ball, and no point where an edge leaves the ball, lies beyond any bisector. Each clip uses the bisector that the
/// tested point lies farthest beyond. (Measured: taking the nearest neighbour instead is 50 % slower, the relatively
/// farthest bisector 10 %, starting from a cube 10 % in dense cells.)
///
/// Where too many planes pass too close to its vertices, for example when many particles lie on a sphere of the radius,
/// the whole cell is constructed instead, with exact signs.
///
/// cost    2 µs for eighty neighbours: one pass over them for each plane, vertex and edge that reaches the sphere,
///         about eight planes in all
/// source  convex cells as triangulations of their planes: Ray, Sokolov, Lefebvre & Lévy 2018, Meshless Voronoi on the
///         GPU
class ExposedRegion {
public:
    /// Bisector planes, one per neighbour and padded to whole registers: unit normals, and distances from the ball's
    /// centre in radii. Each meets the sphere in the rim of the cap that its neighbour covers.
    struct Planes {
        std::vector<float> x, y, z, distance;
    };

    /// Constructs the region of a ball from all neighbours whose spheres meet its own.
    void construct(const std::vector<Neighbour>& neighbours, std::int64_t radius);

    /// Do the neighbours surely cover the whole sphere? Fast where they are many and near: it first tests whether each
    /// of 42 directions, with all that is near it, is covered by a single neighbour.
    bool isCoveredBy(const std::vector<Neighbour>& neighbours, std::int64_t radius);

    bool empty() const { return outer_ == 0; }
    /// The neighbours that matter: what lies in none of their balls is exposed.
    const std::vector<Neighbour>& neighbours() const { return neighbours_; }
    /// Indices, among the neighbours given, of those whose spheres may bound the exposed part.
    const std::vector<std::uint32_t>& bounding() const { return bounding_; }
    /// Bisectors of all neighbours given.
    const Planes& planes() const { return planes_; }

private:
    static constexpr std::size_t kMostBisectors = 64, kMostVertices = 2 * kMostBisectors;
    struct Bisector {
        Vec3 normal;
        double distance;
        Vec3 offset;  // the plane is 2 offset · x = level, x in quanta; both are integers
        double level;
        std::uint32_t neighbour;
    };
    // A neighbour that matters. Sorts by neighbour, entries that may bound the exposed part first.
    struct Relevant {
        std::uint32_t neighbour;
        bool covers_only;  // bounds no exposed part
        auto operator<=>(const Relevant&) const = default;
    };
    // A vertex of the cell, where three bisectors meet: counter-clockwise seen from outside.
    struct CellVertex {
        std::array<std::uint8_t, 3> bisector;
        bool outer;                         // not inside the ball
        bool verified;                      // beyond no bisector
        std::array<bool, 3> edge_verified;  // likewise the edge between bisectors k and k + 1
        std::uint32_t farthest;             // neighbour whose bisector it lies farthest beyond; kInvalidIndex: unknown
    };

    // The neighbour whose bisector a point lies farthest beyond, and by how much in radii.
    struct Farthest {
        std::uint32_t neighbour;
        float beyond;
    };

    Vec3 positionOf(std::size_t vertex) const { return {x_[vertex], y_[vertex], z_[vertex]}; }
    void setPlanes(const std::vector<Neighbour>& neighbours, std::int64_t radius);
    double distanceOf(const Neighbour& neighbour, double length) const;
    void construct();
    void startWithTetrahedron();
    void constructCell();
    int sideOf(const CellVertex& vertex, const Neighbour& neighbour) const;
    template <std::size_t kPoints>
    std::array<Farthest, kPoints> farthestBeyond(const std::array<Vec3f, kPoints>& point) const;
    bool verifyPoint(const Vec3& point);
    bool verifyVertex(std::size_t vertex);
    std::size_t nextToVerify(std::size_t vertex) const;
    bool verifyExactly(std::size_t vertex);
    void addBisector(std::uint32_t neighbour);
    bool clip(std::uint32_t neighbour);
    bool listNewVertices(std::uint8_t bisector);
    void setVertex(const CellVertex& vertex, const Vec3& position, std::size_t row);
    std::uint64_t bisectorsOf(bool outer_only) const;
    void verifyVertices();
    bool verifyEdges();

    double radius_ = 0;  // of the ball
    const std::vector<Neighbour>* all_ = nullptr;
    Planes planes_;
    std::vector<float> unused_distance_;  // as planes_.distance, out of reach for bisectors already used
    std::vector<float> rim_;
    std::array<Bisector, kMostBisectors> bisector_;
    std::uint64_t bisectors_ = 0;  // a bit for each that may have vertices
    std::array<CellVertex, kMostVertices> vertex_;
    std::array<double, kMostVertices> x_{}, y_{}, z_{};  // positions of the vertices, radii
    std::size_t vertices_ = 0;
    std::array<std::array<std::uint16_t, kMostBisectors>, kMostBisectors> vertex_at_;  // by two bisectors, in order
    std::array<double, kMostVertices> beyond_;          // how far each vertex lies beyond the clipping plane
    std::array<std::uint16_t, kMostVertices> cut_off_;  // vertices beyond it
    std::size_t cut_off_count_ = 0;
    std::array<CellVertex, kMostBisectors> new_vertex_;
    std::array<Vec3, kMostBisectors> new_position_;
    std::size_t new_vertices_ = 0;
    std::size_t outer_ = 0;     // vertices not inside the ball
    std::size_t doubtful_ = 0;  // bisectors that could not be used for clipping
    bool exact_ = false;
    std::vector<Relevant> relevant_;
    std::vector<Neighbour> neighbours_;
    std::vector<std::uint32_t> bounding_;
};

}  // namespace betamesh
