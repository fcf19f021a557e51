// What may be exposed of one ball.

#pragma once

#include "base/index.h"
#include "exact/snapped_particles.h"

#include <array>
#include <span>

namespace betamesh {

/// Which neighbours matter to the exposed part of a ball's sphere. Never wrong, only conservative, by 1e-5 radii. One
/// object serves for many balls in turn.
///
/// A neighbour covers what lies beyond the plane half way to it, so the exposed part is that of the sphere in the
/// ball's Voronoi cell. Of that cell only what reaches the sphere is made: a tetrahedron round the ball is clipped at
/// each of its corners outside the ball, and where its edges leave the ball, by the plane that these lie farthest
/// beyond, until all these places are nearer to this ball than to any other. (The nearest neighbour's plane instead
/// takes half as long again, that farthest beyond in shares of its distance a tenth, to begin with a cube in crowds
/// a tenth.)
///
/// Where too many planes pass too closely by its corners, as where many particles lie on a sphere of the radius, the
/// whole cell is made instead, with exact signs.
///
/// cost    2 µs for eighty neighbours: one pass over them for each plane, corner and edge that reaches the sphere, some
///         eight planes in all
/// source  convex cells as triangulations of their planes: Ray, Sokolov, Lefebvre & Lévy 2018, Meshless Voronoi on the
///         GPU
class ExposedRegion {
public:
    /// Planes half way to neighbours, in radii: unit normals and distances, filled up to whole registers. On the sphere
    /// they are the rims of the caps that the neighbours hide.
    struct Planes {
        std::vector<float> x, y, z, distance;
    };

    explicit ExposedRegion(std::int64_t radius) : radius_(static_cast<double>(radius)) {}

    /// Of the ball with these others within 2R, none of them at the same place.
    void enclose(const std::vector<Neighbour>& neighbours);

    /// Whether they surely cover all of it; quicker where they are many and near, as they are asked first whether
    /// each covers some of 42 directions with all that is near these.
    bool isHiddenBy(const std::vector<Neighbour>& neighbours);

    bool empty() const { return outer_ == 0; }
    /// What of the sphere is in none of their balls is exposed.
    const std::vector<Neighbour>& neighbours() const { return neighbours_; }
    /// Where those whose spheres may bound the exposed part are among the neighbours that were given.
    const std::vector<std::uint32_t>& bounding() const { return bounding_; }
    /// Of all neighbours that were given.
    const Planes& planes() const { return planes_; }

private:
    static constexpr std::size_t kMostBisectors = 64, kMostCorners = 2 * kMostBisectors;
    struct Bisector {
        Vec3 normal;
        double distance;
        Vec3 offset;  // the plane is where 2 offset · x = level: whole numbers
        double level;
        std::uint32_t neighbour;
    };
    // A neighbour that matters, those first that may bound more than the cell.
    struct Part {
        std::uint32_t neighbour;
        bool covers_only;
        auto operator<=>(const Part&) const = default;
    };
    // Where three walls meet, in this order counter-clockwise seen from outside.
    struct Corner {
        std::array<std::uint8_t, 3> wall;
        bool outer, seen;
        std::array<bool, 3> edge_seen;  // towards the corner beyond walls k and k + 1
        std::uint32_t farthest;         // whose plane it lies farthest beyond; kInvalidIndex where that was not asked
    };

    struct Farthest {
        std::uint32_t neighbour;
        float beyond;
    };

    Vec3 placeOf(std::size_t corner) const { return {x_[corner], y_[corner], z_[corner]}; }
    void setPlanes(const std::vector<Neighbour>& neighbours);
    void enclose();
    void beginWithTetrahedron();
    void makeCell();
    int sideOf(const Corner& corner, const Neighbour& neighbour) const;
    template <std::size_t kPlaces>
    std::array<Farthest, kPlaces> farthestBeyond(const std::array<Vec3f, kPlaces>& place) const;
    bool settle(const Vec3& place);
    bool verifyVertex(std::size_t corner);
    std::size_t nextToVerify(std::size_t corner) const;
    bool verifyExactly(std::size_t corner);
    void take(std::uint32_t neighbour);
    bool clip(std::uint32_t neighbour);
    bool listNewCorners(std::uint8_t wall);
    void put(const Corner& corner, const Vec3& at, std::size_t place);
    std::uint64_t wallsOf(bool outer_only) const;
    void settleCorners();
    bool settleEdges();

    double radius_;
    const std::vector<Neighbour>* all_ = nullptr;
    Planes planes_;
    std::vector<float> left_;  // their distances, out of reach where they are used already
    std::vector<float> rim_;
    std::array<Bisector, kMostBisectors> wall_;
    std::uint64_t walls_ = 0;  // a bit for each that may have corners
    std::array<Corner, kMostCorners> corner_;
    std::array<double, kMostCorners> x_{}, y_{}, z_{};  // where they are
    std::size_t corners_ = 0;
    std::array<std::array<std::uint16_t, kMostBisectors>, kMostBisectors> corner_at_;  // by two of its walls, in order
    std::array<double, kMostCorners> beyond_;      // how far corners lie beyond the plane that clips
    std::array<std::uint16_t, kMostCorners> cut_;  // those that do
    std::size_t cut_count_ = 0;
    std::array<Corner, kMostBisectors> new_corner_;
    std::array<Vec3, kMostBisectors> new_place_;
    std::size_t new_corners_ = 0;
    std::size_t outer_ = 0;     // corners that are not inside the ball
    std::size_t in_doubt_ = 0;  // planes that were not used
    bool exactly_ = false;
    std::vector<Part> part_;
    std::vector<Neighbour> neighbours_;
    std::vector<std::uint32_t> bounding_;
};

}  // namespace betamesh
