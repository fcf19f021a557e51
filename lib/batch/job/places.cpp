
#include "batch/job/places.h"

#include <iterator>

namespace betamesh {

Places::Places(std::size_t size) {
    if (size == 0) return;
    gaps_.emplace(0, size);
    gaps_by_size_.emplace(size, 0);
}

std::optional<std::size_t> Places::take(std::size_t bytes) {
    const auto fits = gaps_by_size_.lower_bound({bytes, 0});
    if (fits == gaps_by_size_.end()) return std::nullopt;
    const auto [room, place] = *fits;
    Blocks block{{place, bytes}};  // what may fail comes first
    Sizes size{{bytes, place}};
    used_.merge(block);
    used_by_size_.merge(size);
    auto gap = gaps_.extract(place);
    auto gap_size = gaps_by_size_.extract(fits);
    if (room == bytes) return place;
    gap.key() = place + bytes;
    gap.mapped() = room - bytes;
    gap_size.value() = {room - bytes, place + bytes};
    gaps_.insert(std::move(gap));
    gaps_by_size_.insert(std::move(gap_size));
    return place;
}

Places::Span Places::giveBack(std::size_t place) noexcept {
    auto block = used_.extract(place);
    auto size = used_by_size_.extract({block.mapped(), place});
    Span gap{place, place + block.mapped()};
    const auto join = [&](Blocks::iterator other) {
        gaps_by_size_.erase({other->second, other->first});
        gaps_.erase(other);
    };
    if (const auto after = gaps_.find(gap.end); after != gaps_.end()) {
        gap.end += after->second;
        join(after);
    }
    if (const auto next = gaps_.lower_bound(place); next != gaps_.begin())
        if (const auto before = std::prev(next); before->first + before->second == place) {
            gap.begin = before->first;
            join(before);
        }
    block.key() = gap.begin;
    block.mapped() = gap.end - gap.begin;
    size.value() = {gap.end - gap.begin, gap.begin};
    gaps_.insert(std::move(block));
    gaps_by_size_.insert(std::move(size));
    return gap;
}

Places::Span Places::used() const {
    if (used_.empty()) return {};
    return {used_.begin()->first, used_.rbegin()->first + used_.rbegin()->second};
}

}  // namespace betamesh
