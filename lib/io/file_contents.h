// Contents of a geometry file of any format, which become particles, a mesh, curves or a summary. Shared checks of
// readers and writers.

#pragma once

#include "betamesh/curves.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "io/particle_input.h"

#include <functional>
#include <optional>
#include <set>
#include <string_view>

namespace betamesh {

enum class FileKind { particles, mesh, curves };

/// One point attribute as the file declares it; position is one of them.
struct AttributeInfo {
    std::string name;
    std::string type;              ///< as the format names it: "float", "vector", "int64"
    std::uint32_t components = 1;  ///< numbers per row
    std::string codec;             ///< how the numbers are compressed; empty: they are not
};

/// A grid of a .vdb file, or an object of an .abc file.
struct GridInfo {
    std::string name;  ///< of an object: its path, such as "/sim/liquid"
    std::string type;  ///< "points", or the type of a grid of another kind, or the schema of an object
    bool is_read = false;
};

/// A volume of a .vdb file, such as a level set.
struct VolumeInfo {
    std::string name;
    std::string type;          ///< of its values: "float", "vec3s"
    std::string kind;          ///< "level set", "fog volume" and so on; "unknown"
    double voxel = 0;          ///< size of a voxel along x, world units
    std::uint64_t voxels = 0;  ///< active ones
    Vec3 lower{0, 0, 0};       ///< bounding box of the centres of the active voxels, world units
    Vec3 upper{0, 0, 0};
};

/// What a file says about its sequence and its units; nullopt: nothing.
struct FileUnits {
    std::optional<double> frames_per_second{};
    std::optional<UpAxis> up_axis{};
    std::optional<double> meters_per_unit{};
    // For lists of what is not read: where up is not y, or a unit is not a metre. Empty: there is nothing to say.
    std::string up_axis_note{};          ///< upAxis = "Z" (--up-axis z, input.up_axis, turns it to y)
    std::string meters_per_unit_note{};  ///< metersPerUnit = 0.01
};

/// Row i of position, id and attributes is point i of the file. Attributes are all point attributes but the position
/// and the id that was requested; velocity is one of them.
struct FileContents {
    std::string format;                   ///< as FileInfo::format
    std::vector<AttributeInfo> declared;  ///< as FileInfo::attributes
    std::vector<Vec3f> position;
    std::vector<std::uint64_t> id;  ///< n rows or none
    std::vector<Attribute> attributes;
    std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside; corners are valid point indices
    std::optional<std::vector<std::int32_t>> component;  ///< as Mesh::component
    std::vector<Edge> edges;            ///< of curves, curve after curve; corners are valid point indices
    bool declares_faces = false;        ///< the file declares faces, perhaps none
    bool declares_edges = false;        ///< the file declares edges, perhaps none
    std::uint64_t unread_polygons = 0;  ///< what there is, if ReadOptions::faces is not set
    bool begun = false;                 ///< append() was called, perhaps with no points
    std::vector<std::string> groups{};  ///< names of all point groups
    std::vector<GridInfo> grids{};
    std::vector<VolumeInfo> volumes{};       ///< of a file without points, if ReadOptions::summary is set
    std::vector<std::string> passed_over{};  ///< what else is not read: "3 point groups of the classic format"
    std::vector<std::string> warnings{};     ///< what is read otherwise than one might expect, without the file's name
    std::vector<LostNumber> lost_numbers{};  ///< the first of each attribute
    FileUnits units{};
    bool has_double_positions = false;  ///< the file stores positions in double precision

    /// A file with faces is a mesh, one with edges only contains curves, any other particles.
    FileKind kind() const {
        return declares_faces ? FileKind::mesh : declares_edges ? FileKind::curves : FileKind::particles;
    }
};

/// The name of Mesh::component in files.
inline constexpr const char* kComponent = "component";

/// What the names of point groups begin with among attributes.
inline constexpr std::string_view kGroupPrefix = "group:";

/// Whether an attribute is a point group: its name begins with kGroupPrefix, and its numbers are ones and zeros.
bool isPointGroup(const Attribute& a);

/// What a reader has to read.
struct ReadOptions {
    std::string id = "id";              ///< name of the attribute that becomes FileContents::id; empty: none
    bool attributes = true;             ///< false: read positions only
    std::vector<std::string> grids{};   ///< point grids of .vdb to read; empty: all. Of .abc: objects, by path or last
                                        ///< name; empty: the only one
    std::vector<std::string> groups{};  ///< groups that become integer attributes, named kGroupPrefix + NAME, of ones
                                        ///< and zeros; the readers of Houdini's files read all groups
    bool all_groups = false;            ///< all groups become such attributes, in addition to `groups`
    /// Attributes that must be read: a table with a cell that is no number is an error there, and a warning elsewhere.
    /// Not set: none.
    std::function<bool(const std::string& name)> needs{};
    Vec3 origin{0, 0, 0};           ///< is subtracted from positions before they are rounded to float
    std::optional<double> frame{};  ///< as ParticleInput::frame
    /// If set, gets the points (position, id and attributes) in blocks of a few thousand, and the result of the reader
    /// has none. total: number of points that the file declares.
    std::function<void(FileContents&& points, std::uint64_t total)> points{};
    bool faces = true;                ///< false: read points only
    bool skip_unknown_faces = false;  ///< stop at a primitive that is not a polygon instead of reporting an error
    bool summary = false;             ///< report no error, but what there is: the volumes of a .vdb file without points
};

/// Passes points to options.points if that is set, else appends them to contents. total: number that the file declares.
void deliver(FileContents&& points, std::uint64_t total, const ReadOptions& options, FileContents& contents);

/// Decodes and delivers all points of a format that stores each point as a row of row_bytes >= 1 bytes. Several threads
/// decode blocks of a few thousand rows, small enough for the cache, while the next block is read.
void deliverRows(Cursor& in, std::uint64_t total, std::size_t row_bytes,
                 const std::function<FileContents(const std::byte* rows, std::size_t count)>& decode,
                 const ReadOptions& options, FileContents& contents);

/// Appends a block of points to the earlier points of the same file. Removes attributes that one of them lacks.
void append(FileContents&& points, std::uint64_t total, FileContents& contents);

/// Appends a number to the first ones of their attributes, unless its attribute has one already.
void noteLost(LostNumber&& lost, std::vector<LostNumber>& numbers);

/// Removes all points but the given rows, which must be ascending.
void keepRows(const std::vector<std::uint32_t>& rows, FileContents& points);

/// The message that a requested point group does not exist, with those that do.
std::string unknownGroup(const std::string& wanted, const std::vector<std::string>& groups);

/// Subtracts ReadOptions::origin from positions that the file stores as floats.
void subtractOrigin(const Vec3& origin, std::vector<Vec3f>& positions);

/// The names of the attributes in quotes, for messages.
std::string attributeNames(const FileContents& contents);

/// An integer attribute; a float attribute if some values need more than 32 bits.
Attribute integerAttribute(std::string name, std::uint32_t components, std::vector<std::int64_t> values);

/// The type of an attribute's integers in a file: that of the file that it is from, if all numbers fit.
IntegerType writtenType(const Attribute& a);

/// Appends a polygon as a fan of triangles; nothing for fewer than three corners.
void appendFan(const std::vector<std::uint32_t>& corners, std::vector<Triangle>& triangles);

/// Convert contents: find the velocity among the attributes, convert it and positions to world units (toWorld()) and
/// validate. Error messages begin with the file's name. A mesh takes an attribute v, velocity or vel for the velocity.
Particles particlesFrom(FileContents contents, const ParticleInput& input, const std::string& file);
Mesh meshFrom(FileContents contents, const std::string& file);
Curves curvesFrom(FileContents contents, const std::string& file);

/// The same for those who judge a surface: positions and velocities may be not finite.
Mesh uncheckedMeshFrom(FileContents contents);
Curves uncheckedCurvesFrom(FileContents contents);

/// Spheres as particles with velocity (zeros if they have none) and the radius as an attribute.
Particles particlesOf(const Spheres& spheres, const std::string& radius_name, const std::string& file);

/// Throws Error unless every attribute has one row for each of n points, either floats or integers, and a unique name
/// without white space. reserved: names that the format uses itself.
void requireWritable(const std::vector<Attribute>& attributes, std::size_t n, std::vector<std::string> reserved,
                     const std::string& file);

/// Names that differ from each other and from those that are taken: "a_2" for the second "a".
///
/// in      wanted: one for each of `names`
/// same    a name that is wanted as it is goes before those that change
std::vector<std::string> distinctNames(const std::vector<std::string>& names, std::vector<std::string> wanted,
                                       std::set<std::string> taken);

/// Whether all numbers, and all ids taken as numbers with sign, fit into 32 bits.
bool haveSigned32Bits(const std::vector<std::int64_t>& numbers);
bool haveSigned32Bits(const std::vector<std::uint64_t>& ids);

/// The id of row i for a format with 32-bit ids. Throws Error if it needs more bits.
std::uint32_t idOf32Bits(const std::vector<std::uint64_t>& ids, std::size_t i, const std::string& file);

/// Throws Error unless validate() passes.
void requireWritable(const Particles& particles, const std::string& file);

/// Throws Error unless all arrays have matching lengths, corners are valid indices, and positions and velocities are
/// finite.
void requireWritable(const Mesh& mesh, const std::string& file);
void requireWritable(const Curves& curves, const std::string& file);

}  // namespace betamesh
