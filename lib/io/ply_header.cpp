
#include "io/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxProperties = 4096;

/// The first ten in the order of PlyNumber.
constexpr std::array<std::pair<std::string_view, PlyNumber>, 18> kNumberNames{{
    {"char", PlyNumber::int8},
    {"uchar", PlyNumber::uint8},
    {"short", PlyNumber::int16},
    {"ushort", PlyNumber::uint16},
    {"int", PlyNumber::int32},
    {"uint", PlyNumber::uint32},
    {"int64", PlyNumber::int64},
    {"uint64", PlyNumber::uint64},
    {"float", PlyNumber::float32},
    {"double", PlyNumber::float64},
    {"int8", PlyNumber::int8},
    {"uint8", PlyNumber::uint8},
    {"int16", PlyNumber::int16},
    {"uint16", PlyNumber::uint16},
    {"int32", PlyNumber::int32},
    {"uint32", PlyNumber::uint32},
    {"float32", PlyNumber::float32},
    {"float64", PlyNumber::float64},
}};

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

class HeaderReader {
public:
    explicit HeaderReader(Cursor& in) : in_(in) {}

    PlyHeader read() {
        if (nextLine() != "ply") in_.fail("not a PLY file: the first line must be 'ply'");
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
                fail(inQuotes(line) +
                     " is not a header line. Known are format, comment, element, property and end_header.");
            }
        }
        if (!has_format) fail("the header has no format line");
        header_.lines = line_;
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
            fail("the header does not end (end_header) within 1 MiB");
        std::string_view line = rest.substr(0, length);
        in_.take(length + 1, "header");
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }

    void readFormat(const std::vector<std::string_view>& words) {
        const std::string_view name = words.size() > 1 ? words[1] : "";
        if (name == "ascii")
            header_.encoding = PlyEncoding::ascii;
        else if (name == "binary_little_endian")
            header_.encoding = PlyEncoding::little;
        else if (name == "binary_big_endian")
            header_.encoding = PlyEncoding::big;
        else
            fail("format " + inQuotes(name) +
                 " is unknown. Known are ascii, binary_little_endian and binary_big_endian.");
    }

    void readElement(const std::vector<std::string_view>& words) {
        PlyElement element;
        if (words.size() != 3) fail("an element needs a name and a count");
        element.name = words[1];
        const char* end = words[2].data() + words[2].size();
        const auto [stop, error] = std::from_chars(words[2].data(), end, element.rows);
        if (error != std::errc() || stop != end)
            fail("the count " + inQuotes(words[2]) + " is not a non-negative integer");
        for (const PlyElement& other : header_.elements)
            if (other.name == element.name) fail("element " + inQuotes(element.name) + " is declared twice");
        if (header_.elements.size() == kMaxProperties)
            fail("more than " + std::to_string(kMaxProperties) + " elements");
        header_.elements.push_back(std::move(element));
    }

    PlyNumber numberType(std::string_view name) const {
        for (const auto& [word, type] : kNumberNames)
            if (word == name) return type;
        fail("type " + inQuotes(name) +
             " is unknown. Known are char, uchar, short, ushort, int, uint, int64, uint64, float and double.");
    }

    void readProperty(const std::vector<std::string_view>& words) {
        if (header_.elements.empty()) fail("this property is not preceded by an element");
        PlyElement& element = header_.elements.back();
        PlyProperty property;
        property.is_list = words.size() == 5 && words[1] == "list";
        if (!property.is_list && words.size() != 3) fail("a property needs a type and a name");
        if (property.is_list) {
            property.count_type = numberType(words[2]);
            if (isReal(property.count_type))
                fail("the length of a list must be an integer, not " + nameOf(property.count_type));
        }
        property.type = numberType(words[words.size() - 2]);
        property.name = words.back();
        for (const PlyProperty& other : element.properties)
            if (other.name == property.name) fail("property " + inQuotes(property.name) + " is declared twice");
        if (++properties_ > kMaxProperties) fail("more than " + std::to_string(kMaxProperties) + " properties");
        element.properties.push_back(std::move(property));
    }

    Cursor& in_;
    PlyHeader header_;
    std::size_t line_ = 0;
    std::size_t properties_ = 0;
};

}  // namespace

PlyHeader readPlyHeader(Cursor& in) { return HeaderReader(in).read(); }

std::string nameOf(PlyNumber type) { return std::string(kNumberNames[static_cast<std::size_t>(type)].first); }

std::string inQuotes(std::string_view text) {
    std::string shown = "'";
    for (const char c : text.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
    return shown + (text.size() > 60 ? "…'" : "'");
}

}  // namespace betamesh
