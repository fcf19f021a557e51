// Suggestions for mistyped words.

#pragma once

#include "base/edit_distance.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// The known word that was probably meant: the one with the smallest edit distance, or one that begins with the typed
/// word. Empty if none is similar.
inline std::string nearestWord(std::string_view typed, const std::vector<std::string>& known) {
    constexpr std::size_t kLeastPrefix = 3;  // characters; shorter words are similar to too many others
    constexpr std::size_t kMostChanges = 3;
    const std::size_t similar = typed.size() < kLeastPrefix ? 0 : std::min(kMostChanges, (typed.size() + 1) / 2);
    std::string nearest;
    std::size_t least = similar + 1;
    for (const std::string& word : known) {
        const bool begins = typed.size() >= kLeastPrefix && word.starts_with(typed);
        const std::size_t distance = begins ? 1 : editDistance(typed, word);
        if (distance >= least) continue;
        least = distance;
        nearest = word;
    }
    return nearest;
}

/// " Did you mean 'mesh'?" with the nearest known word; empty if none is similar.
inline std::string didYouMean(std::string_view typed, const std::vector<std::string>& known) {
    const std::string nearest = nearestWord(typed, known);
    return nearest.empty() ? "" : " Did you mean '" + nearest + "'?";
}

}  // namespace betamesh
