// Legacy VTK files.

#include "base/lower_case.h"
#include "io/vtk.h"

#include "io/number_columns.h"
#include "io/vtk_cells.h"

#include <bit>
#include <cctype>
#include <map>
#include <sstream>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kLongestLine = 1 << 16;
constexpr std::size_t kLongestNumber = 64;  // characters

std::string upper(std::string word) {
    for (char& c : word) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return word;
}

/// Names hold %20 for a space, and so on.
std::string decoded(const std::string& name) {
    std::string text;
    for (std::size_t i = 0; i < name.size(); ++i) {
        if (name[i] == '%' && i + 2 < name.size() && std::isxdigit(static_cast<unsigned char>(name[i + 1])) &&
            std::isxdigit(static_cast<unsigned char>(name[i + 2]))) {
            text += static_cast<char>(std::stoi(name.substr(i + 1, 2), nullptr, 16));
            i += 2;
        } else {
            text += name[i];
        }
    }
    return text;
}

class LegacyReader {
public:
    LegacyReader(Cursor& in, const ReadOptions& options) : in_(in), options_(options) {}

    FileContents read() {
        readHeader();
        for (std::vector<std::string> words; nextLine(words);) {
            const std::string keyword = upper(words[0]);
            if (keyword == "METADATA")
                skipMetadata();
            else if (!readGeometry(keyword, words) && !readData(keyword, words))
                in_.fail("unknown keyword '" + words[0] + "' in a legacy VTK file");
        }
        if (!has_points_) in_.fail("the file ends without POINTS");
        addCells(cells_, cell_types_, options_, in_.file(), contents_);
        contents_.format = "vtk legacy " + version_ + (binary_ ? ", binary" : ", ascii");
        return deliverWhole(std::move(contents_), options_);
    }

private:
    void readHeader() {
        const std::string magic = "# vtk DataFile Version ";
        const std::string first = line();
        if (!first.starts_with(magic)) in_.fail("expected a legacy VTK file, which begins with '" + magic + "'");
        version_ = first.substr(magic.size());
        offsets_and_connectivity_ = std::atoi(version_.c_str()) >= 5;
        line();  // the title
        const std::string encoding = upper(line());
        if (encoding != "ASCII" && encoding != "BINARY")
            in_.fail("the third line is '" + encoding + "', expected ASCII or BINARY");
        binary_ = encoding == "BINARY";
        std::vector<std::string> words;
        if (!nextLine(words) || upper(words[0]) != "DATASET" || words.size() < 2) in_.fail("expected a line DATASET");
        const std::string kind = upper(words[1]);
        if (kind != "POLYDATA" && kind != "UNSTRUCTURED_GRID")
            in_.fail("the data set is of type " + kind + ", expected points: POLYDATA or UNSTRUCTURED_GRID");
    }

    bool readGeometry(const std::string& keyword, const std::vector<std::string>& words) {
        if (keyword == "POINTS") {
            if (std::exchange(has_points_, true)) in_.fail("POINTS appear twice");
            points_ = count(words, 1);
            const NumberType type = typeOf(words, 2);
            contents_.position = positionsFrom(numbers(type, points_, 3, "POINTS"), 3, options_.origin);
            contents_.has_double_positions = type == NumberType::float64;
            contents_.declared.push_back({"P", word(words, 2), 3, ""});
            return true;
        }
        if (keyword == "CELL_TYPES") {
            cell_types_ = numbers(NumberType::int32, count(words, 1), 1, "CELL_TYPES").integer;
            return true;
        }
        const std::map<std::string, CellKind> kinds{{"VERTICES", CellKind::vertices},
                                                    {"LINES", CellKind::lines},
                                                    {"POLYGONS", CellKind::polygons},
                                                    {"TRIANGLE_STRIPS", CellKind::strips},
                                                    {"CELLS", CellKind::typed}};
        const auto kind = kinds.find(keyword);
        if (kind == kinds.end()) return false;
        cells_.push_back(readCells(kind->second, words));
        return true;
    }

    CellList readCells(CellKind kind, const std::vector<std::string>& words) {
        CellList cells{kind, {}, {}};
        const std::uint64_t first = count(words, 1), second = count(words, 2);
        if (offsets_and_connectivity_) {
            std::vector<std::string> line;
            if (!nextLine(line) || upper(line[0]) != "OFFSETS") in_.fail("expected OFFSETS after " + words[0]);
            cells.offset = numbers(typeOf(line, 1), first, 1, "OFFSETS").integer;
            if (!nextLine(line) || upper(line[0]) != "CONNECTIVITY") in_.fail("expected CONNECTIVITY after OFFSETS");
            cells.corner = numbers(typeOf(line, 1), second, 1, "CONNECTIVITY").integer;
            return cells;
        }
        const std::vector<std::int64_t> sizes_and_corners =
            numbers(NumberType::int32, second, 1, words[0].c_str()).integer;
        cells.offset.push_back(0);
        for (std::size_t i = 0; i < sizes_and_corners.size();) {
            const std::int64_t size = sizes_and_corners[i++];
            if (size < 0 || static_cast<std::uint64_t>(size) > sizes_and_corners.size() - i)
                in_.fail("a cell of " + words[0] + " has " + std::to_string(size) + " corners, but " +
                         std::to_string(sizes_and_corners.size() - i) + " numbers follow");
            const auto begin = sizes_and_corners.begin() + static_cast<std::ptrdiff_t>(i);
            cells.corner.insert(cells.corner.end(), begin, begin + size);
            cells.offset.push_back(static_cast<std::int64_t>(cells.corner.size()));
            i += static_cast<std::size_t>(size);
        }
        return cells;
    }

    bool readData(const std::string& keyword, const std::vector<std::string>& words) {
        if (keyword == "POINT_DATA" || keyword == "CELL_DATA") {
            of_points_ = keyword == "POINT_DATA";
            rows_ = count(words, 1);
            if (of_points_ && rows_ != points_)
                in_.fail("POINT_DATA are of " + std::to_string(rows_) + " points, expected " + std::to_string(points_));
        } else if (keyword == "SCALARS") {
            const NumberType type = typeOf(words, 2);
            const std::uint64_t components = words.size() > 3 ? count(words, 3) : 1;
            if (upper(peekWord()) == "LOOKUP_TABLE") line();
            array(words, type, components);
        } else if (keyword == "LOOKUP_TABLE") {
            numbers(binary_ ? NumberType::uint8 : NumberType::float32, count(words, 2), 4, "LOOKUP_TABLE");
        } else if (keyword == "COLOR_SCALARS") {
            array(words, binary_ ? NumberType::uint8 : NumberType::float32, count(words, 2));
        } else if (keyword == "VECTORS" || keyword == "NORMALS") {
            array(words, typeOf(words, 2), 3);
        } else if (keyword == "TENSORS") {
            array(words, typeOf(words, 2), 9);
        } else if (keyword == "TENSORS6") {
            array(words, typeOf(words, 2), 6);
        } else if (keyword == "TEXTURE_COORDINATES") {
            array(words, typeOf(words, 3), count(words, 2));
        } else if (keyword == "GLOBAL_IDS" || keyword == "PEDIGREE_IDS") {
            array(words, typeOf(words, 2), 1);
        } else if (keyword == "FIELD") {
            readField(count(words, 2));
        } else {
            return false;
        }
        return true;
    }

    void readField(std::uint64_t arrays) {
        for (; arrays > 0; --arrays) {
            std::vector<std::string> words;
            if (!nextLine(words)) in_.fail("the file ends within a FIELD");
            if (upper(words[0]) == "METADATA") {
                skipMetadata();
                ++arrays;
                continue;
            }
            const std::uint64_t components = count(words, 1), tuples = count(words, 2);
            if (components > kMostComponents)
                in_.fail("array '" + words[0] + "' has " + std::to_string(components) +
                         " components, expected at most " + std::to_string(kMostComponents));
            NumberColumn column = numbers(typeOf(words, 3), tuples, components, words[0].c_str());
            if (of_points_ && tuples == points_) use(words[0], word(words, 3), components, std::move(column));
        }
    }

    /// Data of every row of the current POINT_DATA or CELL_DATA.
    void array(const std::vector<std::string>& words, NumberType type, std::uint64_t components) {
        if (components == 0 || components > kMostComponents)
            in_.fail("array '" + word(words, 1) + "' has " + std::to_string(components) +
                     " components, expected 1 to " + std::to_string(kMostComponents));
        NumberColumn column = numbers(type, rows_, components, words[1].c_str());
        if (of_points_) use(words[1], words.size() > 2 ? words[2] : "", components, std::move(column));
    }

    void use(const std::string& name, const std::string& type, std::uint64_t components, NumberColumn&& column) {
        const std::string clean = attributeName(decoded(name));
        contents_.declared.push_back({clean, type, static_cast<std::uint32_t>(components), ""});
        addColumn(clean, components, std::move(column), contents_.position.size(), options_, in_.file(), contents_);
    }

    NumberColumn numbers(NumberType type, std::uint64_t rows, std::uint64_t components, const char* what) {
        NumberColumn column;
        if (binary_) {
            in_.requireRows(rows, components * bytesOf(type), what);
            const std::size_t all = static_cast<std::size_t>(rows * components);
            appendNumbers(type, in_.take(all * bytesOf(type), what), all, std::endian::native == std::endian::little,
                          column);
            return column;
        }
        in_.requireRows(rows, components, what);  // at least a character each
        for (std::uint64_t i = 0; i < rows * components; ++i) {
            skipSpace();
            std::string_view text = in_.peek(kLongestNumber);
            const std::size_t before = text.size();
            const bool is_real = isReal(type);
            const auto real = is_real ? nextReal(text) : std::nullopt;
            const auto integer = is_real ? std::nullopt : nextInteger(text);
            if (!real && !integer)
                in_.fail(std::string(what) + " has " + std::to_string(i) + " numbers, expected " +
                         std::to_string(rows * components));
            if (real) column.real.push_back(*real);
            if (integer) column.integer.push_back(*integer);
            in_.skip(before - text.size(), what);
        }
        return column;
    }

    NumberType typeOf(const std::vector<std::string>& words, std::size_t at) {
        static const std::map<std::string, NumberType> types{{"char", NumberType::int8},
                                                             {"signed_char", NumberType::int8},
                                                             {"unsigned_char", NumberType::uint8},
                                                             {"short", NumberType::int16},
                                                             {"unsigned_short", NumberType::uint16},
                                                             {"int", NumberType::int32},
                                                             {"unsigned_int", NumberType::uint32},
                                                             {"long", NumberType::int64},
                                                             {"unsigned_long", NumberType::uint64},
                                                             {"long_long", NumberType::int64},
                                                             {"unsigned_long_long", NumberType::uint64},
                                                             {"vtktypeint64", NumberType::int64},
                                                             {"vtktypeuint64", NumberType::uint64},
                                                             {"vtkidtype", NumberType::int32},
                                                             {"float", NumberType::float32},
                                                             {"double", NumberType::float64}};
        const std::string name = lowerCase(word(words, at));
        const auto found = types.find(name);
        if (found == types.end())
            in_.fail("numbers of type '" + name + "' cannot be read; expected float, double, int …");
        return found->second;
    }

    std::string word(const std::vector<std::string>& words, std::size_t at) {
        if (at >= words.size())
            in_.fail("the line " + words[0] + " has " + std::to_string(words.size()) + " words, expected at least " +
                     std::to_string(at + 1));
        return words[at];
    }

    std::uint64_t count(const std::vector<std::string>& words, std::size_t at) {
        const std::string text = word(words, at);
        std::string_view rest = text;
        const auto number = nextInteger(rest);
        if (!number || *number < 0 || !rest.empty())
            in_.fail("'" + text + "' in the line " + words[0] + " is no count, expected a whole number");
        return static_cast<std::uint64_t>(*number);
    }

    void skipSpace() {
        for (;;) {
            const std::string_view text = in_.peek(1);
            const std::size_t space = std::min(text.find_first_not_of(" \t\r\n"), text.size());
            in_.skip(space, "white space");
            if (space < text.size() || text.empty()) return;
        }
    }

    std::string peekWord() {
        skipSpace();
        const std::string_view text = in_.peek(kLongestNumber);
        return std::string(text.substr(0, text.find_first_of(" \t\r\n")));
    }

    /// The rest of the line, without its end.
    std::string line() {
        std::string_view text = in_.peek(256);
        std::size_t end = text.find('\n');
        if (end == std::string_view::npos) {
            text = in_.peek(kLongestLine);
            end = text.find('\n');
        }
        if (end == std::string_view::npos && text.size() >= kLongestLine)
            in_.fail("a line is longer than 65,536 bytes");
        std::string whole(text.substr(0, end));
        in_.skip(std::min(whole.size() + 1, text.size()), "a line");
        while (!whole.empty() && std::isspace(static_cast<unsigned char>(whole.back()))) whole.pop_back();
        return whole;
    }

    /// The words of the next line that is not empty; false at the end.
    bool nextLine(std::vector<std::string>& words) {
        skipSpace();
        words.clear();
        if (in_.peek(1).empty()) return false;
        std::istringstream text(line());
        for (std::string word; text >> word;) words.push_back(word);
        return !words.empty();
    }

    void skipMetadata() {
        while (!in_.peek(1).empty() && !line().empty()) {
        }
    }

    Cursor& in_;
    const ReadOptions& options_;
    FileContents contents_;
    std::vector<CellList> cells_;
    std::vector<std::int64_t> cell_types_;
    std::string version_;
    bool binary_ = false, offsets_and_connectivity_ = false, has_points_ = false, of_points_ = false;
    std::uint64_t points_ = 0, rows_ = 0;
};

}  // namespace

FileContents parseVtk(Cursor in, const ReadOptions& options) { return LegacyReader(in, options).read(); }

}  // namespace betamesh
