#include "io/table.h"

#include "base/lower_case.h"
#include "io/number_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <type_traits>
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

/// The cells of a line. Quotes are those of RFC 4180: they enclose a whole cell, and a quote in it is doubled; any
/// other quote is a character of its cell. nullopt: a quote is not closed.
std::optional<std::vector<std::string>> cellsOf(const std::string& line) {
    const char separator = separatorOf(line);
    const auto isEnd = [&](char c) { return c == separator || (separator == ' ' && c == '\t'); };
    std::vector<std::string> cells;
    for (std::size_t at = 0; at <= line.size(); ++at) {
        while (at < line.size() && isBlank(line[at])) ++at;
        std::string cell;
        if (at < line.size() && line[at] == '"') {
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
        cells.push_back(std::move(cell));
    }
    return cells;
}

/// The cells of a line and of the lines that follow it inside quotes.
std::vector<std::string> nextCells(Lines& lines, std::string line) {
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

/// The numbers of one column. integer: the same, as long as all of them are written as integers.
struct Column {
    std::vector<double> real;
    std::vector<std::int64_t> integer;
    bool whole = true;
    std::string fault;   ///< the first cell that is no number, with its line
    std::string beyond;  ///< the first integer of more than 64 bits, with its line, if all are written as integers

    void add(double number, const std::string& cell, std::size_t line) {
        real.push_back(number);
        if (isReal()) return;
        const auto exact = integerOf(cell);
        if (whole && exact) integer.push_back(*exact);
        if (exact) return;
        whole = false;
        integer = {};
        if (cell.find_first_not_of("+-0123456789") != std::string::npos)
            beyond.clear();
        else if (beyond.empty())
            beyond = "line " + std::to_string(line) + ": " + (cell.size() > 40 ? cell.substr(0, 40) + "…" : cell);
    }
    /// Whether a cell is not written as an integer.
    bool isReal() const { return !whole && beyond.empty(); }
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

/// The columns of the position, then all others. Of columns with the same name the first counts.
std::vector<Meaning> meaningsOf(const std::vector<std::string>& names, const Lines& lines,
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
        lines.fail("no columns x, y and z; found " + all);
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

/// The numbers of some columns, row after row.
NumberColumn numbersOf(const std::vector<Column>& columns, const std::vector<std::size_t>& which) {
    NumberColumn together;
    const std::size_t rows = columns[which[0]].real.size();
    const bool whole = std::all_of(which.begin(), which.end(), [&](std::size_t c) { return columns[c].whole; });
    for (std::size_t i = 0; i < rows; ++i)
        for (const std::size_t c : which)
            if (whole)
                together.integer.push_back(columns[c].integer[i]);
            else
                together.real.push_back(columns[c].real[i]);
    return together;
}

/// The first cell of more than 64 bits, with its line and column, if all cells of some columns are written as integers;
/// else empty.
std::string beyondIntegers(const std::vector<Column>& columns, const std::vector<std::size_t>& which,
                           const std::vector<std::string>& names) {
    if (std::ranges::any_of(which, [&](std::size_t c) { return columns[c].isReal(); })) return {};
    for (const std::size_t c : which)
        if (!columns[c].whole) return columns[c].beyond + " in column '" + names[c] + "'";
    return {};
}

// Writing.

constexpr std::array kReserved{"x", "y", "z", "P", "vx", "vy", "vz", "v", "id"};

/// The names of the columns of an attribute: "a", "a.x" … "a.w" or "a[0]" ….
std::string columnName(const Attribute& a, std::uint32_t component) {
    std::string name = a.name;
    if (a.components > 4)
        name += '[' + std::to_string(component) + ']';
    else if (a.components > 1)
        name += std::string(".") + "xyzw"[component];
    if (name.find_first_of(",;\"") == std::string::npos) return name;
    std::string quoted = "\"";
    for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

class RowWriter {
public:
    explicit RowWriter(ByteWriter& out) : out_(out) {}

    template <typename Number>
    void number(Number value) {
        std::array<char, 64> text;
        const auto [end, error] = std::to_chars(text.data(), text.data() + text.size() - 2, value);
        std::string_view digits(text.data(), static_cast<std::size_t>(end - text.data()));
        cell(digits);
        if constexpr (std::is_floating_point_v<Number>)  // so that it does not look like an integer
            if (digits.find_first_not_of("-0123456789") == std::string_view::npos) out_.text(".0");
    }
    void vector(const Vec3f& v) {
        for (int axis = 0; axis < 3; ++axis) number(v[axis]);
    }
    void cell(std::string_view text) {
        if (!std::exchange(is_first_, false)) out_.text(",");
        out_.text(text);
    }
    void end() {
        out_.text("\n");
        is_first_ = true;
    }

private:
    ByteWriter& out_;
    bool is_first_ = true;
};

}  // namespace

FileContents parseTable(Cursor in, const ReadOptions& options) {
    Lines lines(in);
    std::vector<std::string> names;
    std::vector<Column> columns;
    bool has_names = false, has_element = false;
    std::optional<std::int64_t> atoms;  // as .xyz of chemistry says at its beginning
    std::vector<std::size_t> line_of;   // of each row
    while (auto line = lines.next()) {
        const std::size_t first = line->find_first_not_of(" \t,;");
        if (first == std::string::npos || line->at(first) == '#') continue;
        std::vector<std::string> cells = nextCells(lines, std::move(*line));
        if (cells.empty()) continue;
        if (columns.empty()) {
            const bool numeric = numberOf(cells[0]).has_value();
            const auto count = cells.size() == 1 && !has_names ? integerOf(cells[0]) : std::nullopt;
            if (count && *count >= 0) {  // .xyz of chemistry: a count, then a comment
                atoms = count;
                lines.next();
                continue;
            }
            has_element = atoms && !numeric;
            if (!numeric && !has_element && !has_names) {
                has_names = true;
                names = cells;
                continue;
            }
            const std::size_t width = cells.size() - has_element;
            if (!has_names)
                for (std::size_t c = 0; c < width; ++c)
                    names.push_back(c < 3 ? std::string(1, static_cast<char>('x' + c))
                                          : "column" + std::to_string(c + 1));
            columns.resize(names.size());
        }
        if (has_element) cells.erase(cells.begin());
        while (cells.size() > names.size() && cells.back().empty()) cells.pop_back();
        if (cells.size() != names.size())
            lines.fail("has " + std::to_string(cells.size()) + " columns, expected " + std::to_string(names.size()));
        for (std::size_t c = 0; c < names.size(); ++c) {
            const auto number = numberOf(cells[c]);
            if (!number && columns[c].fault.empty())
                columns[c].fault = "line " + std::to_string(lines.number()) + ": '" + cells[c] + "' in column '" +
                                   names[c] + "' is no number";
            columns[c].add(number.value_or(0), cells[c], lines.number());
        }
        line_of.push_back(lines.number());
    }
    if (lines.number() == 0) throw Error(in.file() + ": 0 bytes, expected the names of columns or rows of numbers");
    if (atoms && static_cast<std::int64_t>(line_of.size()) < *atoms)
        throw Error(in.file() + ": has " + std::to_string(line_of.size()) + " rows of atoms, expected " +
                    std::to_string(*atoms) + ", as it says at its beginning");
    const std::size_t rows = line_of.size();
    FileContents contents;
    contents.format = has_names ? "table with named columns" : "table without names";
    columns.resize(names.size());
    if (names.empty()) names = {"x", "y", "z"}, columns.resize(3);
    std::set<std::string> known;
    for (const Meaning& meaning : meaningsOf(names, lines, contents.warnings)) {
        const auto faulty = std::ranges::find_if(meaning.columns, [&](auto c) { return !columns[c].fault.empty(); });
        if (faulty != meaning.columns.end()) {
            const std::string& fault = columns[*faulty].fault;
            if (meaning.name == "P" || isVelocity(meaning.name) || meaning.name == options.id ||
                (options.needs && options.needs(meaning.name)))
                throw Error(in.file() + ": " + fault);
            contents.warnings.push_back("attribute '" + meaning.name + "' is left out: " + fault);
            continue;
        }
        NumberColumn numbers = numbersOf(columns, meaning.columns);
        const auto width = static_cast<std::uint32_t>(meaning.columns.size());
        std::string name = meaning.name;
        for (char& c : name)
            if (static_cast<unsigned char>(c) <= ' ') c = '_';
        if (name.empty()) name = "unnamed";
        if (!known.insert(name).second) {
            contents.warnings.push_back("column '" + meaning.name +
                                        "' is left out, because an earlier one is called '" + name + "' as well");
            continue;
        }
        const std::string beyond = beyondIntegers(columns, meaning.columns, names);
        if (!beyond.empty() && name == options.id)
            throw Error(in.file() + ": " + beyond + " is out of range, expected 0 to 2^63 - 1");
        const bool is_velocity = isVelocity(name) && width > 1;
        if (!beyond.empty() && meaning.name != "P" && !is_velocity)
            contents.warnings.push_back("attribute '" + name + "' becomes floats of single precision: " + beyond +
                                        " needs more than 64 bits");
        contents.declared.push_back({name, haveSigned32Bits(numbers.integer) ? "number" : "int64", width, ""});
        if (meaning.name == "P") {
            for (const std::size_t c : meaning.columns)
                if (auto lost = firstTooLarge(names[c], 1, {columns[c].real, {}}))
                    contents.lost_numbers.push_back(std::move(*lost));
            contents.position = positionsFrom(numbers, 3, options.origin);
            contents.has_double_positions = !numbers.real.empty();
        } else if (is_velocity) {
            if (numbers.real.empty()) numbers = {{numbers.integer.begin(), numbers.integer.end()}, {}};
            addColumn(name, width, std::move(numbers), rows, options, in.file(), contents);
        } else
            addColumn(name, width, std::move(numbers), rows, options, in.file(), contents);
    }
    for (LostNumber& lost : contents.lost_numbers) lost.line = line_of[static_cast<std::size_t>(lost.particle)];
    return deliverWhole(std::move(contents), options);
}

void encodeTable(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    const bool has_velocity = !particles.velocity.empty() || n == 0, has_id = !particles.id.empty() || n == 0;
    requireWritable(particles, file);
    requireWritable(particles.attributes, n, {kReserved.begin(), kReserved.end()}, file);
    RowWriter row(out);
    for (const char* name : {"x", "y", "z"}) row.cell(name);
    if (has_velocity)
        for (const char* name : {"vx", "vy", "vz"}) row.cell(name);
    if (has_id) row.cell("id");
    for (const Attribute& a : particles.attributes)
        for (std::uint32_t c = 0; c < a.components; ++c) row.cell(columnName(a, c));
    row.end();
    for (std::size_t i = 0; i < n; ++i) {
        row.vector(particles.position[i]);
        if (has_velocity) row.vector(particles.velocity[i]);
        if (has_id) row.number(static_cast<std::int64_t>(particles.id[i]));
        for (const Attribute& a : particles.attributes)
            for (std::size_t k = i * a.components; k < (i + 1) * a.components; ++k)
                if (a.integer.empty())
                    row.number(a.real[k]);
                else
                    row.number(a.integer[k]);
        row.end();
    }
    out.flush();
}

}  // namespace betamesh
