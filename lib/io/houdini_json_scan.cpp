// The two encodings of Houdini's JSON, token by token.

#include "io/houdini_json.h"
#include "io/houdini_json_tokens.h"

#include <charconv>
#include <cstdlib>

namespace betamesh {

using namespace houdini_json;

namespace {

constexpr std::uint64_t kCharactersAtOnce = std::uint64_t{1} << 16;

std::string inHex(std::uint8_t byte) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    return std::string("0x") + kDigits[byte >> 4] + kDigits[byte & 15];
}

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Encodes a code point below 0x110000.
void appendUtf8(std::uint32_t c, std::string& text) {
    const auto put = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
    if (c < 0x80) {
        put(c);
    } else if (c < 0x800) {
        put(0xc0 | c >> 6);
        put(0x80 | (c & 0x3f));
    } else if (c < 0x10000) {
        put(0xe0 | c >> 12);
        put(0x80 | (c >> 6 & 0x3f));
        put(0x80 | (c & 0x3f));
    } else {
        put(0xf0 | c >> 18);
        put(0x80 | (c >> 12 & 0x3f));
        put(0x80 | (c >> 6 & 0x3f));
        put(0x80 | (c & 0x3f));
    }
}

}  // namespace

// The binary encoding.

template <typename T>
T HoudiniJsonReader::number(const char* what) {
    return load<T>(in_.take(sizeof(T), what), swapped_);
}

std::uint64_t HoudiniJsonReader::length(const char* what) {
    const auto first = number<std::uint8_t>(what);
    if (first < code::first_length_code) return first;
    switch (first) {
        case code::length16:
            return number<std::uint16_t>(what);
        case code::length32:
            return number<std::uint32_t>(what);
        case code::length64: {
            const auto count = number<std::int64_t>(what);
            if (count < 0) fail(std::string(what) + " is " + std::to_string(count) + ", expected 0 or more");
            return static_cast<std::uint64_t>(count);
        }
        default:
            fail(std::string(what) + " begins with " + inHex(first) +
                 ", expected less than 0xf1, or 0xf2, 0xf4 or 0xf8");
    }
}

std::string HoudiniJsonReader::characters(std::uint64_t count) {
    in_.requireRows(count, 1, "text");
    std::string text;
    while (text.size() < count) {
        const auto piece = static_cast<std::size_t>(std::min(kCharactersAtOnce, count - text.size()));
        text.append(reinterpret_cast<const char*>(in_.take(piece, "text")), piece);
    }
    return text;
}

HoudiniJsonReader::Token HoudiniJsonReader::scanNumber(std::uint8_t type) {
    Token token = Token::null;
    withNumberType(type, [&]<typename Stored>(Stored) {
        const Stored stored = number<Stored>("number");
        if constexpr (std::is_integral_v<Stored>) {
            integer_ = stored;
            token = Token::integer;
        } else {
            if constexpr (std::is_same_v<Stored, Half>)
                real_ = fromHalf(stored);
            else
                real_ = stored;
            token = Token::real;
        }
    });
    return token;
}

HoudiniJsonReader::Token HoudiniJsonReader::scanElement(Level& level) {
    if (level.left == 0) return Token::array_end;
    --level.left;
    switch (level.type) {
        case code::boolean:
            if (level.bool_bits_left == 0) {
                level.bool_bits = number<std::uint32_t>("booleans");
                level.bool_bits_left = 32;
            }
            integer_ = level.bool_bits & 1;
            level.bool_bits >>= 1;
            --level.bool_bits_left;
            return Token::boolean;
        case code::text:
            text_ = own_text_ = characters(length("length of text"));
            return Token::text;
        case code::reference: {
            const std::uint64_t key = length("number of a string");
            const auto found = strings_.find(key);
            if (found == strings_.end())
                fail("refers to string " + std::to_string(key) + ", expected one defined before");
            text_ = found->second;
            return Token::text;
        }
        default:
            return scanNumber(level.type);
    }
}

HoudiniJsonReader::Token HoudiniJsonReader::scanBinary() {
    for (;;) {
        const auto type = number<std::uint8_t>("token");
        switch (type) {
            case code::null:
                return Token::null;
            case code::no:
            case code::yes:
                integer_ = type == code::yes;
                return Token::boolean;
            case code::boolean:
                integer_ = number<std::uint8_t>("boolean") != 0;
                return Token::boolean;
            case code::array_begin:
                return Token::array_begin;
            case code::array_end:
                return Token::array_end;
            case code::map_begin:
                return Token::map_begin;
            case code::map_end:
                return Token::map_end;
            case code::define: {
                const std::uint64_t key = length("number of a string");
                strings_[key] = characters(length("length of text"));
                continue;
            }
            case code::undefine:
                strings_.erase(length("number of a string"));
                continue;
            case code::text:
            case code::reference: {
                Level one;
                one.type = type;
                one.left = 1;
                return scanElement(one);
            }
            case code::uniform: {
                next_level_.uniform = true;
                next_level_.type = number<std::uint8_t>("type of an array");
                next_level_.left = length("length of an array");
                const bool known = next_level_.type == code::boolean || next_level_.type == code::text ||
                                   next_level_.type == code::reference || withNumberType(next_level_.type, [](auto) {});
                if (!known)
                    fail("an array has elements of type " + inHex(next_level_.type) +
                         ", expected numbers, booleans or text");
                return Token::array_begin;
            }
            default:
                if (const Token token = scanNumber(type); token != Token::null) return token;
                fail("found " + inHex(type) + ", expected a token of Houdini's binary JSON");
        }
    }
}

// The text encoding. Commas and colons are read as white space: brackets and the order of values say everything.

HoudiniJsonReader::Token HoudiniJsonReader::scanText() {
    const auto next = [&] {
        const std::string_view rest = in_.peek(1);
        if (rest.empty()) fail("the file ends here, expected a value or the end of an array or map");
        return rest.front();
    };
    while (isSpace(next()) || next() == ',' || next() == ':') in_.take(1, "text");
    switch (next()) {
        case '[':
            return in_.take(1, "text"), Token::array_begin;
        case ']':
            return in_.take(1, "text"), Token::array_end;
        case '{':
            return in_.take(1, "text"), Token::map_begin;
        case '}':
            return in_.take(1, "text"), Token::map_end;
        case '"':
            text_ = own_text_ = quotedText();
            return Token::text;
        default:
            return scanWord();
    }
}

HoudiniJsonReader::Token HoudiniJsonReader::scanWord() {
    constexpr std::size_t kLongest = 100;
    std::string word;
    for (;;) {
        const std::string_view rest = in_.peek(1);
        if (rest.empty() || isSpace(rest.front()) || std::string_view(",:[]{}\"").find(rest.front()) < 7) break;
        if (word.size() == kLongest) fail("found a word of more than 100 characters, expected a number");
        word += rest.front();
        in_.take(1, "text");
    }
    if (word == "null") return Token::null;
    if (word == "true" || word == "false") {
        integer_ = word == "true";
        return Token::boolean;
    }
    const char* end = word.data() + word.size();
    const auto whole = std::from_chars(word.data(), end, integer_);
    if (whole.ec == std::errc() && whole.ptr == end) return Token::integer;
    const auto real = std::from_chars(word.data(), end, real_);
    if (real.ptr == end && real.ec == std::errc()) return Token::real;
    if (real.ptr == end && real.ec == std::errc::result_out_of_range) {
        real_ = std::strtod(word.c_str(), nullptr);  // infinite, or zero and its neighbours
        return Token::real;
    }
    for (char& c : word)
        if (c < ' ' || c > '~') c = '?';
    fail("found '" + word + "', expected a value of JSON");
}

std::string HoudiniJsonReader::quotedText() {
    std::string text;
    in_.take(1, "text");
    for (;;) {
        const auto c = static_cast<char>(*in_.take(1, "text"));
        if (c == '"') return text;
        if (c == '\\')
            appendEscaped(text);
        else
            text += c;
    }
}

std::uint32_t HoudiniJsonReader::hexDigits() {
    const char* digits = reinterpret_cast<const char*>(in_.take(4, "\\u in text"));
    std::uint32_t value = 0;
    if (std::from_chars(digits, digits + 4, value, 16).ptr != digits + 4)
        fail("\\u is followed by no four hexadecimal digits");
    return value;
}

void HoudiniJsonReader::appendEscaped(std::string& text) {
    constexpr std::string_view kLetters = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
    const auto c = static_cast<char>(*in_.take(1, "text"));
    if (const std::size_t at = kLetters.find(c); at != std::string_view::npos) {
        text += kMeant[at];
        return;
    }
    if (c != 'u') fail("text has an unknown character after a backslash, expected one of \"\\/bfnrtu");
    std::uint32_t point = hexDigits();
    if (point >= 0xd800 && point < 0xdc00 && in_.peek(2).starts_with("\\u")) {  // the first of two surrogates
        in_.take(2, "text");
        const std::uint32_t second = hexDigits();
        if (second < 0xdc00 || second > 0xdfff) fail("a surrogate in text is followed by no second one");
        point = 0x10000 + ((point - 0xd800) << 10) + (second - 0xdc00);
    }
    appendUtf8(point, text);
}

}  // namespace betamesh
