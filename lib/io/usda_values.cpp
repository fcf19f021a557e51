#include "io/usda_values.h"

#include "betamesh/error.h"
#include "io/usda_parser.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <utility>

namespace betamesh {

namespace {

/// The numbers of one value, in the brackets of its type.
class Numbers {
public:
    Numbers(std::string_view text, const UsdaType& type, const std::string& what)
        : text_(text), type_(type), what_(what) {}

    NumberColumn all() {
        if (text_.empty() || text_ == "None") return {};
        if (!type_.is_array) {
            element(0);
        } else {
            expect('[');
            while (!take(']')) {
                element(0);
                if (!take(',') && here() != ']') fail("',' or ']' is missing");
            }
        }
        skipSpace();
        if (!text_.empty()) fail("there is something behind it");
        return std::move(column_);
    }

private:
    [[noreturn]] void fail(const std::string& why) const {
        throw Error(what_ + ": the value is not of its type: " + why + " after " + std::to_string(column_.size()) +
                    " numbers.");
    }
    char here() const { return text_.empty() ? '\0' : text_.front(); }
    void skipSpace() {
        std::size_t i = 0;
        for (; i < text_.size(); ++i) {
            if (text_[i] == '#')
                i = std::min(text_.find('\n', i), text_.size() - 1);
            else if (text_[i] != ' ' && text_[i] != '\n' && text_[i] != '\t' && text_[i] != '\r')
                break;
        }
        text_.remove_prefix(std::min(i, text_.size()));
    }
    bool take(char c) {
        skipSpace();
        if (here() != c || text_.empty()) return false;
        text_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!take(c)) fail(std::string("'") + c + "' is missing");
    }

    void element(int depth) {
        const std::size_t before = column_.size();
        if (type_.components == 1)
            number();
        else
            tuple(depth);
        if (depth == 0 && column_.size() != before + type_.components)
            fail("expected tuples of " + std::to_string(type_.components));
    }

    /// A tuple of numbers, or of tuples: a matrix.
    void tuple(int depth) {
        expect('(');
        while (!take(')')) {
            skipSpace();
            if (here() == '(' && depth == 0)
                tuple(1);
            else
                number();
            if (!take(',') && here() != ')') fail("',' or ')' is missing");
        }
    }

    void number() {
        skipSpace();
        if (text_.starts_with('+')) text_.remove_prefix(1);
        const char *begin = text_.data(), *end = begin + text_.size();
        std::from_chars_result read{begin, std::errc::invalid_argument};
        double real = 0;
        std::int64_t integer = 0;
        if (isReal(type_.number)) {
            read = std::from_chars(begin, end, real);
            if (read.ec == std::errc::result_out_of_range) {
                real = std::strtod(std::string(begin, read.ptr).c_str(), nullptr);
                read.ec = {};
            }
        } else {
            read = std::from_chars(begin, end, integer);
            if (read.ec == std::errc::result_out_of_range && type_.number == NumberType::uint64) {
                std::uint64_t large = 0;
                read = std::from_chars(begin, end, large);
                integer = static_cast<std::int64_t>(large);
            }
            for (const std::string_view word : {"false", "true"})
                if (read.ec == std::errc::invalid_argument && text_.starts_with(word)) {
                    read = {begin + word.size(), {}};
                    integer = word == "true" ? 1 : 0;
                }
        }
        if (read.ec != std::errc()) fail("there is no number, or one that is too large,");
        if (isReal(type_.number))
            column_.real.push_back(type_.number == NumberType::float32 ? static_cast<float>(real) : real);
        else
            column_.integer.push_back(integer);
        text_.remove_prefix(static_cast<std::size_t>(read.ptr - begin));
    }

    std::string_view text_;
    const UsdaType& type_;
    const std::string& what_;
    NumberColumn column_;
};

}  // namespace

std::optional<UsdaType> usdaType(std::string_view type) {
    UsdaType found;
    if (type.ends_with("[]")) {
        found.is_array = true;
        type.remove_suffix(2);
    }
    constexpr std::array<std::pair<std::string_view, NumberType>, 10> kNumbers{{{"float", NumberType::float32},
                                                                                {"double", NumberType::float64},
                                                                                {"half", NumberType::float32},
                                                                                {"timecode", NumberType::float64},
                                                                                {"int", NumberType::int32},
                                                                                {"uint", NumberType::uint32},
                                                                                {"int64", NumberType::int64},
                                                                                {"uint64", NumberType::uint64},
                                                                                {"uchar", NumberType::uint8},
                                                                                {"bool", NumberType::uint8}}};
    const auto numbered = [&](std::string_view name, NumberType number, std::size_t components) {
        found.name = name;
        found.number = number;
        found.components = components;
        return found;
    };
    for (const auto& [name, number] : kNumbers) {
        if (type == name) return numbered(name, number, 1);
        if (type.size() == name.size() + 1 && type.starts_with(name) && type.back() >= '2' && type.back() <= '4')
            return numbered(name, number, static_cast<std::size_t>(type.back() - '0'));
    }
    for (const std::size_t rows : {2U, 3U, 4U})
        if (type == "matrix" + std::to_string(rows) + "d") return numbered("double", NumberType::float64, rows * rows);
    if (type.size() < 5 || std::string_view("fdh").find(type.back()) == std::string_view::npos) return std::nullopt;
    const auto [name, number] = type.back() == 'f'   ? std::pair("float", NumberType::float32)
                                : type.back() == 'd' ? std::pair("double", NumberType::float64)
                                                     : std::pair("half", NumberType::float32);
    type.remove_suffix(1);
    if (type == "quat") return numbered(name, number, 4);
    const std::size_t components = static_cast<std::size_t>(type.back() - '0');
    type.remove_suffix(1);
    const bool has_role =
        type == "point" || type == "vector" || type == "normal" || type == "color" || type == "texCoord";
    if (!has_role || components < 2 || components > 4) return std::nullopt;
    return numbered(name, number, components);
}

NumberColumn usdaNumbers(std::string_view value, const UsdaType& type, const std::string& what) {
    return Numbers(value, type, what).all();
}

std::vector<std::string> usdaStrings(std::string_view value) {
    std::vector<std::string> strings;
    for (std::size_t at = value.find('"'); at != std::string_view::npos; at = value.find('"', at)) {
        const std::size_t end = value.find('"', at + 1);
        if (end == std::string_view::npos) break;
        strings.emplace_back(value.substr(at + 1, end - at - 1));
        at = end + 1;
    }
    return strings;
}

Vec3 UsdaTransform::vector(const Vec3& v) const {
    Vec3 result(0, 0, 0);
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) result[k] += v[i] * rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    return result;
}

Vec3 UsdaTransform::point(const Vec3& p) const {
    const auto& shift = rows[3];
    return vector(p) + Vec3(shift[0], shift[1], shift[2]);
}

namespace {
Vec3 rowOf(const UsdaTransform& map, std::size_t i) { return {map.rows[i][0], map.rows[i][1], map.rows[i][2]}; }
}  // namespace

Vec3 UsdaTransform::normal(const Vec3& n) const {
    // The cofactors of the matrix are its inverse transpose times its determinant.
    const Vec3 a = rowOf(*this, 0), b = rowOf(*this, 1), c = rowOf(*this, 2);
    const Vec3 turned = b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z;
    return turned.normalized() * (determinant() < 0 ? -1.0 : 1.0);
}

double UsdaTransform::determinant() const { return rowOf(*this, 0).cross(rowOf(*this, 1)).dot(rowOf(*this, 2)); }

UsdaTransform UsdaTransform::followedBy(const UsdaTransform& next) const {
    UsdaTransform both;
    for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 row = i < 3 ? next.vector(rowOf(*this, i)) : next.point(rowOf(*this, i));
        both.rows[i] = {row.x, row.y, row.z};
    }
    return both;
}

}  // namespace betamesh
