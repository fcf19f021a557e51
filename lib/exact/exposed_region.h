// What may be exposed of one ball.

#pragma once

#include "exact/snapped_particles.h"

#include <array>

namespace betamesh {

/// Patches of a ball's sphere that no single neighbour surely covers, and the neighbours whose circles may run through
/// them. Every other neighbour's ball covers none of it: nothing else need be asked whether a point in it is exposed.
/// Never wrong, only conservative. One object serves for many balls in turn.
///
/// cost    0.5-1 µs for a hundred neighbours
/// source  direction masks: Le Grand & Merz 1993
class ExposedRegion {
public:
    explicit ExposedRegion(std::int64_t radius);

    /// Of the ball with these others within 2R, none of them at the same place.
    void enclose(const std::vector<Neighbour>& neighbours);

    bool empty() const { return patches_.size() == 0; }
    const std::vector<Neighbour>& neighbours() const { return neighbours_; }
    bool mayHold(const Vec3& direction) const;

private:
    using Corners = std::array<Vec3, 3>;
    // Triangles of directions, as midpoints and the angle of the cap round it within which each of them lies.
    struct Patches {
        std::vector<float> x, y, z;
        std::vector<std::int32_t> covered;    // -1 or 0
        std::vector<std::uint32_t> triangle;  // number among the level's
        float cos_angle = 1, sin_angle = 0;

        explicit Patches(const std::vector<Corners>& triangles);
        std::size_t size() const { return x.size(); }
        void leaveCoveredOut();
    };
    struct WholeSphere {
        std::vector<Corners> triangles;
        Patches patches;
    };
    // The cap that a neighbour covers: half-angle acos(distance / 2R).
    struct Cap {
        float x, y, z, distance;
        float cos_angle, sin_angle;
        std::uint32_t neighbour;
    };
    static const WholeSphere& wholeSphere();
    bool cover(const Cap& cap);
    bool meets(const Cap& cap) const;
    bool refine();

    float diameter_;
    Patches patches_;
    std::vector<Corners> finer_;  // the level's triangles, unless it is the first level
    std::vector<Cap> caps_;
    std::vector<Neighbour> neighbours_;
};

}  // namespace betamesh
