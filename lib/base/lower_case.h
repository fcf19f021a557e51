// Letters in lower case, whatever the locale.

#pragma once

#include <string>

namespace betamesh {

/// A letter A to Z in lower case; every other character as it is.
constexpr char lowerCase(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

inline std::string lowerCase(std::string text) {
    for (char& c : text) c = lowerCase(c);
    return text;
}

}  // namespace betamesh
