#include "io/table.h"

#include "base/lower_case.h"
#include "io/number_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kLongestRow = std::size_t{1} << 20;

/// The lines of a file one by one, without their ends.
class Lines {
public:
    explicit Lines(Cursor& in) : in_(in) {}

    std::optional<std::string> next() {
        std::string_view text = in_.peek(512);
        std::size_t end = text.find('\n');
        if (end == std::string_view::npos) {
            text = in_.peek(kLongestRow);
            end = text.find('\n');
            if (end == std::string_view::npos && text.size() >= kLongestRow)
                throw Error(in_.file() + ": line " + std::to_string(number_ + 1) + " is longer than a mebibyte");
        }
        if (text.empty()) return std::nullopt;
        ++number_;
        std::string line(text.substr(0, end));
        in_.skip(std::min(line.size() + 1, text.size()), "a line");
        if (line.ends_with('\r')) line.pop_back();
        if (number_ == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // a byte order mark
        return line;
    }
    std::size_t number() const { return number_; }
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(in_.file() + ": line " + std::to_string(number_) + ": " + text);
    }

private:
    Cursor& in_;
    std::size_t number_ = 0;
};

bool isBlank(char c) { return c == ' ' || c == '\t'; }

/// What separates the cells of a line: a comma or semicolon outside of quotes, else white space.
char separatorOf(const std::string& line) {
    bool quoted = false, has_semicolon = false;
    for (const char c : line) {
        if (c == '"') quoted = !quoted;
        if (c == ',' && !quoted) return ',';
        has_semicolon = has_semicolon || (c == ';' && !quoted);
    }
    return has_semicolon ? ';' : ' ';
}

struct Cells {
    std::vector<std::string> text;
    std::vector<bool> is_quoted;
};

/// The cells of a line. Quotes are those of RFC 4180: they enclose a whole cell, and a quote in it is doubled; any
/// other quote is a character of its cell. nullopt: a quote is not closed.
std::optional<Cells> cellsOf(const std::string& line) {
    const char separator = separatorOf(line);
    const auto isEnd = [&](char c) { return c == separator || (separator == ' ' && c == '\t'); };
    Cells cells;
    for (std::size_t at = 0; at <= line.size(); ++at) {
        while (at < line.size() && isBlank(line[at])) ++at;
        std::string cell;
        const bool is_quoted = at < line.size() && line[at] == '"';
        if (is_quoted) {
            for (++at;; ++at) {
                if (at >= line.size()) return std::nullopt;
                if (line[at] == '"' && (at + 1 >= line.size() || line[at + 1] != '"')) break;
                if (line[at] == '"') ++at;
                cell += line[at];
            }
            ++at;
            while (at < line.size() && !isEnd(line[at])) ++at;  // nothing may follow but blanks
        } else {
            while (at < line.size() && !isEnd(line[at])) cell += line[at++];
            while (!cell.empty() && isBlank(cell.back())) cell.pop_back();
        }
        if (separator == ' ' && cell.empty()) continue;
        cells.text.push_back(std::move(cell));
        cells.is_quoted.push_back(is_quoted);
    }
    return cells;
}

/// The cells of a line and of the lines that follow it inside quotes.
Cells nextCells(Lines& lines, std::string line) {
    for (;;) {
        if (auto cells = cellsOf(line)) return std::move(*cells);
        const auto more = lines.next();
        if (!more || line.size() + more->size() > kLongestRow) lines.fail("a quote is not closed");
        line += '\n' + *more;
    }
}

std::optional<double> numberOf(const std::string& cell) {
    std::string_view text = cell;
    const auto number = nextReal(text);
    return text.empty() ? number : std::nullopt;
}

/// An integer; none if the cell is not written as one, as in "1.0", or has more than 64 bits.
std::optional<std::int64_t> integerOf(const std::string& cell) {
    std::string_view text = cell;
    const auto number = nextInteger(text);
    return text.empty() ? number : std::nullopt;
}

/// A name as attributes have it: without white space, and not empty.
std::string attributeName(std::string name) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ') c = '_';
    return name.empty() ? "unnamed" : name;
}

bool needsQuotes(const std::string& name) { return name.find_first_of(",; \t\n\"") != std::string::npos; }

std::string shortened(const std::string& cell) { return cell.size() > 40 ? cell.substr(0, 40) + "…" : cell; }

bool isWrittenAsInteger(const std::string& cell) { return cell.find_first_not_of("+-0123456789") == std::string::npos; }

/// Whether an integer is the same in single precision.
bool isFloat(const std::string& integer, double number) {
    if (std::abs(number) <= 0x1p24) return true;
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "%.0f", static_cast<double>(static_cast<float>(std::abs(number))));
    return integer.substr(std::min(integer.find_first_not_of("+-0"), integer.size())) == text.data();
}

/// The numbers of one column.
struct Column {
    std::string name{};
    bool is_whole = false;
    std::vector<double> real{};           ///< empty if the numbers are whole
    std::vector<std::int64_t> integer{};  ///< empty if they are not
    std::string fault{};                  ///< the first cell that is no such number, with its line
    bool has_fractions = false;           ///< a real number is not written as an integer
    std::string inexact{};                ///< the first integer among real numbers that is no float, with its line

    void add(const std::string& cell, std::size_t line) {
        const auto note = [&](std::string& first, const std::string& text, const std::string& what) {
            if (first.empty())
                first = "line " + std::to_string(line) + ": " + text + " in column '" + name + "' " + what;
        };
        const auto number = numberOf(cell);
        if (!number) note(fault, '\'' + cell + '\'', "is no number");
        if (!is_whole) {
            real.push_back(number.value_or(0));
            has_fractions |= !isWrittenAsInteger(cell);
            if (!has_fractions && inexact.empty() && !isFloat(cell, real.back()))
                note(inexact, shortened(cell), "needs more than 24 bits");
            return;
        }
        constexpr double kExact = 0x1p53;  // doubles below tell all whole numbers apart
        auto exact = integerOf(cell);
        if (!exact && number && !isWrittenAsInteger(cell) && std::abs(*number) < kExact &&
            *number == std::trunc(*number))
            exact = static_cast<std::int64_t>(*number);  // 7.0
        if (!exact && number && isWrittenAsInteger(cell))
            note(fault, shortened(cell), "is out of range, expected -2^63 to 2^63 - 1");
        else if (!exact && number)
            note(fault, shortened(cell), "is not an exact whole number");
        integer.push_back(exact.value_or(0));
    }
    std::size_t rows() const { return is_whole ? integer.size() : real.size(); }
    double number(std::size_t row) const { return is_whole ? static_cast<double>(integer[row]) : real[row]; }
};

/// A column's name as that of a vector and a component, where it is one: "v.x", "Points:0", "vel_y", "a[2]", "vx".
std::optional<std::pair<std::string, std::size_t>> componentOf(const std::string& name) {
    if (name.size() < 2) return std::nullopt;
    const auto index = [](char c) -> std::optional<std::size_t> {
        for (const std::string_view letters : {"xyzw", "0123"})
            if (const std::size_t at = letters.find(lowerCase(c)); at != std::string_view::npos) return at;
        return std::nullopt;
    };
    if (const std::size_t bracket = name.find('['); bracket != std::string::npos && name.back() == ']' && bracket > 0) {
        std::size_t i = 0;
        const char *begin = name.data() + bracket + 1, *end = name.data() + name.size() - 1;
        const auto [stop, error] = std::from_chars(begin, end, i);
        if (error == std::errc() && stop == end) return std::pair(name.substr(0, bracket), i);
        return std::nullopt;
    }
    const char before = name[name.size() - 2];
    const auto i = index(name.back());
    if (!i) return std::nullopt;
    if (name.size() > 2 && (before == '.' || before == '_' || before == ':' || before == ' '))
        return std::pair(name.substr(0, name.size() - 2), *i);
    if (name.size() == 2 && std::isalpha(static_cast<unsigned char>(name.back())))
        return std::pair(name.substr(0, 1), *i);
    return std::nullopt;
}

/// What some columns are together.
struct Meaning {
    std::string name;
    std::vector<std::size_t> columns;
};

bool isPosition(const std::string& vector) {
    const std::string name = lowerCase(vector);
    return name == "p" || name == "position" || name == "points" || name == "pos";
}

bool isVelocity(const std::string& vector) {
    const std::string name = lowerCase(vector);
    return name == "v" || name.starts_with("vel");
}

/// Which columns hold whole numbers: ids, groups, and those whose names are in quotes although others are not. The
/// numbers do not count, so that all frames of a sequence agree.
std::vector<bool> wholeColumns(const std::vector<std::string>& names, const std::vector<bool>& is_quoted,
                               const std::string& id) {
    const bool quotes_tell = std::ranges::find(is_quoted, false) != is_quoted.end();
    std::vector<bool> whole;
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string lower = lowerCase(names[c]);
        const auto part = componentOf(names[c]);
        const bool is_vector = lower == "x" || lower == "y" || lower == "z" ||
                               (part && (isPosition(part->first) || isVelocity(part->first)));
        const bool is_marked = quotes_tell && is_quoted[c] && !needsQuotes(names[c]);
        const bool is_id = lower == "id" || (!id.empty() && attributeName(names[c]) == id);
        whole.push_back(is_id || names[c].starts_with(kGroupPrefix) || (is_marked && !is_vector));
    }
    return whole;
}

/// The columns of the position, then all others. Of columns with the same name the first counts.
///
/// in      where: the file and the line of the names, for messages
std::vector<Meaning> meaningsOf(const std::vector<std::string>& names, const std::string& where,
                                std::vector<std::string>& warnings) {
    Meaning position{"P", {}};
    std::vector<Meaning> others;
    std::set<std::string> known;
    std::map<std::string, std::size_t> at;  // of vectors, among the others
    std::array<std::optional<std::size_t>, 3> xyz;
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string single = lowerCase(names[c]);
        const auto part = componentOf(names[c]);
        std::optional<std::size_t> axis;
        if (single == "x" || single == "y" || single == "z")
            axis = static_cast<std::size_t>(single[0] - 'x');
        else if (part && isPosition(part->first) && part->second < 3)
            axis = part->second;
        if (!known.insert(names[c]).second || (axis && xyz[*axis])) {
            warnings.push_back("column " + std::to_string(c + 1) + " ('" + names[c] +
                               "') is left out, because an earlier column has the same name or is the same coordinate");
        } else if (axis) {
            xyz[*axis] = c;
        } else if (part) {
            const auto [found, is_new] = at.emplace(part->first, others.size());
            if (is_new) others.push_back({part->first, {}});
            Meaning& vector = others[found->second];
            if (vector.columns.size() == part->second)
                vector.columns.push_back(c);
            else
                others.push_back({names[c], {c}});
        } else {
            others.push_back({names[c], {c}});
        }
    }
    if (!xyz[0] || !xyz[1] || !xyz[2]) {
        std::string all;
        for (const std::string& name : names) all += (all.empty() ? "'" : ", '") + name + "'";
        throw Error(where + "no columns x, y and z; found " + all);
    }
    for (const auto& column : xyz) position.columns.push_back(*column);
    std::vector<Meaning> meanings{position};
    for (Meaning& other : others) {
        if (other.columns.empty()) continue;  // a vector whose components come in another order
        if (other.columns.size() == 1) other.name = names[other.columns[0]];  // such as a lone "v.x"
        meanings.push_back(std::move(other));
    }
    return meanings;
}

/// The numbers of some columns, row after row: whole only if all of them are.
NumberColumn numbersOf(const std::vector<Column>& columns, const std::vector<std::size_t>& which, bool whole) {
    NumberColumn together;
    for (std::size_t i = 0; i < columns[which[0]].rows(); ++i)
        for (const std::size_t c : which)
            if (whole)
                together.integer.push_back(columns[c].integer[i]);
            else
                together.real.push_back(columns[c].number(i));
    return together;
}

/// The first integer that becomes another float, with its line and column, if all cells of some columns are written as
/// integers; else empty.
std::string inexactIntegers(const std::vector<Column>& columns, const std::vector<std::size_t>& which) {
    if (std::ranges::any_of(which, [&](std::size_t c) { return columns[c].has_fractions; })) return {};
    for (const std::size_t c : which)
        if (!columns[c].inexact.empty()) return columns[c].inexact;
    return {};
}

/// The rows of a table as they are read line by line, and what stands before them.
struct Table {
    std::vector<std::string> names;
    std::vector<bool> is_quoted;  // of each name
    std::vector<Column> columns;
    bool has_names = false, has_element = false;  // has_element: the first cell of each row is no number
    std::optional<std::int64_t> atoms;            // as .xyz of chemistry says at its beginning
    std::size_t line_of_names = 0;                // or of the first row
    std::vector<std::size_t> line_of;             // of each row

    void makeColumns(const std::string& id) {
        is_quoted.resize(names.size());
        const std::vector<bool> whole = wholeColumns(names, is_quoted, id);
        for (std::size_t c = 0; c < names.size(); ++c) columns.push_back({.name = names[c], .is_whole = whole[c]});
    }

    /// Returns whether these cells, which no row precedes, are the first row; otherwise takes what they say.
    /// line_number: of the line in which they begin
    bool isFirstRow(Cells& line, std::size_t line_number, Lines& lines) {
        auto& [cells, quotes] = line;
        const bool numeric = numberOf(cells[0]).has_value();
        const auto count = cells.size() == 1 && !has_names ? integerOf(cells[0]) : std::nullopt;
        if (count && *count >= 0) {  // .xyz of chemistry: a count, then a comment
            atoms = count;
            lines.next();
            return false;
        }
        has_element = atoms && !numeric;
        if (!has_names) line_of_names = line_number;
        if (!numeric && !has_element && !has_names) {
            has_names = true;
            names = std::move(cells);
            is_quoted = std::move(quotes);
            return false;
        }
        return true;
    }

    /// width: number of columns
    void nameColumns(std::size_t width) {
        for (std::size_t c = 0; c < width; ++c)
            names.push_back(c < 3 ? std::string(1, static_cast<char>('x' + c)) : "column" + std::to_string(c + 1));
    }

    void addRow(std::vector<std::string> cells, const Lines& lines) {
        if (has_element) cells.erase(cells.begin());
        while (cells.size() > names.size() && cells.back().empty()) cells.pop_back();
        if (cells.size() != names.size())
            lines.fail("has " + std::to_string(cells.size()) + " columns, expected " + std::to_string(names.size()) +
                       " as in line " + std::to_string(line_of_names));
        for (std::size_t c = 0; c < names.size(); ++c) columns[c].add(cells[c], lines.number());
        line_of.push_back(lines.number());
    }
};

/// id: name of the attribute that identifies particles
Table readTable(Cursor& in, const std::string& id) {
    Lines lines(in);
    Table table;
    while (auto line = lines.next()) {
        const std::size_t first = line->find_first_not_of(" \t,;");
        if (first == std::string::npos || line->at(first) == '#') continue;
        const std::size_t line_number = lines.number();
        Cells cells = nextCells(lines, std::move(*line));
        if (cells.text.empty()) continue;
        if (table.columns.empty()) {
            if (!table.isFirstRow(cells, line_number, lines)) continue;
            if (!table.has_names) table.nameColumns(cells.text.size() - table.has_element);
            table.makeColumns(id);
        }
        table.addRow(std::move(cells.text), lines);
    }
    if (lines.number() == 0) throw Error(in.file() + ": 0 bytes, expected the names of columns or rows of numbers");
    if (table.atoms && static_cast<std::int64_t>(table.line_of.size()) < *table.atoms)
        throw Error(in.file() + ": has " + std::to_string(table.line_of.size()) + " rows of atoms, expected " +
                    std::to_string(*table.atoms) + ", as it says at its beginning");
    if (table.names.empty()) table.names = {"x", "y", "z"};
    if (table.columns.empty()) table.makeColumns(id);
    return table;
}

/// Adds the columns of a table to the contents of its file, one meaning after the other.
class TableContents {
public:
    TableContents(const Table& table, const ReadOptions& options, const std::string& file, FileContents& contents)
        : table_(table), options_(options), file_(file), contents_(contents) {}

    void add(const Meaning& meaning) {
        if (isLeftOutForFault(meaning)) return;
        const std::string name = attributeName(meaning.name);
        if (!known_.insert(name).second) {
            contents_.warnings.push_back("column '" + meaning.name +
                                         "' is left out, because an earlier one is called '" + name + "' as well");
            return;
        }
        if (name != meaning.name) renamed_ += (renamed_.empty() ? "'" : ", '") + meaning.name + "' to '" + name + "'";
        const auto width = static_cast<std::uint32_t>(meaning.columns.size());
        const bool whole = isWhole(meaning, name);
        contents_.declared.push_back({name, whole ? "int64" : "number", width, ""});
        NumberColumn numbers = numbersOf(table_.columns, meaning.columns, whole);
        if (meaning.name == "P")
            addPositions(meaning, numbers);
        else
            addColumn(name, width, std::move(numbers), table_.line_of.size(), options_, file_, contents_);
    }
    /// "'a b' to 'a_b', ..."
    const std::string& renamed() const { return renamed_; }

private:
    /// Throws if what cannot be read is needed, otherwise warns.
    bool isLeftOutForFault(const Meaning& meaning) {
        const auto faulty =
            std::ranges::find_if(meaning.columns, [&](auto c) { return !table_.columns[c].fault.empty(); });
        if (faulty == meaning.columns.end()) return false;
        const std::string& fault = table_.columns[*faulty].fault;
        if (meaning.name == "P" || isVelocity(meaning.name) || attributeName(meaning.name) == options_.id ||
            (options_.needs && options_.needs(meaning.name)))
            throw Error(file_ + ": " + fault);
        contents_.warnings.push_back("attribute '" + meaning.name + "' is left out: " + fault);
        return true;
    }
    /// Are the numbers integers? Warns of integers that become floats.
    bool isWhole(const Meaning& meaning, const std::string& name) {
        if (meaning.name == "P" || (isVelocity(name) && meaning.columns.size() > 1)) return false;
        if (std::ranges::all_of(meaning.columns, [&](std::size_t c) { return table_.columns[c].is_whole; }))
            return true;
        if (const std::string inexact = inexactIntegers(table_.columns, meaning.columns); !inexact.empty())
            contents_.warnings.push_back("attribute '" + name + "' becomes floats of single precision: " + inexact +
                                         ". Names in quotes, as in x,y,z,\"key\", mark columns of whole numbers");
        return false;
    }
    void addPositions(const Meaning& meaning, const NumberColumn& numbers) {
        for (const std::size_t c : meaning.columns)
            if (auto lost = firstTooLarge(table_.names[c], 1, {table_.columns[c].real, {}}))
                contents_.lost_numbers.push_back(std::move(*lost));
        contents_.position = positionsFrom(numbers, 3, options_.origin);
    }

    const Table& table_;
    const ReadOptions& options_;
    const std::string& file_;
    FileContents& contents_;
    std::set<std::string> known_;
    std::string renamed_;
};

}  // namespace

FileContents parseTable(Cursor in, const ReadOptions& options) {
    const Table table = readTable(in, options.id);
    FileContents contents;
    contents.format = table.has_names ? "table with named columns" : "table without names";
    contents.has_double_positions = true;
    const std::string file = in.file();
    const std::string where = file + ": line " + std::to_string(table.line_of_names) + ": ";
    TableContents adder(table, options, file, contents);
    for (const Meaning& meaning : meaningsOf(table.names, where, contents.warnings)) adder.add(meaning);
    if (!adder.renamed().empty())
        contents.warnings.push_back("columns without a name, or with white space in it, are renamed: " +
                                    adder.renamed());
    for (LostNumber& lost : contents.lost_numbers) lost.line = table.line_of[static_cast<std::size_t>(lost.particle)];
    return deliverWhole(std::move(contents), options);
}

}  // namespace betamesh
