// What every reader of a format makes of a file, before it becomes particles, a mesh or a report.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/file_info.h"
#include "io/particle_file.h"

#include <functional>
#include <optional>

namespace betamesh {

/// IndexRows are points, in the order of the file. Attributes hold everything but position and the id that was
/// asked for; velocity is still among them.
struct FileContents {
    std::string format;                   ///< as FileInfo::format
    std::vector<AttributeInfo> declared;  ///< as FileInfo::attributes
    std::vector<Vec3f> position;
    std::vector<std::uint64_t> id;  ///< n rows or none
    std::vector<Attribute> attributes;
    std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside, corners within the points
    std::optional<std::vector<std::int32_t>> component;  ///< as Mesh::component
    std::vector<Edge> edges;                             ///< of curves: corners within the points, line after line
    bool declares_faces = false;                         ///< also when there are none
    bool declares_edges = false;                         ///< also when there are none
    bool begun = false;                                  ///< points, perhaps none, were appended
};

/// The name of Mesh::component in files.
inline constexpr const char* kComponent = "component";

/// What a reader is to look for.
struct ReadOptions {
    std::string id = "id";   ///< attribute that becomes FileContents::id; empty: none
    bool attributes = true;  ///< false: the positions are enough
    /// Takes the points, some thousands at a time: position, id and attributes. What is read has none then.
    std::function<void(FileContents&& points, std::uint64_t all)> points{};  ///< all: how many the file says it has
    bool faces = true;                                                       ///< false: the points are enough
    bool skip_unknown_faces = false;  ///< stop at primitives that are no polygons, rather than fail
};

/// Gives points that a reader found to whoever is to have them. all: how many the file says it has.
void deliver(FileContents&& points, std::uint64_t all, const ReadOptions& options, FileContents& contents);

/// The same for all of them, where each is a row of so many bytes (one or more): several threads decode some thousands
/// at a time, which stay in the processor's cache, while the next are read.
void deliverRows(Cursor& in, std::uint64_t all, std::size_t row_bytes,
                 const std::function<FileContents(const std::byte* rows, std::size_t count)>& decode,
                 const ReadOptions& options, FileContents& contents);

/// Adds points to those of the same file that came before; an attribute that either lacks is left out.
void append(FileContents&& points, std::uint64_t all, FileContents& contents);

/// Leaves only some rows of the points, ascending.
void keepRows(const std::vector<std::uint32_t>& rows, FileContents& points);

/// Throws Error for a position or velocity that is not finite; first_row: the number of the first, for the text.
void requireFinite(const FileContents& points, const AttributeNames& names, std::size_t first_row,
                   const std::string& file);

/// Integers as an attribute: float where some do not fit in 32 bits.
Attribute integerAttribute(std::string name, std::uint32_t components, std::vector<std::int64_t> values);

/// A corner list as a fan of triangles; fewer than three corners give none.
void appendFan(const std::vector<std::uint32_t>& corners, std::vector<Triangle>& triangles);

/// Finds velocity among the attributes and validates. Errors begin with the file's name.
Particles particlesFrom(FileContents contents, const AttributeNames& names, const std::string& file);
Mesh meshFrom(FileContents contents, const std::string& file);
Curves curvesFrom(FileContents contents, const std::string& file);

/// Spheres as particles with velocity (zeros where there is none) and the radius as an attribute.
Particles particlesOf(const Spheres& spheres, const std::string& radius_name, const std::string& file);

/// Throws Error unless every column has one row for each of n points, exactly one kind of numbers, a name
/// without white space that no other column has; taken: the names that the format uses itself.
void requireWritable(const std::vector<Attribute>& attributes, std::size_t n, std::vector<std::string> taken,
                     const std::string& file);

/// The id of row i for a format whose ids have 32 bits. Throws Error where it needs more.
std::uint32_t idOf32Bits(const std::vector<std::uint64_t>& ids, std::size_t i, const std::string& file);

/// Throws Error unless validate() passes.
void requireWritable(const Particles& particles, const std::string& file);

/// Throws Error unless rows match, components among them, corners exist and positions and velocities are finite.
void requireWritable(const Mesh& mesh, const std::string& file);
void requireWritable(const Curves& curves, const std::string& file);

}  // namespace betamesh
