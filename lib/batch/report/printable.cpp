
#include "batch/report/printable.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace betamesh {
namespace {

/// A character at the start of a text. length 0: the first byte does not begin a valid UTF-8 character.
struct Character {
    char32_t code = 0;
    std::size_t length = 0;
};

/// source  RFC 3629
Character firstCharacter(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    if (byte(0) < 0x80) return {byte(0), 1};
    const std::size_t length = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
    if (byte(0) < 0xc2 || byte(0) > 0xf4 || text.size() < length) return {};
    char32_t code = byte(0) & (0xffU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xc0U) != 0x80U) return {};
        code = code << 6U | (byte(i) & 0x3fU);
    }
    constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    return code < kLeast[length] || code > 0x10ffff || surrogate ? Character{} : Character{code, length};
}

/// Control characters, and characters that change the direction of text or break lines.
bool isControl(char32_t code) {
    return code < 0x20 || (code >= 0x7f && code <= 0x9f) || code == 0x61c || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

std::string formatted(const char* format, unsigned number) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), format, number);
    return text.data();
}

std::string escapedCode(char32_t code) {
    if (code == '\n') return "\\n";
    if (code == '\r') return "\\r";
    if (code == '\t') return "\\t";
    return formatted(code < 0x80 ? "\\x%02x" : "\\u%04x", code);
}

/// Replaces characters for which isReplaced(code) holds by replacement(code), invalid bytes by invalid(byte).
template <typename IsReplaced, typename Replacement, typename Invalid>
std::string replaced(std::string_view text, const IsReplaced& isReplaced, const Replacement& replacement,
                     const Invalid& invalid) {
    std::string out;
    while (!text.empty()) {
        const Character character = firstCharacter(text);
        const std::size_t length = character.length == 0 ? 1 : character.length;
        if (character.length == 0)
            out += invalid(static_cast<unsigned char>(text[0]));
        else if (isReplaced(character.code))
            out += replacement(character.code);
        else
            out += text.substr(0, length);
        text.remove_prefix(length);
    }
    return out;
}

std::string& hiddenFolder() {
    static std::string folder;
    return folder;
}

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

}  // namespace

void hideFolder(const std::string& folder) { hiddenFolder() = folder; }

std::string withoutHiddenFolder(std::string_view text) {
    const std::string& folder = hiddenFolder();
    std::string shown(text);
    for (std::size_t at = 0; !folder.empty() && (at = shown.find(folder, at)) != std::string::npos;)
        shown.erase(at, folder.size());
    return shown;
}

std::string printable(std::string_view text) {
    return replaced(withoutHiddenFolder(text), isControl, escapedCode,
                    [](unsigned byte) { return formatted("\\x%02x", byte); });
}

std::string printableJson(std::string_view json) {
    const auto asUnicode = [](char32_t code) { return formatted("\\u%04x", code); };
    return replaced(json, isControl, asUnicode, [](unsigned) { return "\\ufffd"; });
}

bool isUtf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = firstCharacter(text).length;
        if (length == 0) return false;
        text.remove_prefix(length);
    }
    return true;
}

std::string percentEncoded(std::string_view bytes) {
    const auto encoded = [](unsigned byte) { return formatted("%%%02X", byte); };
    return replaced(
        bytes, [](char32_t code) { return code == '%'; }, encoded, encoded);
}

std::string percentDecoded(std::string_view text) {
    std::string bytes;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const int high = text[i] == '%' && i + 2 < text.size() ? hexDigit(text[i + 1]) : -1;
        const int low = high >= 0 ? hexDigit(text[i + 2]) : -1;
        bytes += low < 0 ? text[i] : static_cast<char>(high * 16 + low);
        i += low < 0 ? 0 : 2;
    }
    return bytes;
}

}  // namespace betamesh
