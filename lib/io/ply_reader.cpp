// Reads PLY files.

#include "io/ply.h"

#include "io/ply_header.h"
#include "io/ply_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

/// Destination of the numbers of a scalar property: floats at `real`, `step` apart; or a list of integers; or none.
struct Column {
    float* real = nullptr;
    std::size_t step = 1;
    std::vector<std::int64_t> integer{};
    double shift = 0;  ///< is subtracted in double precision

    void put(std::size_t row, float number) const { real[row * step] = number; }
};

/// A block of vertices, and the destinations of their properties.
struct VertexRows {
    FileContents points;
    std::vector<Column> columns;
};

class VertexReader {
public:
    VertexReader(const PlyElement& element, const ReadOptions& options, const std::string& file)
        : element_(element), options_(options) {
        findCoordinates(file);
        for (std::size_t c = 0; c < element.properties.size(); ++c) {
            const PlyProperty& p = element.properties[c];
            is_real_.push_back(isReal(p.type) && p.name != options.id);
            is_read_.push_back(!p.is_list && (options.attributes || isCoordinate(c)));
        }
    }

    template <typename Source>
    void read(Source& source, FileContents& contents) const {
        if constexpr (std::is_same_v<Source, BinaryPlyNumbers>) {
            if (const std::size_t row_bytes = bytesOfRow()) {
                const auto decode = [&](const std::byte* first, std::size_t rows) {
                    return assembled(rowsFrom(first, rows, row_bytes, source.swapBytes()));
                };
                return deliverRows(source.cursor(), element_.rows, row_bytes, decode, options_, contents);
            }
        }
        constexpr std::uint64_t kRowsInBlock = 1 << 14;
        std::uint64_t row = 0;
        do {  // at least once, so that the attributes are declared
            const auto rows = static_cast<std::size_t>(std::min(kRowsInBlock, element_.rows - row));
            deliver(assembled(rowsFrom(source, rows)), element_.rows, options_, contents);
            row += rows;
        } while (row < element_.rows);
    }

    template <typename Source>
    static void skipList(Source& source, const PlyProperty& p) {
        const std::int64_t count = source.integer(p.count_type);
        if (count < 0) source.fail("a list has the negative length " + std::to_string(count));
        source.skip(p.type, static_cast<std::uint64_t>(count));
    }

private:
    bool isCoordinate(std::size_t c) const { return std::find(xyz_.begin(), xyz_.end(), c) != xyz_.end(); }

    /// Finds the properties of the position: x y z, else px py pz, pos_x … or position_x …, in any case.
    void findCoordinates(const std::string& file) {
        const auto& all = element_.properties;
        const auto indexOf = [&](const std::string& name, bool any_case) {
            const auto same = [&](char a, char b) { return a == b || (any_case && (a | 0x20) == b); };
            return static_cast<std::size_t>(std::find_if(all.begin(), all.end(),
                                                         [&](const PlyProperty& p) {
                                                             return !p.is_list &&
                                                                    std::equal(p.name.begin(), p.name.end(),
                                                                               name.begin(), name.end(), same);
                                                         }) -
                                            all.begin());
        };
        for (const bool any_case : {false, true})
            for (const char* before : {"", "p", "pos_", "position_"}) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    xyz_[axis] = indexOf(before + std::string(1, "xyz"[axis]), any_case);
                if (*std::max_element(xyz_.begin(), xyz_.end()) < all.size()) return;
            }
        for (const char* name : {"x", "y", "z"})
            if (indexOf(name, false) == all.size())
                throw Error(file + ": element 'vertex' has no property '" + name + "'; it needs x, y and z");
    }

    /// A block with space for this many rows, and with attributes in the order of the properties.
    VertexRows emptyRows(std::size_t rows) const {
        VertexRows vertices;
        FileContents& points = vertices.points;
        std::vector<Column>& columns = vertices.columns;
        points.position.resize(rows);
        columns.resize(element_.properties.size());
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (is_read_[c] && !is_real_[c]) columns[c].integer.resize(rows);
        for (int axis = 0; axis < 3; ++axis)
            if (const std::size_t c = coordinateAlong(axis); is_real_[c]) {
                points.has_double_positions |= element_.properties[c].type == PlyNumber::float64;
                columns[c].real = rows > 0 ? &points.position[0][axis] : nullptr;
                columns[c].step = 3;
                columns[c].shift = options_.origin[axis];
            }
        visitAttributes([&](std::size_t c, std::size_t size, const std::string& name) {
            Attribute& a = points.attributes.emplace_back();
            a.name = name;
            a.components = static_cast<std::uint32_t>(size);
            if (is_real_[c]) a.real.resize(rows * size);
            for (std::size_t k = 0; !a.real.empty() && k < size; ++k)
                columns[c + k].real = a.real.data() + k, columns[c + k].step = size;
        });
        return vertices;
    }

    /// Rounds a number to single precision, and records the first one in each column that is too large for that.
    void putDouble(VertexRows& vertices, std::size_t c, std::size_t row, double value, std::size_t line = 0) const {
        const Column& column = vertices.columns[c];
        const auto rounded = static_cast<float>(value - column.shift);
        column.put(row, rounded);
        if (!std::isfinite(rounded) && std::isfinite(value))
            noteLost({element_.properties[c].name, row, value, line}, vertices.points.lost_numbers);
    }

    template <typename Source>
    void putFloat(VertexRows& vertices, std::size_t c, std::size_t row, Source& source) const {
        const PlyProperty& p = element_.properties[c];
        const float number = source.real(p.type);
        vertices.columns[c].put(row, number);
        if (!std::isfinite(number) && std::isfinite(source.unrounded()))
            noteLost({p.name, row, source.unrounded(), source.line()}, vertices.points.lost_numbers);
    }

    /// Reads a block number by number.
    template <typename Source>
    VertexRows rowsFrom(Source& source, std::size_t rows) const {
        VertexRows vertices = emptyRows(rows);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t c = 0; c < vertices.columns.size(); ++c) {
                const PlyProperty& p = element_.properties[c];
                if (p.is_list)
                    skipList(source, p);
                else if (!is_read_[c])
                    source.skip(p.type, 1);
                else if (is_real_[c] && (vertices.columns[c].shift != 0 || p.type == PlyNumber::float64))
                    putDouble(vertices, c, row, source.wide(p.type), source.line());
                else if (is_real_[c])
                    putFloat(vertices, c, row, source);
                else
                    vertices.columns[c].integer[row] = source.integer(p.type);
            }
        return vertices;
    }

    /// Bytes per row; 0 if rows differ in length (lists) or numbers have to be checked one by one (floating-point ids).
    std::size_t bytesOfRow() const {
        std::size_t bytes = 0;
        for (std::size_t c = 0; c < is_real_.size(); ++c) {
            const PlyProperty& p = element_.properties[c];
            if (p.is_list || (isReal(p.type) && !is_real_[c])) return 0;
            bytes += sizeOf(p.type);
        }
        return bytes;
    }

    /// Decodes a block of rows of fixed size.
    VertexRows rowsFrom(const std::byte* at, std::size_t rows, std::size_t row_bytes, bool swap_bytes) const {
        VertexRows vertices = emptyRows(rows);
        for (std::size_t c = 0; c < vertices.columns.size(); ++c) {
            Column& column = vertices.columns[c];
            const PlyNumber type = element_.properties[c].type;
            withType(type, [&](auto zero) {
                using T = decltype(zero);
                for (std::size_t row = 0; row < (is_read_[c] ? rows : 0); ++row) {
                    const T value = loadNumber<T>(at + row * row_bytes, swap_bytes);
                    if constexpr (std::is_same_v<T, double>)
                        putDouble(vertices, c, row, value);
                    else if constexpr (std::is_same_v<T, float>)
                        column.put(row, static_cast<float>(column.shift == 0 ? value : value - column.shift));
                    else
                        column.integer[row] = value;
                }
            });
            at += sizeOf(type);
        }
        return vertices;
    }

    /// Moves the integers of a block to positions, ids and attributes.
    FileContents assembled(VertexRows&& vertices) const {
        FileContents& points = vertices.points;
        const std::vector<Column>& columns = vertices.columns;
        const std::size_t rows = points.position.size();
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t c = coordinateAlong(axis);
            for (std::size_t i = 0; !is_real_[c] && i < rows; ++i)
                points.position[i][axis] =
                    options_.origin[axis] == 0
                        ? static_cast<float>(columns[c].integer[i])
                        : static_cast<float>(static_cast<double>(columns[c].integer[i]) - options_.origin[axis]);
        }
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (is_read_[c] && isId(element_.properties[c]))
                for (const std::int64_t id : columns[c].integer) points.id.push_back(static_cast<std::uint64_t>(id));
        std::size_t attribute = 0;
        visitAttributes([&](std::size_t c, std::size_t size, const std::string& name) {
            Attribute& a = points.attributes[attribute++];
            if (is_real_[c]) return;
            std::vector<std::int64_t> values(rows * size);
            for (std::size_t k = 0; k < size; ++k)
                for (std::size_t i = 0; i < rows; ++i) values[i * size + k] = columns[c + k].integer[i];
            a = integerAttribute(name, a.components, std::move(values));
            a.integer_type = integerType(c, size);
        });
        return std::move(points);
    }

    /// The type of the properties from c on, if they all have the same.
    IntegerType integerType(std::size_t c, std::size_t size) const {
        for (std::size_t k = 1; k < size; ++k)
            if (element_.properties[c + k].type != element_.properties[c].type) return IntegerType::int32;
        switch (element_.properties[c].type) {
            case PlyNumber::int8:
                return IntegerType::int8;
            case PlyNumber::uint8:
                return IntegerType::uint8;
            case PlyNumber::int16:
                return IntegerType::int16;
            case PlyNumber::uint16:
                return IntegerType::uint16;
            default:
                return IntegerType::int32;
        }
    }

    std::size_t coordinateAlong(int axis) const { return xyz_[static_cast<std::size_t>(axis)]; }

    /// Number of columns, from c on, that form one attribute: a_x a_y …, a_0 a_1 …, vx vy vz or nx ny nz. Sets its
    /// name.
    std::size_t groupSize(std::size_t c, std::string& name) const {
        const auto& all = element_.properties;
        const auto same = [&](std::size_t i, const std::string& expected) {
            return i < all.size() && all[i].name == expected && !all[i].is_list && is_real_[i] == is_real_[c];
        };
        name = all[c].name;
        if (name == "vx" && same(c + 1, "vy") && same(c + 2, "vz")) {
            name = "v";
            return 3;
        }
        if (name == "nx" && is_real_[c] && same(c + 1, "ny") && same(c + 2, "nz")) {
            name = "N";
            return 3;
        }
        if (name.size() < 3 || !(name.ends_with("_x") || name.ends_with("_0"))) return 1;
        const std::string stem = name.substr(0, name.size() - 1);
        const bool letters = name.back() == 'x';
        std::size_t size = 1;
        while (same(c + size, stem + (letters ? std::string(1, "xyzw "[size]) : std::to_string(size)))) ++size;
        if (size > 1) name = stem.substr(0, stem.size() - 1);
        return size;
    }

    bool isId(const PlyProperty& p) const { return p.name == options_.id; }

    /// Calls visit(first column, number of columns, name) for every attribute that is to be read.
    template <typename Visit>
    void visitAttributes(const Visit& visit) const {
        for (std::size_t c = 0; c < element_.properties.size();) {
            const PlyProperty& p = element_.properties[c];
            std::string name;
            const std::size_t size = !is_read_[c] || isCoordinate(c) || isId(p) ? 0 : groupSize(c, name);
            if (size > 0) visit(c, size, name);
            c += std::max<std::size_t>(size, 1);
        }
    }

    const PlyElement& element_;
    const ReadOptions& options_;
    std::array<std::size_t, 3> xyz_{};     // properties of the position
    std::vector<bool> is_real_, is_read_;  // of each property
};

bool isFaceList(const PlyProperty& p) { return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index"); }

/// Whether a property is `component`, of a type that fits in a signed 32-bit integer.
bool isComponent(const PlyProperty& p) {
    return !p.is_list && !isReal(p.type) && p.type != PlyNumber::uint32 && sizeOf(p.type) <= 4 && p.name == kComponent;
}

template <typename Source>
void readFaces(Source& source, const PlyElement& element, std::uint64_t points, FileContents& contents) {
    std::vector<std::uint32_t> corners;
    const auto& properties = element.properties;
    if (std::any_of(properties.begin(), properties.end(), isComponent)) contents.component.emplace();
    for (std::uint64_t row = 0; row < element.rows; ++row) {
        std::int32_t component = 0;
        for (const PlyProperty& p : element.properties) {
            if (isComponent(p)) {
                component = static_cast<std::int32_t>(source.integer(p.type));
                continue;
            }
            if (!isFaceList(p)) {
                if (p.is_list)
                    VertexReader::skipList(source, p);
                else
                    source.skip(p.type, 1);
                continue;
            }
            const std::int64_t size = source.integer(p.count_type);
            if (size < 0)
                source.fail("face " + std::to_string(row) + " has a negative number of corners, " +
                            std::to_string(size));
            source.requireItems(static_cast<std::uint64_t>(size), p.type);
            corners.resize(static_cast<std::size_t>(size));
            for (std::uint32_t& corner : corners) {
                const std::int64_t index = source.integer(p.type);
                if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                    source.fail("face " + std::to_string(row) + " has corner " + std::to_string(index) +
                                ", but there are only " + std::to_string(points) + " vertices");
                corner = static_cast<std::uint32_t>(index);
            }
            appendFan(corners, contents.triangles);
        }
        if (contents.component) contents.component->resize(contents.triangles.size(), component);
    }
}

bool isEdgeEnd(const PlyProperty& p, const char* name) { return !p.is_list && !isReal(p.type) && p.name == name; }

bool isEdges(const PlyElement& element) {
    const auto has = [&](const char* name) {
        return std::any_of(element.properties.begin(), element.properties.end(),
                           [&](const PlyProperty& p) { return isEdgeEnd(p, name); });
    };
    return element.name == "edge" && has("vertex1") && has("vertex2");
}

template <typename Source>
void readEdges(Source& source, const PlyElement& element, std::uint64_t points, FileContents& contents) {
    for (std::uint64_t row = 0; row < element.rows; ++row) {
        Edge edge{};
        for (const PlyProperty& p : element.properties) {
            const bool first = isEdgeEnd(p, "vertex1");
            if (!first && !isEdgeEnd(p, "vertex2")) {
                if (p.is_list)
                    VertexReader::skipList(source, p);
                else
                    source.skip(p.type, 1);
                continue;
            }
            const std::int64_t index = source.integer(p.type);
            if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                source.fail("edge " + std::to_string(row) + " has vertex " + std::to_string(index) +
                            ", but there are only " + std::to_string(points) + " vertices");
            edge[first ? 0 : 1] = static_cast<std::uint32_t>(index);
        }
        contents.edges.push_back(edge);
    }
}

template <typename Source>
void readElements(Source& source, const PlyHeader& header, const ReadOptions& options, const std::string& file,
                  FileContents& contents) {
    const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex" && !e.properties.empty(); });
    if (vertex == header.elements.end())
        throw Error(file + ": has no element 'vertex', so there are no points to read");
    for (const PlyElement& element : header.elements) {
        if (element.properties.empty()) continue;
        source.requireRows(element);
        if (element.name == "vertex") {
            VertexReader(element, options, file).read(source, contents);
            if (!options.faces) return;
        } else if (element.name == "face" && options.faces) {
            contents.declares_faces = true;
            readFaces(source, element, vertex->rows, contents);
        } else if (isEdges(element) && options.faces) {
            contents.declares_edges = true;
            readEdges(source, element, vertex->rows, contents);
        } else {
            for (std::uint64_t row = 0; row < element.rows; ++row)
                for (const PlyProperty& p : element.properties) {
                    if (p.is_list)
                        VertexReader::skipList(source, p);
                    else
                        source.skip(p.type, 1);
                }
        }
    }
}

}  // namespace

FileContents parsePly(Cursor in, const ReadOptions& options) {
    const std::string& file = in.file();
    const PlyHeader header = readPlyHeader(in);
    FileContents contents;
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex")
            for (const PlyProperty& p : element.properties)
                contents.declared.push_back({p.name, p.is_list ? "list of " + nameOf(p.type) : nameOf(p.type), 1, {}});
        if (element.name == "face" && !options.faces && std::ranges::any_of(element.properties, isFaceList))
            contents.unread_polygons += element.rows;
    }
    if (header.encoding == PlyEncoding::ascii) {
        contents.format = "ply ascii";
        AsciiPlyNumbers source(in, header.lines);
        readElements(source, header, options, file, contents);
    } else {
        contents.format = header.encoding == PlyEncoding::little ? "ply binary_little_endian" : "ply binary_big_endian";
        BinaryPlyNumbers source(in, header.encoding);
        readElements(source, header, options, file, contents);
    }
    return contents;
}

}  // namespace betamesh
