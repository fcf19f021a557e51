// One frame of particles as the simulation left them. Row i of every array is particle i.

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

/// A named column of numbers: `components` of them in every row, row after row.
/// Exactly one of real and integer is filled, whichever the file declared.
struct Attribute {
    std::string name;
    std::uint32_t components = 1;
    std::vector<float> real;
    std::vector<std::int32_t> integer;
};

/// Lengths in world units, time in seconds.
/// position has n rows; velocity and id have n rows or none; every attribute has n rows.
struct Particles {
    std::vector<Vec3f> position;        ///< centres
    std::vector<Vec3f> velocity;        ///< world units per second
    std::vector<std::uint64_t> id;      ///< the same particle keeps its id from frame to frame
    std::vector<Attribute> attributes;  ///< everything else the file holds

    std::size_t size() const { return position.size(); }
};

/// Throws Error naming the first row that breaks the lines above or holds a position or velocity that is
/// not finite. Called where data enters.
void validate(const Particles& particles);

/// Throws Error naming the first row that is not finite. what: they are; first_row: the number of the first.
void requireFinite(std::span<const Vec3f> rows, const char* what, std::size_t first_row);

}  // namespace betamesh
