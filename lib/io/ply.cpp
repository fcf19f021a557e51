
#include "io/ply.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

namespace {

// source  "The PLY Polygon File Format", Greg Turk, 1994; the type names with sizes are later usage.

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxProperties = 4096;

enum class Number { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
    std::string name;
    Number type = Number::float32;
    bool is_list = false;
    Number count_type = Number::uint8;
};

struct Element {
    std::string name;
    std::uint64_t rows = 0;
    std::vector<Property> properties;
};

enum class Encoding { ascii, little, big };

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
};

constexpr std::array<std::pair<std::string_view, Number>, 16> kNumberNames{{{"char", Number::int8},
                                                                            {"uchar", Number::uint8},
                                                                            {"short", Number::int16},
                                                                            {"ushort", Number::uint16},
                                                                            {"int", Number::int32},
                                                                            {"uint", Number::uint32},
                                                                            {"float", Number::float32},
                                                                            {"double", Number::float64},
                                                                            {"int8", Number::int8},
                                                                            {"uint8", Number::uint8},
                                                                            {"int16", Number::int16},
                                                                            {"uint16", Number::uint16},
                                                                            {"int32", Number::int32},
                                                                            {"uint32", Number::uint32},
                                                                            {"float32", Number::float32},
                                                                            {"float64", Number::float64}}};

bool isReal(Number type) { return type == Number::float32 || type == Number::float64; }

std::string nameOf(Number type) { return std::string(kNumberNames[static_cast<std::size_t>(type)].first); }

/// Calls visit with a value of the C++ type.
template <typename Visit>
auto withType(Number type, const Visit& visit) {
    switch (type) {
        case Number::int8:
            return visit(std::int8_t{});
        case Number::uint8:
            return visit(std::uint8_t{});
        case Number::int16:
            return visit(std::int16_t{});
        case Number::uint16:
            return visit(std::uint16_t{});
        case Number::int32:
            return visit(std::int32_t{});
        case Number::uint32:
            return visit(std::uint32_t{});
        case Number::float32:
            return visit(float{});
        case Number::float64:
            break;
    }
    return visit(double{});
}

std::size_t sizeOf(Number type) {
    return withType(type, [](auto zero) { return sizeof(zero); });
}

// The header.

std::vector<std::string_view> wordsOf(std::string_view line) {
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t begin = line.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return words;
        line.remove_prefix(begin);
        const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

/// For messages: what a damaged file holds may not be fit to print.
std::string inQuotes(std::string_view text) {
    std::string shown = "'";
    for (const char c : text.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
    return shown + (text.size() > 60 ? "…'" : "'");
}

class HeaderReader {
public:
    explicit HeaderReader(Cursor& in) : in_(in) {}

    Header read() {
        if (nextLine() != "ply") in_.fail("expected 'ply' in the first line");
        bool has_format = false;
        for (;;) {
            const std::string_view line = nextLine();
            const auto words = wordsOf(line);
            if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
            if (words[0] == "end_header") break;
            if (words[0] == "format") {
                readFormat(words);
                has_format = true;
            } else if (words[0] == "element") {
                readElement(words);
            } else if (words[0] == "property") {
                readProperty(words);
            } else {
                fail("found " + inQuotes(line) + ", expected format, comment, element, property or end_header");
            }
        }
        if (!has_format) fail("the header has no format line");
        return std::move(header_);
    }

private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(in_.file() + ": header line " + std::to_string(line_) + ": " + text);
    }

    std::string_view nextLine() {
        ++line_;
        std::string_view rest = in_.peek(1);
        if (rest.find('\n') == std::string_view::npos) rest = in_.peek(kMaxHeaderBytes);
        const std::size_t length = rest.substr(0, kMaxHeaderBytes).find('\n');
        if (length == std::string_view::npos || in_.offset() + length > kMaxHeaderBytes)
            fail("no end_header, expected one within a MiB");
        std::string_view line = rest.substr(0, length);
        in_.take(length + 1, "header");
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }

    void readFormat(const std::vector<std::string_view>& words) {
        const std::string_view name = words.size() > 1 ? words[1] : "";
        if (name == "ascii")
            header_.encoding = Encoding::ascii;
        else if (name == "binary_little_endian")
            header_.encoding = Encoding::little;
        else if (name == "binary_big_endian")
            header_.encoding = Encoding::big;
        else
            fail("format is " + inQuotes(name) + ", expected ascii, binary_little_endian or binary_big_endian");
    }

    void readElement(const std::vector<std::string_view>& words) {
        Element element;
        if (words.size() != 3) fail("expected 'element', a name and a count");
        element.name = words[1];
        const char* end = words[2].data() + words[2].size();
        const auto [stop, error] = std::from_chars(words[2].data(), end, element.rows);
        if (error != std::errc() || stop != end) fail("count is " + inQuotes(words[2]) + ", expected 0 or more");
        for (const Element& other : header_.elements)
            if (other.name == element.name) fail("element " + inQuotes(element.name) + " is declared twice");
        if (header_.elements.size() == kMaxProperties) fail("too many elements");
        header_.elements.push_back(std::move(element));
    }

    Number numberType(std::string_view name) const {
        for (const auto& [word, type] : kNumberNames)
            if (word == name) return type;
        fail("type is " + inQuotes(name) + ", expected char, uchar, short, ushort, int, uint, float or double");
    }

    void readProperty(const std::vector<std::string_view>& words) {
        if (header_.elements.empty()) fail("a property before any element");
        Element& element = header_.elements.back();
        Property property;
        property.is_list = words.size() == 5 && words[1] == "list";
        if (!property.is_list && words.size() != 3) fail("expected 'property', a type and a name");
        if (property.is_list) {
            property.count_type = numberType(words[2]);
            if (isReal(property.count_type)) fail("the length of a list is a " + nameOf(property.count_type));
        }
        property.type = numberType(words[words.size() - 2]);
        property.name = words.back();
        for (const Property& other : element.properties)
            if (other.name == property.name) fail("property " + inQuotes(property.name) + " is declared twice");
        if (++properties_ > kMaxProperties) fail("more than " + std::to_string(kMaxProperties) + " properties");
        element.properties.push_back(std::move(property));
    }

    Cursor& in_;
    Header header_;
    std::size_t line_ = 0;
    std::size_t properties_ = 0;
};

// The rows. Both sources give one number after another.

/// A whole number out of a real one, as some writers store ids.
template <typename Source>
std::int64_t wholeFrom(double value, const Source& source) {
    if (!(std::abs(value) <= 9007199254740992.0) || std::trunc(value) != value)
        source.fail("found " + std::to_string(value) + ", expected a whole number of at most 2^53");
    return static_cast<std::int64_t>(value);
}

class BinarySource {
public:
    BinarySource(Cursor& in, Encoding encoding)
        : in_(in), other_order_((encoding == Encoding::little) != (std::endian::native == std::endian::little)) {}

    float real(Number type) {
        return withType(type, [&](auto zero) { return static_cast<float>(next<decltype(zero)>()); });
    }
    std::int64_t whole(Number type) {
        return withType(type, [&](auto zero) {
            const auto value = next<decltype(zero)>();
            if constexpr (std::is_floating_point_v<decltype(zero)>)
                return wholeFrom(double{value}, in_);
            else
                return static_cast<std::int64_t>(value);
        });
    }
    void skip(Number type, std::uint64_t count) {
        in_.requireRows(count, sizeOf(type), "a list");
        in_.skip(count * sizeOf(type), "a list");
    }
    void requireItems(std::uint64_t count, Number type) const { in_.requireRows(count, sizeOf(type), "a list"); }

    void requireRows(const Element& element) const {
        std::size_t least = 0;
        for (const Property& p : element.properties) least += sizeOf(p.is_list ? p.count_type : p.type);
        in_.requireRows(element.rows, least, element.name.c_str());
    }
    [[noreturn]] void fail(const std::string& text) const { in_.fail(text); }

    Cursor& cursor() { return in_; }
    bool otherOrder() const { return other_order_; }

private:
    template <typename T>
    T next() {
        return loadNumber<T>(in_.take(sizeof(T), "a number"), other_order_);
    }
    Cursor& in_;
    bool other_order_;
};

class AsciiSource {
public:
    explicit AsciiSource(Cursor& in) : in_(in) {}

    float real(Number type) {
        if (!isReal(type)) return static_cast<float>(whole(type));
        const std::string_view word = next();
        float value = 0;
        if (parse(word, value)) return value;
        double wide = 0;  // beyond the range of a float: an infinity or a zero
        if (parse(word, wide)) return static_cast<float>(wide);
        fail("found " + inQuotes(word) + ", expected a number");
    }
    std::int64_t whole(Number type) {
        const std::string_view word = next();
        if (isReal(type)) {
            double value = 0;
            if (!parse(word, value)) fail("found " + inQuotes(word) + ", expected a number");
            return wholeFrom(value, *this);
        }
        std::int64_t value = 0;
        if (!parse(word, value)) fail("found " + inQuotes(word) + ", expected a whole number");
        const bool fits = withType(type, [&](auto zero) {
            using Limits = std::numeric_limits<decltype(zero)>;
            return static_cast<double>(value) >= static_cast<double>(Limits::lowest()) &&
                   static_cast<double>(value) <= static_cast<double>(Limits::max());
        });
        if (!fits) fail("found " + inQuotes(word) + ", which is no " + nameOf(type));
        return value;
    }
    void skip(Number, std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i) next();
    }
    /// A number and the space before the next take two characters.
    void requireItems(std::uint64_t count, Number) const {
        if (count > in_.remaining() / 2 + 1)
            fail("a list of " + std::to_string(count) + " numbers does not fit in the rest of the file");
    }
    void requireRows(const Element& element) const {
        const std::uint64_t numbers = in_.remaining() / 2 + 1;
        if (element.rows > numbers / element.properties.size())
            fail(std::to_string(element.rows) + " rows of '" + element.name +
                 "' do not fit in the rest of the file (truncated, or a damaged count)");
    }
    [[noreturn]] void fail(const std::string& text) const { in_.fail(text); }

private:
    static bool isSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

    /// Stays until the next.
    std::string_view next() {
        constexpr std::size_t kLongest = 4096;  // of any number
        std::size_t begin = 0;
        std::string_view text = in_.peek(kLongest);
        for (;;) {
            while (begin < text.size() && isSpace(text[begin])) ++begin;
            if (begin < text.size()) break;
            if (text.empty()) fail("the file ends, expected more numbers (truncated, or a damaged count)");
            in_.take(std::exchange(begin, 0), "white space");
            text = in_.peek(kLongest);
        }
        if (text.size() - begin < kLongest) {
            in_.take(std::exchange(begin, 0), "white space");
            text = in_.peek(kLongest);
        }
        std::size_t end = begin;
        while (end < text.size() && !isSpace(text[end])) ++end;
        in_.take(end, "a number");
        return text.substr(begin, end - begin);
    }
    template <typename T>
    static bool parse(std::string_view word, T& value) {
        if (word.starts_with('+')) word.remove_prefix(1);
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        return error == std::errc() && stop == word.data() + word.size();
    }

    Cursor& in_;
};

/// Where the numbers of a scalar property go: from `real` on, `step` apart, or into a list of whole ones, or nowhere.
struct Column {
    float* real = nullptr;
    std::size_t step = 1;
    std::vector<std::int64_t> whole{};

    void put(std::size_t row, float number) const { real[row * step] = number; }
};

/// Some rows of vertices, and where their numbers go.
struct VertexRows {
    FileContents points;
    std::vector<Column> columns;
};

class VertexReader {
public:
    VertexReader(const Element& element, const ReadOptions& options, const std::string& file)
        : element_(element), options_(options) {
        for (const Property& p : element.properties) {
            is_real_.push_back(isReal(p.type) && p.name != options.id);
            is_wanted_.push_back(!p.is_list && (options.attributes || isCoordinate(p)));
        }
        for (const char* name : {"x", "y", "z"}) coordinate(name, file);
    }

    template <typename Source>
    void read(Source& source, FileContents& contents) const {
        if constexpr (std::is_same_v<Source, BinarySource>) {
            if (const std::size_t row_bytes = bytesOfRow()) {
                const auto decode = [&](const std::byte* first, std::size_t rows) {
                    return assembled(rowsFrom(first, rows, row_bytes, source.otherOrder()));
                };
                return deliverRows(source.cursor(), element_.rows, row_bytes, decode, options_, contents);
            }
        }
        constexpr std::uint64_t kRowsAtOnce = 1 << 14;
        std::uint64_t row = 0;
        do {  // once where there are none, too: names of attributes are told
            const auto rows = static_cast<std::size_t>(std::min(kRowsAtOnce, element_.rows - row));
            deliver(assembled(rowsFrom(source, rows)), element_.rows, options_, contents);
            row += rows;
        } while (row < element_.rows);
    }

    template <typename Source>
    static void skipList(Source& source, const Property& p) {
        const std::int64_t count = source.whole(p.count_type);
        if (count < 0) source.fail("a list has length " + std::to_string(count));
        source.skip(p.type, static_cast<std::uint64_t>(count));
    }

private:
    static bool isCoordinate(const Property& p) { return p.name == "x" || p.name == "y" || p.name == "z"; }

    /// With room for so many, and attributes in the order of their properties.
    VertexRows emptyRows(std::size_t rows) const {
        VertexRows vertices;
        auto& [points, columns] = vertices;
        points.position.resize(rows);
        columns.resize(element_.properties.size());
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (is_wanted_[c] && !is_real_[c]) columns[c].whole.resize(rows);
        for (int axis = 0; axis < 3; ++axis)
            if (const std::size_t c = coordinateAlong(axis); is_real_[c] && rows > 0)
                columns[c].real = &points.position[0][axis], columns[c].step = 3;
        forGroups([&](std::size_t c, std::size_t size, const std::string& name) {
            Attribute& a = points.attributes.emplace_back(name, static_cast<std::uint32_t>(size));
            if (is_real_[c]) a.real.resize(rows * size);
            for (std::size_t k = 0; !a.real.empty() && k < size; ++k)
                columns[c + k].real = a.real.data() + k, columns[c + k].step = size;
        });
        return vertices;
    }

    /// Number by number.
    template <typename Source>
    VertexRows rowsFrom(Source& source, std::size_t rows) const {
        VertexRows vertices = emptyRows(rows);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t c = 0; c < vertices.columns.size(); ++c) {
                const Property& p = element_.properties[c];
                if (p.is_list)
                    skipList(source, p);
                else if (!is_wanted_[c])
                    source.skip(p.type, 1);
                else if (is_real_[c])
                    vertices.columns[c].put(row, source.real(p.type));
                else
                    vertices.columns[c].whole[row] = source.whole(p.type);
            }
        return vertices;
    }

    /// Where all rows are alike and no number needs a check of its own, as those of lists and real ids do; else 0.
    std::size_t bytesOfRow() const {
        std::size_t bytes = 0;
        for (std::size_t c = 0; c < is_real_.size(); ++c) {
            const Property& p = element_.properties[c];
            if (p.is_list || (isReal(p.type) && !is_real_[c])) return 0;
            bytes += sizeOf(p.type);
        }
        return bytes;
    }

    VertexRows rowsFrom(const std::byte* at, std::size_t rows, std::size_t row_bytes, bool other_order) const {
        VertexRows vertices = emptyRows(rows);
        for (std::size_t c = 0; c < vertices.columns.size(); ++c) {
            Column& column = vertices.columns[c];
            const Number type = element_.properties[c].type;
            withType(type, [&](auto zero) {
                using T = decltype(zero);
                for (std::size_t row = 0; row < (is_wanted_[c] ? rows : 0); ++row) {
                    const T value = loadNumber<T>(at + row * row_bytes, other_order);
                    if constexpr (std::is_floating_point_v<T>)
                        column.put(row, static_cast<float>(value));
                    else
                        column.whole[row] = value;
                }
            });
            at += sizeOf(type);
        }
        return vertices;
    }

    /// With what whole numbers there are in their places.
    FileContents assembled(VertexRows&& vertices) const {
        auto& [points, columns] = vertices;
        const std::size_t rows = points.position.size();
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t c = coordinateAlong(axis);
            for (std::size_t i = 0; !is_real_[c] && i < rows; ++i)
                points.position[i][axis] = static_cast<float>(columns[c].whole[i]);
        }
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (is_wanted_[c] && isId(element_.properties[c]))
                for (const std::int64_t id : columns[c].whole) points.id.push_back(idFrom(id));
        std::size_t attribute = 0;
        forGroups([&](std::size_t c, std::size_t size, const std::string& name) {
            Attribute& a = points.attributes[attribute++];
            if (is_real_[c]) return;
            std::vector<std::int64_t> values(rows * size);
            for (std::size_t k = 0; k < size; ++k)
                for (std::size_t i = 0; i < rows; ++i) values[i * size + k] = columns[c + k].whole[i];
            a = integerAttribute(name, a.components, std::move(values));
        });
        return std::move(points);
    }

    std::size_t coordinate(const char* name, const std::string& file) const {
        for (std::size_t c = 0; c < element_.properties.size(); ++c)
            if (element_.properties[c].name == name && !element_.properties[c].is_list) return c;
        throw Error(file + ": element 'vertex' has no property '" + name + "', expected x, y and z");
    }

    std::size_t coordinateAlong(int axis) const {
        return coordinate(std::array{"x", "y", "z"}[static_cast<std::size_t>(axis)], "");
    }

    /// How many columns from c on belong to one attribute: a_x a_y …, a_0 a_1 …, or vx vy vz.
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
        if (name.size() < 3 || !(name.ends_with("_x") || name.ends_with("_0"))) return 1;
        const std::string stem = name.substr(0, name.size() - 1);
        const bool letters = name.back() == 'x';
        std::size_t size = 1;
        while (same(c + size, stem + (letters ? std::string(1, "xyzw "[size]) : std::to_string(size)))) ++size;
        if (size > 1) name = stem.substr(0, stem.size() - 1);
        return size;
    }

    bool isId(const Property& p) const { return p.name == options_.id; }

    /// Calls visit(first column, how many, name) for every attribute that is wanted.
    template <typename Visit>
    void forGroups(const Visit& visit) const {
        for (std::size_t c = 0; c < element_.properties.size();) {
            const Property& p = element_.properties[c];
            std::string name;
            const std::size_t size = !is_wanted_[c] || isCoordinate(p) || isId(p) ? 0 : groupSize(c, name);
            if (size > 0) visit(c, size, name);
            c += std::max<std::size_t>(size, 1);
        }
    }

    /// Negative ids keep their 32 bits, as other formats have them.
    static std::uint64_t idFrom(std::int64_t id) {
        if (id >= std::numeric_limits<std::int32_t>::min() && id < 0)
            return static_cast<std::uint32_t>(static_cast<std::int32_t>(id));
        return static_cast<std::uint64_t>(id);
    }

    const Element& element_;
    const ReadOptions& options_;
    std::vector<bool> is_real_, is_wanted_;  // of each property
};

bool isFaceList(const Property& p) { return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index"); }

/// Of a type that fits in 32 bits with a sign.
bool isComponent(const Property& p) {
    return !p.is_list && !isReal(p.type) && p.type != Number::uint32 && p.name == kComponent;
}

template <typename Source>
void readFaces(Source& source, const Element& element, std::uint64_t points, FileContents& contents) {
    std::vector<std::uint32_t> corners;
    const auto& properties = element.properties;
    if (std::any_of(properties.begin(), properties.end(), isComponent)) contents.component.emplace();
    for (std::uint64_t row = 0; row < element.rows; ++row) {
        std::int32_t component = 0;
        for (const Property& p : element.properties) {
            if (isComponent(p)) {
                component = static_cast<std::int32_t>(source.whole(p.type));
                continue;
            }
            if (!isFaceList(p)) {
                if (p.is_list)
                    VertexReader::skipList(source, p);
                else
                    source.skip(p.type, 1);
                continue;
            }
            const std::int64_t size = source.whole(p.count_type);
            if (size < 0) source.fail("face " + std::to_string(row) + " has " + std::to_string(size) + " corners");
            source.requireItems(static_cast<std::uint64_t>(size), p.type);
            corners.resize(static_cast<std::size_t>(size));
            for (std::uint32_t& corner : corners) {
                const std::int64_t index = source.whole(p.type);
                if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                    source.fail("face " + std::to_string(row) + " has corner " + std::to_string(index) +
                                ", expected 0 to less than " + std::to_string(points));
                corner = static_cast<std::uint32_t>(index);
            }
            appendFan(corners, contents.triangles);
        }
        if (contents.component) contents.component->resize(contents.triangles.size(), component);
    }
}

bool isEdgeEnd(const Property& p, const char* name) { return !p.is_list && !isReal(p.type) && p.name == name; }

bool isEdges(const Element& element) {
    const auto has = [&](const char* name) {
        return std::any_of(element.properties.begin(), element.properties.end(),
                           [&](const Property& p) { return isEdgeEnd(p, name); });
    };
    return element.name == "edge" && has("vertex1") && has("vertex2");
}

template <typename Source>
void readEdges(Source& source, const Element& element, std::uint64_t points, FileContents& contents) {
    for (std::uint64_t row = 0; row < element.rows; ++row) {
        Edge edge{};
        for (const Property& p : element.properties) {
            const bool first = isEdgeEnd(p, "vertex1");
            if (!first && !isEdgeEnd(p, "vertex2")) {
                if (p.is_list)
                    VertexReader::skipList(source, p);
                else
                    source.skip(p.type, 1);
                continue;
            }
            const std::int64_t index = source.whole(p.type);
            if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                source.fail("edge " + std::to_string(row) + " has vertex " + std::to_string(index) +
                            ", expected 0 to less than " + std::to_string(points));
            edge[first ? 0 : 1] = static_cast<std::uint32_t>(index);
        }
        contents.edges.push_back(edge);
    }
}

template <typename Source>
void readElements(Source& source, const Header& header, const ReadOptions& options, const std::string& file,
                  FileContents& contents) {
    bool has_vertices = false;
    std::uint64_t points = 0;
    for (const Element& element : header.elements) {
        if (has_vertices && !options.faces) return;
        if (element.properties.empty()) continue;
        source.requireRows(element);
        if (element.name == "vertex") {
            VertexReader(element, options, file).read(source, contents);
            points = element.rows;
            has_vertices = true;
        } else if (element.name == "face") {
            if (!has_vertices) throw Error(file + ": faces stand before the vertices, expected after");
            contents.declares_faces = true;
            readFaces(source, element, points, contents);
        } else if (isEdges(element)) {
            if (!has_vertices) throw Error(file + ": edges stand before the vertices, expected after");
            contents.declares_edges = true;
            readEdges(source, element, points, contents);
        } else {
            for (std::uint64_t row = 0; row < element.rows; ++row)
                for (const Property& p : element.properties) {
                    if (p.is_list)
                        VertexReader::skipList(source, p);
                    else
                        source.skip(p.type, 1);
                }
        }
    }
    if (!has_vertices) throw Error(file + ": has no element 'vertex'");
}

// Writing.

std::string suffix(std::uint32_t component, std::uint32_t components) {
    if (components == 1) return {};
    if (components <= 4) return std::string("_") + "xyzw"[component];
    return "_" + std::to_string(component);
}

class PlyWriter {
public:
    PlyWriter(ByteWriter& out, std::size_t points) : out_(out) {
        out_.text("ply\nformat binary_little_endian 1.0\ncomment betamesh: world units, seconds\nelement vertex " +
                  std::to_string(points) + "\n");
        scalars("float", {"x", "y", "z"});
    }
    void scalars(const std::string& type, const std::vector<std::string>& names) {
        for (const std::string& name : names) out_.text("property " + type + " " + name + "\n");
    }
    void attributes(const std::vector<Attribute>& attributes) {
        for (const Attribute& a : attributes)
            for (std::uint32_t c = 0; c < a.components; ++c)
                scalars(a.integer.empty() ? "float" : "int", {a.name + suffix(c, a.components)});
    }
    void faces(std::size_t count, bool components) {
        out_.text("element face " + std::to_string(count) + "\nproperty list uchar int vertex_indices\n");
        if (components) scalars("int", {kComponent});
    }
    void edges(std::size_t count) {
        out_.text("element edge " + std::to_string(count) + "\n");
        scalars("int", {"vertex1", "vertex2"});
    }
    void endHeader() { out_.text("end_header\n"); }

    template <typename Vector>
    void vector(const Vector& v) {
        out_.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    }
    void attributeRow(const std::vector<Attribute>& attributes, std::size_t row) {
        for (const Attribute& a : attributes)
            for (std::size_t i = row * a.components; i < (row + 1) * a.components; ++i) {
                if (a.integer.empty())
                    out_.little(a.real[i]);
                else
                    out_.little(a.integer[i]);
            }
    }

private:
    ByteWriter& out_;
};

/// The properties of this format that attributes may not be named like, once they are spelt out.
void requireAttributes(const std::vector<Attribute>& attributes, std::size_t n, const std::string& file) {
    std::vector<std::string> taken{"x", "y", "z", "vx", "vy", "vz", "v", "id"};
    requireWritable(attributes, n, taken, file);
    std::vector<Attribute> spelt;
    for (const Attribute& a : attributes)
        for (std::uint32_t c = 0; c < a.components; ++c) spelt.push_back({a.name + suffix(c, a.components), 1, {}, {}});
    requireWritable(spelt, 0, taken, file);
}

}  // namespace

FileContents parsePly(Cursor in, const ReadOptions& options) {
    const std::string& file = in.file();
    const Header header = HeaderReader(in).read();
    FileContents contents;
    for (const Element& element : header.elements)
        if (element.name == "vertex")
            for (const Property& p : element.properties)
                contents.declared.push_back({p.name, p.is_list ? "list of " + nameOf(p.type) : nameOf(p.type), 1, {}});
    if (header.encoding == Encoding::ascii) {
        contents.format = "ply ascii";
        AsciiSource source(in);
        readElements(source, header, options, file, contents);
    } else {
        contents.format = header.encoding == Encoding::little ? "ply binary_little_endian" : "ply binary_big_endian";
        BinarySource source(in, header.encoding);
        readElements(source, header, options, file, contents);
    }
    return contents;
}

void encodePly(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    const bool has_velocity = !particles.velocity.empty() || n == 0;
    const bool has_id = !particles.id.empty() || n == 0;
    requireWritable(particles, file);
    requireAttributes(particles.attributes, n, file);
    PlyWriter ply(out, n);
    if (has_velocity) ply.scalars("float", {"vx", "vy", "vz"});
    if (has_id) ply.scalars("uint", {"id"});
    ply.attributes(particles.attributes);
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(particles.position[i]);
        if (has_velocity) ply.vector(particles.velocity[i]);
        if (has_id) out.little(idOf32Bits(particles.id, i, file));
        ply.attributeRow(particles.attributes, i);
    }
    out.flush();
}

void encodePly(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    const std::size_t n = mesh.position.size();
    requireWritable(mesh, file);
    requireAttributes(mesh.attributes, n, file);
    if (n > std::numeric_limits<std::int32_t>::max())
        throw Error(file + ": " + std::to_string(n) + " vertices, expected less than 2^31");
    PlyWriter ply(out, n);
    ply.scalars("float", {"vx", "vy", "vz"});
    ply.attributes(mesh.attributes);
    ply.faces(mesh.triangles.size(), mesh.component.has_value());
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(mesh.position[i]);
        ply.vector(mesh.velocity.empty() ? Vec3(0, 0, 0) : mesh.velocity[i]);
        ply.attributeRow(mesh.attributes, i);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        out.little(std::uint8_t{3});
        out.little(mesh.triangles[i]);
        if (mesh.component) out.little((*mesh.component)[i]);
    }
    out.flush();
}

void encodePly(ByteWriter& out, const Curves& curves, const std::string& file) {
    const std::size_t n = curves.position.size();
    requireWritable(curves, file);
    requireAttributes(curves.attributes, n, file);
    PlyWriter ply(out, n);
    ply.scalars("float", {"vx", "vy", "vz"});
    ply.attributes(curves.attributes);
    ply.edges(curves.edges.size());
    ply.endHeader();
    for (std::size_t i = 0; i < n; ++i) {
        ply.vector(curves.position[i]);
        ply.vector(curves.velocity.empty() ? Vec3(0, 0, 0) : curves.velocity[i]);
        ply.attributeRow(curves.attributes, i);
    }
    for (const Edge& edge : curves.edges) out.little(edge);
    out.flush();
}

void encodePly(ByteWriter& out, const Spheres& spheres, const std::string& file) {
    encodePly(out, particlesOf(spheres, "radius", file), file);
}

}  // namespace betamesh
