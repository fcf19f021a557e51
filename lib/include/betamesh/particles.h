// One frame of particles, as written by the simulation.

#pragma once

#include "betamesh/vec3.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

/// The type of whole numbers in a file.
enum class IntegerType : std::uint8_t { int32, int8, uint8, int16, uint16 };

/// A named attribute with `components` numbers per row, stored row after row.
/// Either real or integer is used, depending on the type in the file; the other one is empty.
struct Attribute {
    std::string name;
    std::uint32_t components = 1;
    std::vector<float> real;
    std::vector<std::int32_t> integer;
    IntegerType integer_type{};      ///< of the file; formats that have this type write it if all numbers fit
    bool declares_integers = false;  ///< without rows: the numbers would be integers

    /// Whether the numbers are integers, or would be if there were rows.
    bool hasIntegers() const {
        return !integer.empty() || (real.empty() && (declares_integers || integer_type != IntegerType::int32));
    }
};

/// Row i of every array is particle i. Lengths in world units, time in seconds.
/// position has n rows; velocity and id have n rows or none; every attribute has n rows.
struct Particles {
    std::vector<Vec3f> position;        ///< centres
    std::vector<Vec3f> velocity;        ///< world units per second
    std::vector<std::uint64_t> id;      ///< identifies a particle in all frames
    std::vector<Attribute> attributes;  ///< all other attributes of the file

    /// Number of particles.
    std::size_t size() const { return position.size(); }
};

/// Checks array sizes and that positions and velocities are finite. Called where data enters.
///
/// errors  an array with a wrong number of rows; the first particle with a non-finite position or velocity
void validate(const Particles& particles);

/// Checks that all rows are finite. what: the name of the quantity, such as "position"; first_row: row number of
/// rows[0]; both are for the message.
///
/// errors  the first row that is not finite
void requireFinite(std::span<const Vec3f> rows, const char* what, std::size_t first_row);

}  // namespace betamesh
