// Entries of lists in options and keys, such as "v_1, v_2, v_3".

#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace betamesh {

/// The entries between commas, without the spaces around them.
inline std::vector<std::string> entriesOf(const std::string& list) {
    std::vector<std::string> entries;
    std::istringstream in(list);
    for (std::string entry; std::getline(in, entry, ',');) {
        entry.erase(0, std::min(entry.find_first_not_of(' '), entry.size()));
        entries.push_back(entry.substr(0, entry.find_last_not_of(' ') + 1));
    }
    return entries;
}

}  // namespace betamesh
