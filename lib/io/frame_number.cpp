#include "io/frame_number.h"

#include <cctype>
#include <cstddef>

namespace betamesh {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// Whether a name ends in the v of a version: "drop_v", "v", but not "wave".
bool endsInVersion(std::string_view name) {
    if (name.empty() || (name.back() != 'v' && name.back() != 'V')) return false;
    return name.size() == 1 || std::isalnum(static_cast<unsigned char>(name[name.size() - 2])) == 0;
}

}  // namespace

std::string_view frameNumberIn(std::string_view name) {
    const std::size_t dot = name.find('.', name.find_last_of("0123456789") + 1);
    const std::string_view stem = name.substr(0, dot);
    std::size_t begin = stem.size();
    while (begin > 0 && isDigit(stem[begin - 1])) --begin;
    if (begin == stem.size() || endsInVersion(stem.substr(0, begin))) return stem.substr(stem.size());
    const bool negative = begin > 1 && stem[begin - 1] == '-' && (stem[begin - 2] == '.' || stem[begin - 2] == '_');
    return stem.substr(negative ? begin - 1 : begin);
}

}  // namespace betamesh
