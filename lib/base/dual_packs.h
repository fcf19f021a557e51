// Packs of kLanes dual numbers or vectors, as structures of arrays: the compiler vectorises loops over their lanes.

#pragma once

#include "base/dual.h"
#include "base/simd.h"

namespace betamesh {

struct DualPack {
    double value[kLanes] = {}, rate[kLanes] = {};

    Dual operator[](std::size_t lane) const { return {value[lane], rate[lane]}; }
    void set(std::size_t lane, Dual number) {
        value[lane] = number.value;
        rate[lane] = number.rate;
    }
};

struct DualVec3Pack {
    double position[3][kLanes] = {}, velocity[3][kLanes] = {};

    DualVec3 operator[](std::size_t lane) const {
        return {Vec3(position[0][lane], position[1][lane], position[2][lane]),
                Vec3(velocity[0][lane], velocity[1][lane], velocity[2][lane])};
    }
    void set(std::size_t lane, const DualVec3& point) {
        position[0][lane] = point.position.x;
        position[1][lane] = point.position.y;
        position[2][lane] = point.position.z;
        velocity[0][lane] = point.velocity.x;
        velocity[1][lane] = point.velocity.y;
        velocity[2][lane] = point.velocity.z;
    }
};

}  // namespace betamesh
