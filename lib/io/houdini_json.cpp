#include "io/houdini_json.h"

#include "io/houdini_json_tokens.h"

#include <cmath>
#include <limits>
#include <utility>

namespace betamesh {

using namespace houdini_json;

namespace {

constexpr std::size_t kNumbersAtOnce = 4096;

}  // namespace

bool isHoudiniJson(Cursor& in) {
    const std::string_view start = in.peek(kLittleMagic.size());
    return start.starts_with(kLittleMagic) || start.starts_with(kBigMagic) || start.starts_with('[') ||
           start.starts_with('{');
}

HoudiniJsonReader::HoudiniJsonReader(Cursor in) : in_(std::move(in)) {
    const std::string_view start = in_.peek(kLittleMagic.size());
    binary_ = start.starts_with(kLittleMagic) || start.starts_with(kBigMagic);
    if (!binary_) return;
    swapped_ = start.starts_with(kBigMagic) == (std::endian::native == std::endian::little);
    in_.take(kLittleMagic.size(), "magic number");
}

// Values.

HoudiniJsonReader::Token HoudiniJsonReader::peekToken() {
    if (has_token_) return token_;
    if (!levels_.empty() && levels_.back().uniform)
        token_ = scanElement(levels_.back());
    else
        token_ = binary_ ? scanBinary() : scanText();
    has_token_ = true;
    return token_;
}

HoudiniJsonReader::Kind HoudiniJsonReader::kind() {
    switch (peekToken()) {
        case Token::null:
            return Kind::null;
        case Token::boolean:
            return Kind::boolean;
        case Token::integer:
            return Kind::integer;
        case Token::real:
            return Kind::real;
        case Token::text:
            return Kind::text;
        case Token::array_begin:
            return Kind::array;
        case Token::map_begin:
            return Kind::map;
        case Token::array_end:
        case Token::map_end:
            break;
    }
    fail("found the end of an array or map, expected a value");
}

void HoudiniJsonReader::failKind(const char* what, const char* expected) {
    static constexpr const char* kFound[] = {"null", "a boolean", "an integer", "a real number",
                                             "text", "an array",  "a map"};
    fail(std::string(what) + " is " + kFound[static_cast<std::size_t>(kind())] + ", expected " + expected);
}

bool HoudiniJsonReader::boolean(const char* what) {
    const Token found = peekToken();
    if (found != Token::boolean && !(found == Token::integer && (integer_ == 0 || integer_ == 1)))
        failKind(what, "a boolean");
    dropToken();
    return integer_ != 0;
}

std::int64_t HoudiniJsonReader::integer(const char* what) {
    if (peekToken() != Token::integer) failKind(what, "an integer");
    dropToken();
    return integer_;
}

std::string HoudiniJsonReader::text(const char* what) {
    if (peekToken() != Token::text) failKind(what, "text");
    dropToken();
    return std::string(text_);
}

void HoudiniJsonReader::skip() {
    kind();  // fails at the end of a container
    const std::size_t outside = levels_.size();
    do {
        switch (peekToken()) {
            case Token::array_begin:
            case Token::map_begin: {
                dropToken();
                enter(token_ == Token::map_begin);
                Level& level = levels_.back();
                std::size_t bytes = 0;
                if (level.uniform && withNumberType(level.type, [&](auto number) { bytes = sizeof number; })) {
                    in_.requireRows(level.left, bytes, "array of numbers");
                    in_.skip(std::exchange(level.left, 0) * bytes, "array of numbers");
                }
                break;
            }
            case Token::array_end:
            case Token::map_end:
                dropToken();
                leave(token_ == Token::map_end);
                break;
            default:
                dropToken();
        }
    } while (levels_.size() > outside);
}

void HoudiniJsonReader::forElements(const char* what, const std::function<void()>& element) {
    if (peekToken() != Token::array_begin) failKind(what, "an array");
    dropToken();
    enter(false);
    while (peekToken() != Token::array_end) element();
    dropToken();
    leave(false);
}

void HoudiniJsonReader::forKeys(const char* what, const std::function<void(const std::string& key)>& value) {
    const bool is_map = peekToken() == Token::map_begin;
    if (!is_map && token_ != Token::array_begin) failKind(what, "a map, or an array of keys and values");
    dropToken();
    enter(is_map);
    while (peekToken() != (is_map ? Token::map_end : Token::array_end)) value(text(what));
    dropToken();
    leave(is_map);
}

void HoudiniJsonReader::readToEnd() {
    while (!in_.peek(1).empty()) in_.take(in_.peek(1).size(), "end of the file");
}

// Numbers.

template <typename T, typename Number>
T HoudiniJsonReader::converted(Number number, const char* what) const {
    using Limits = std::numeric_limits<T>;
    if constexpr (std::is_same_v<Number, Half>) {
        return converted<T>(fromHalf(number), what);
    } else if constexpr (std::is_floating_point_v<T>) {
        return static_cast<T>(number);
    } else if constexpr (std::is_floating_point_v<Number>) {
        const auto wide = static_cast<double>(number);
        // Written so that NaN fails, too. The upper limit of 64 bits is no double; the next power of two is.
        if (!(wide >= static_cast<double>(Limits::min()) && wide < -static_cast<double>(Limits::min()) &&
              std::trunc(wide) == wide))
            fail(std::string(what) + " has the number " + std::to_string(wide) + ", expected an integer of " +
                 std::to_string(8 * sizeof(T)) + " bits");
        return static_cast<T>(wide);
    } else {
        const auto wide = static_cast<std::int64_t>(number);
        if (wide < Limits::min() || wide > Limits::max())
            fail(std::string(what) + " has the number " + std::to_string(wide) + ", expected an integer of " +
                 std::to_string(8 * sizeof(T)) + " bits");
        return static_cast<T>(wide);
    }
}

template <typename T, typename Stored>
void HoudiniJsonReader::forUniform(Level& level, const char* what,
                                   const std::function<void(std::span<const T>)>& visit) {
    std::array<T, kNumbersAtOnce> numbers;
    in_.requireRows(level.left, sizeof(Stored), what);
    while (level.left > 0) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kNumbersAtOnce, level.left));
        const std::byte* from = in_.take(count * sizeof(Stored), what);
        for (std::size_t i = 0; i < count; ++i)
            numbers[i] = converted<T>(load<Stored>(from + i * sizeof(Stored), swapped_), what);
        level.left -= count;
        visit(std::span<const T>(numbers).first(count));
    }
}

template <typename T>
void HoudiniJsonReader::forNumbers(const char* what, const std::function<void(std::span<const T>)>& visit) {
    if (peekToken() != Token::array_begin) failKind(what, "an array of numbers");
    dropToken();
    enter(false);
    Level& level = levels_.back();  // stays where it is: no container is entered before it is left
    if (level.uniform)
        withNumberType(level.type, [&]<typename Stored>(Stored) { forUniform<T, Stored>(level, what, visit); });
    std::array<T, 256> numbers;
    std::size_t count = 0;
    for (;;) {
        const Token found = peekToken();
        if (found == Token::array_end || count == numbers.size()) {
            if (count > 0) visit(std::span<const T>(numbers).first(std::exchange(count, 0)));
            if (found == Token::array_end) break;
        }
        if (found == Token::integer)
            numbers[count++] = converted<T>(integer_, what);
        else if (found == Token::real)
            numbers[count++] = converted<T>(real_, what);
        else
            failKind(what, "an array of numbers");
        dropToken();
    }
    dropToken();
    leave(false);
}

template void HoudiniJsonReader::forNumbers(const char*, const std::function<void(std::span<const float>)>&);
template void HoudiniJsonReader::forNumbers(const char*, const std::function<void(std::span<const double>)>&);
template void HoudiniJsonReader::forNumbers(const char*, const std::function<void(std::span<const std::int32_t>)>&);
template void HoudiniJsonReader::forNumbers(const char*, const std::function<void(std::span<const std::int64_t>)>&);

// Containers.

void HoudiniJsonReader::enter(bool is_map) {
    if (levels_.size() == kMaxDepth)
        fail("more than " + std::to_string(kMaxDepth) + " containers inside each other, expected fewer");
    Level level = std::exchange(next_level_, {});
    level.is_map = is_map;
    levels_.push_back(level);
}

void HoudiniJsonReader::leave(bool is_map) {
    if (levels_.empty() || levels_.back().is_map != is_map)
        fail(is_map ? "found the end of a map, expected that of an array"
                    : "found the end of an array, expected that of a map");
    levels_.pop_back();
}

}  // namespace betamesh
