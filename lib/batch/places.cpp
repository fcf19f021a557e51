#include "batch/places.h"

#include <iterator>

namespace betamesh {

Places::Places(std::size_t size) {
    if (size > 0) addGap(0, size);
}

void Places::addGap(std::size_t begin, std::size_t bytes) {
    gaps_.emplace(begin, bytes);
    by_size_.emplace(bytes, begin);
}

void Places::removeGap(std::map<std::size_t, std::size_t>::iterator gap) {
    by_size_.erase({gap->second, gap->first});
    gaps_.erase(gap);
}

std::optional<std::size_t> Places::take(std::size_t bytes) {
    const auto fits = by_size_.lower_bound({bytes, 0});
    if (fits == by_size_.end()) return std::nullopt;
    const auto [room, place] = *fits;
    used_.emplace(place, bytes);
    removeGap(gaps_.find(place));
    if (room > bytes) addGap(place + bytes, room - bytes);
    return place;
}

Places::Span Places::giveBack(std::size_t place) {
    const auto block = used_.find(place);
    Span gap{place, place + block->second};
    used_.erase(block);
    if (const auto after = gaps_.find(gap.end); after != gaps_.end()) {
        gap.end += after->second;
        removeGap(after);
    }
    if (const auto next = gaps_.lower_bound(place); next != gaps_.begin())
        if (const auto before = std::prev(next); before->first + before->second == place) {
            gap.begin = before->first;
            removeGap(before);
        }
    addGap(gap.begin, gap.end - gap.begin);
    return gap;
}

Places::Span Places::used() const {
    if (used_.empty()) return {};
    return {used_.begin()->first, used_.rbegin()->first + used_.rbegin()->second};
}

}  // namespace betamesh
