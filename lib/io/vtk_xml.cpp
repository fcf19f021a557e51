// XML files of VTK: .vtu and .vtp in.

#include "io/vtk.h"

#include "io/gzip.h"
#include "io/number_columns.h"
#include "io/vtk_cells.h"

#include <pugixml.hpp>

#include <array>
#include <bit>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

constexpr std::uint64_t kMostPacked = 1100;  // bytes that zlib makes of one, at most about 1,032

const std::map<std::string, NumberType> kTypes{{"Int8", NumberType::int8},       {"UInt8", NumberType::uint8},
                                               {"Int16", NumberType::int16},     {"UInt16", NumberType::uint16},
                                               {"Int32", NumberType::int32},     {"UInt32", NumberType::uint32},
                                               {"Int64", NumberType::int64},     {"UInt64", NumberType::uint64},
                                               {"Float32", NumberType::float32}, {"Float64", NumberType::float64}};

int valueOfBase64(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// The bytes of the next stream of base64, up to and with its padding, or so many bytes if there are; it steps over
/// them.
Bytes base64(std::string_view& text, std::size_t most) {
    Bytes bytes;
    std::uint32_t bits = 0;
    int count = 0;
    std::size_t i = 0;
    for (; i < text.size() && bytes.size() < most; ++i) {
        const char c = text[i];
        if (c == '=') {
            while (i < text.size() && text[i] == '=') ++i;
            break;
        }
        const int value = valueOfBase64(c);
        if (value < 0) {
            if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
            break;
        }
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        count += 6;
        if (count >= 8) bytes.push_back(static_cast<std::byte>(bits >> (count -= 8) & 0xff));
    }
    text.remove_prefix(i);
    return bytes;
}

class XmlReader {
public:
    XmlReader(Bytes&& file, std::string name, const ReadOptions& options)
        : file_(std::move(file)), name_(std::move(name)), options_(options) {}

    FileContents read() {
        parse();
        const pugi::xml_node root = document_.child("VTKFile");
        if (!root) fail("expected an element VTKFile");
        const std::string type = root.attribute("type").value(), compressor = root.attribute("compressor").value(),
                          header = root.attribute("header_type").value(), order = root.attribute("byte_order").value();
        if (type != "UnstructuredGrid" && type != "PolyData")
            fail("the data set is of type '" + type + "', expected points: UnstructuredGrid or PolyData");
        if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
            fail("arrays are compressed by " + compressor + ", expected vtkZLibDataCompressor or no compressor");
        if (!header.empty() && header != "UInt32" && header != "UInt64")
            fail("header_type is '" + header + "', expected UInt32 or UInt64");
        compressed_ = !compressor.empty();
        header_bytes_ = header == "UInt64" ? 8 : 4;
        other_order_ = (order == "BigEndian") != (std::endian::native == std::endian::big);
        contents_.format = "vtk xml " + type + (compressed_ ? ", zlib" : "");
        for (const pugi::xml_node& piece : root.child(type.c_str()).children("Piece")) readPiece(piece);
        return deliverWhole(std::move(contents_), options_);
    }

private:
    /// The XML without its appended data, which need not be XML.
    void parse() {
        const std::string_view text(reinterpret_cast<const char*>(file_.data()), file_.size());
        std::size_t end = text.find("<AppendedData");
        std::string xml(text.substr(0, end));
        if (end != std::string_view::npos) {
            if (text.rfind("</VTKFile") == std::string_view::npos)
                fail("ends without </VTKFile>, so it is truncated or still being written");
            const std::size_t close = text.find('>', end), mark = text.find('_', std::min(close, text.size()));
            if (mark == std::string_view::npos) fail("AppendedData have no '_' before their data");
            const std::string_view tag = text.substr(end, close - end);
            appended_is_base64_ = tag.find("base64") != std::string_view::npos;
            appended_ = text.substr(mark + 1);
            if (appended_is_base64_) appended_ = appended_.substr(0, appended_.find('<'));
            xml += "</VTKFile>";
        }
        const pugi::xml_parse_result result = document_.load_buffer(xml.data(), xml.size());
        if (!result)
            fail("byte " + std::to_string(result.offset) + ": the XML cannot be read: " + result.description());
    }

    void readPiece(const pugi::xml_node& piece) {
        const std::uint64_t n = count(piece, "NumberOfPoints");
        const pugi::xml_node points = piece.child("Points").child("DataArray");
        if (n > 0 && !points) fail("a Piece of " + std::to_string(n) + " points has no Points");
        FileContents some;
        if (points) some.position = positionsFrom(numbers(points, n, 3), 3, options_.origin);
        contents_.has_double_positions |= points && std::string_view(points.attribute("type").value()) == "Float64";
        for (const pugi::xml_node& array : piece.child("PointData").children("DataArray")) {
            const std::string name = attributeName(array.attribute("Name").value());
            const std::uint64_t components = componentsOf(array);
            if (!kTypes.contains(array.attribute("type").value())) continue;  // strings
            addColumn(name, components, numbers(array, n, components), static_cast<std::size_t>(n), options_, name_,
                      some);
            if (!std::exchange(declared_, true)) contents_.declared.push_back({"P", typeOf(points), 3, ""});
            if (pieces_ == 0)
                contents_.declared.push_back(
                    {name, array.attribute("type").value(), static_cast<std::uint32_t>(components), ""});
        }
        if (!std::exchange(declared_, true) && points) contents_.declared.push_back({"P", typeOf(points), 3, ""});
        ++pieces_;
        readCells(piece, some);
        const auto first = static_cast<std::uint32_t>(contents_.position.size());
        for (const Triangle& t : some.triangles)
            contents_.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        for (const Edge& e : some.edges) contents_.edges.push_back({e[0] + first, e[1] + first});
        contents_.declares_faces |= some.declares_faces;
        contents_.declares_edges |= some.declares_edges;
        const bool has_area = !some.triangles.empty();
        readComponents(piece, has_area);
        append({"", {}, std::move(some.position), std::move(some.id), std::move(some.attributes), {}, {}, {}}, n,
               contents_);
    }

    void readCells(const pugi::xml_node& piece, FileContents& some) {
        if (!options_.faces) {
            for (const char* number : {"NumberOfPolys", "NumberOfStrips"})
                contents_.unread_polygons += piece.attribute(number).as_ullong();
            const pugi::xml_node array = piece.child("Cells").find_child_by_attribute("DataArray", "Name", "types");
            if (array) contents_.unread_polygons += polygonsAmong(numbers(array, {}, 1).integer);
            return;
        }
        const std::array<std::pair<const char*, CellKind>, 5> kinds{{{"Verts", CellKind::vertices},
                                                                     {"Lines", CellKind::lines},
                                                                     {"Strips", CellKind::strips},
                                                                     {"Polys", CellKind::polygons},
                                                                     {"Cells", CellKind::typed}}};
        std::vector<CellList> lists;
        std::vector<std::int64_t> types;
        for (const auto& [name, kind] : kinds) {
            CellList list{kind, {0}, {}};
            for (const pugi::xml_node& array : piece.child(name).children("DataArray")) {
                const std::string what = array.attribute("Name").value();
                std::vector<std::int64_t> values = numbers(array, {}, 1).integer;
                if (what == "connectivity") list.corner = std::move(values);
                if (what == "offsets") list.offset.insert(list.offset.end(), values.begin(), values.end());
                if (what == "types") types = std::move(values);
            }
            lists.push_back(std::move(list));
        }
        addCells(lists, types, options_, name_, some);
    }

    /// The cell array `component` of a file of polygons alone.
    void readComponents(const pugi::xml_node& piece, bool has_area) {
        const pugi::xml_node array = piece.child("CellData").find_child_by_attribute("DataArray", "Name", kComponent);
        if (!array || !has_area || !options_.faces) return;
        const std::vector<std::int64_t> values = numbers(array, {}, 1).integer;
        if (!contents_.component) contents_.component.emplace();
        for (const std::int64_t value : values) contents_.component->push_back(static_cast<std::int32_t>(value));
        if (contents_.component->size() != contents_.triangles.size()) contents_.component.reset();
    }

    std::string typeOf(const pugi::xml_node& array) const { return array.attribute("type").value(); }

    std::uint64_t componentsOf(const pugi::xml_node& array) const {
        if (!array.attribute("NumberOfComponents")) return 1;
        const std::uint64_t components = count(array, "NumberOfComponents");
        if (components == 0 || components > kMostComponents)
            fail("array '" + std::string(array.attribute("Name").value()) + "' has " + std::to_string(components) +
                 " components, expected 1 to " + std::to_string(kMostComponents));
        return components;
    }

    std::uint64_t count(const pugi::xml_node& node, const char* attribute) const {
        std::string_view text = node.attribute(attribute).value();
        const auto number = nextInteger(text);
        if (!number || *number < 0)
            fail(std::string(node.name()) + " has " + attribute + "=\"" + node.attribute(attribute).value() +
                 "\", expected a whole number");
        return static_cast<std::uint64_t>(*number);
    }

    /// rows: how many there have to be; none: as many as there are.
    NumberColumn numbers(const pugi::xml_node& array, std::optional<std::uint64_t> rows, std::uint64_t components) {
        const std::string name = array.attribute("Name").value(), format = array.attribute("format").value();
        const auto type = kTypes.find(typeOf(array));
        if (type == kTypes.end()) fail("array '" + name + "' has type '" + typeOf(array) + "', expected numbers");
        NumberColumn column;
        if (format == "ascii") {
            const std::string text = textOf(array);
            std::string_view rest = text;
            if (isReal(type->second))
                while (const auto number = nextReal(rest)) column.real.push_back(*number);
            else
                while (const auto number = nextInteger(rest)) column.integer.push_back(*number);
        } else {
            const Bytes bytes = format == "appended" ? appendedArray(array, name) : inlineArray(array, name);
            const std::size_t size = bytesOf(type->second);
            appendNumbers(type->second, bytes.data(), bytes.size() / size, other_order_, column);
        }
        if (rows && (column.size() % components != 0 || column.size() / components != *rows))
            fail("array '" + name + "' has " + std::to_string(column.size()) + " numbers, expected " +
                 std::to_string(components) + " for each of " + std::to_string(*rows) + " points");
        return column;
    }

    static std::string textOf(const pugi::xml_node& array) {
        std::string text;
        for (const pugi::xml_node& child : array.children())
            if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) text += child.value();
        return text;
    }

    Bytes inlineArray(const pugi::xml_node& array, const std::string& name) const {
        const std::string text = textOf(array);
        return fromBase64(text, name);
    }

    Bytes appendedArray(const pugi::xml_node& array, const std::string& name) const {
        const std::uint64_t offset = count(array, "offset");
        if (offset >= appended_.size())
            fail("array '" + name + "' begins at byte " + std::to_string(offset) +
                 " of the appended data, which have " + std::to_string(appended_.size()));
        const std::string_view text = appended_.substr(static_cast<std::size_t>(offset));
        if (appended_is_base64_) return fromBase64(text, name);
        const auto bytes = std::as_bytes(std::span(text));
        if (!compressed_) {
            const std::uint64_t size = headerNumber(bytes, 0, name);
            if (size > bytes.size() - header_bytes_) failShort(name);
            const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(header_bytes_);
            return {begin, begin + static_cast<std::ptrdiff_t>(size)};
        }
        const std::uint64_t blocks = headerNumber(bytes, 0, name);
        if (blocks > bytes.size() / header_bytes_) failShort(name);
        const std::size_t header = header_bytes_ * (3 + static_cast<std::size_t>(blocks));
        if (header > bytes.size()) failShort(name);
        return unpacked(bytes.first(header), bytes.subspan(header), name);
    }

    /// A header, and what it tells of; compressed, each is a stream of its own.
    Bytes fromBase64(std::string_view text, const std::string& name) const {
        constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
        if (!compressed_) {
            const Bytes bytes = base64(text, kAll);
            const std::uint64_t size = headerNumber(bytes, 0, name);
            if (size > bytes.size() - header_bytes_) failShort(name);
            const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(header_bytes_);
            return {begin, begin + static_cast<std::ptrdiff_t>(size)};
        }
        std::string_view ahead = text;
        const std::uint64_t blocks = headerNumber(base64(ahead, 3 * header_bytes_), 0, name);
        if (blocks > text.size()) failShort(name);
        const Bytes header = base64(text, kAll);  // up to its padding, or with the blocks where it has none
        const std::size_t size = header_bytes_ * (3 + static_cast<std::size_t>(blocks));
        if (header.size() < size) failShort(name);
        if (header.size() > size) return unpacked(std::span(header).first(size), std::span(header).subspan(size), name);
        return unpacked(header, base64(text, kAll), name);
    }

    /// header: number of blocks, bytes of each unpacked, of the last one where it is smaller, then of each packed.
    Bytes unpacked(std::span<const std::byte> header, std::span<const std::byte> packed,
                   const std::string& name) const {
        const std::uint64_t blocks = headerNumber(header, 0, name), whole = headerNumber(header, 1, name),
                            last = headerNumber(header, 2, name);
        Bytes bytes;
        for (std::uint64_t b = 0; b < blocks; ++b) {
            const std::uint64_t size = headerNumber(header, 3 + static_cast<std::size_t>(b), name);
            const std::uint64_t wanted = b + 1 == blocks && last != 0 ? last : whole;
            if (size > packed.size()) failShort(name);
            if (wanted > kMostPacked * (size + 1))
                fail("array '" + name + "': a block of " + std::to_string(size) + " bytes claims to unpack to " +
                     std::to_string(wanted));
            const std::size_t before = bytes.size();
            bytes.resize(before + static_cast<std::size_t>(wanted));
            if (!inflateBlock(packed.first(static_cast<std::size_t>(size)), std::span(bytes).subspan(before)))
                fail("array '" + name + "': a block cannot be decompressed by zlib");
            packed = packed.subspan(static_cast<std::size_t>(size));
        }
        return bytes;
    }

    std::uint64_t headerNumber(std::span<const std::byte> bytes, std::size_t i, const std::string& name) const {
        if (bytes.size() < (i + 1) * header_bytes_) failShort(name);
        const std::byte* from = bytes.data() + i * header_bytes_;
        return header_bytes_ == 8 ? loadNumber<std::uint64_t>(from, other_order_)
                                  : loadNumber<std::uint32_t>(from, other_order_);
    }

    [[noreturn]] void failShort(const std::string& name) const {
        fail("array '" + name + "' ends before the size it declares (truncated, or a damaged size)");
    }
    [[noreturn]] void fail(const std::string& text) const { throw Error(name_ + ": " + text); }

    Bytes file_;
    std::string name_;
    const ReadOptions& options_;
    pugi::xml_document document_;
    std::string_view appended_;
    bool appended_is_base64_ = false, compressed_ = false, other_order_ = false, declared_ = false;
    std::size_t header_bytes_ = 4;
    std::size_t pieces_ = 0;
    FileContents contents_;
};

}  // namespace

FileContents parseVtkXml(Cursor in, const ReadOptions& options) {
    Bytes bytes;
    while (in.remaining() > 0) {
        const std::string_view some = in.peek(1);
        if (some.empty()) break;
        const auto more = std::as_bytes(std::span(some));
        bytes.insert(bytes.end(), more.begin(), more.end());
        in.skip(some.size(), "bytes");
    }
    return XmlReader(std::move(bytes), in.file(), options).read();
}

}  // namespace betamesh
