// Arrays of numpy and vectors of the library.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "python/binding.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace betamesh {

// From Python. `value` is anything that numpy.asarray() takes: any strides, byte order and type of real numbers. `name`
// is the argument's, for messages. Other shapes, types and numbers that do not fit throw Error.

/// Positions or velocities of shape (n, 3), or (n, 2) with two_columns, whose third coordinate is 0; an empty list has
/// no rows. The origin is subtracted in double precision.
std::vector<Vec3f> vectorsFrom(const char* name, nb::handle value, const Vec3& origin = {0, 0, 0},
                               bool two_columns = false);
/// The same in double precision.
std::vector<Vec3> doubleVectorsFrom(const char* name, nb::handle value);
/// Whether the array has 64-bit floating-point numbers.
bool isDouble(nb::handle value);

/// Whole numbers of shape (m, columns), each from 0 to vertices - 1, row after row.
std::vector<std::uint32_t> indicesFrom(const char* name, nb::handle value, std::size_t columns, std::size_t vertices);
/// Whole numbers >= 0 of shape (n,).
std::vector<std::uint64_t> idsFrom(const char* name, nb::handle value);
/// A dict of arrays of shape (n,) or (n, components). Floating-point numbers become 32-bit ones; whole numbers keep
/// their type, if they fit into 32 bits.
std::vector<Attribute> attributesFrom(nb::handle dict, std::size_t n);

// To Python: arrays that are read-only views of memory that belongs to `owner`, without a copy.

nb::object arrayOf(std::span<const Vec3f> rows, nb::handle owner);                          ///< float32, (n, 3)
nb::object arrayOf(std::span<const float> numbers, std::size_t columns, nb::handle owner);  ///< float32
nb::object arrayOf(std::span<const std::int32_t> numbers, std::size_t columns, nb::handle owner);
nb::object arrayOf(std::span<const std::uint32_t> numbers, std::size_t columns, nb::handle owner);
nb::object arrayOf(std::span<const std::uint64_t> numbers, nb::handle owner);  ///< (n,)
/// Name to array, (n,) or (n, components), float32 or int32.
nb::dict dictOf(const std::vector<Attribute>& attributes, nb::handle owner);

/// A copy in single precision, as files store it.
std::vector<Vec3f> rounded(const std::vector<Vec3>& vectors);

/// str(value).
std::string textOf(nb::handle value);

/// The tuple (x, y, z).
nb::tuple tupleOf(const Vec3& v);

}  // namespace betamesh
