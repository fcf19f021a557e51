// Which places of a range of addresses, or of a file, are in use.

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace betamesh {

/// Hands out places in [0, size) and takes them back. Not for several threads at once.
///
/// cost  O(log places)
class Places {
public:
    struct Span {
        std::size_t begin = 0, end = 0;
    };

    /// size 0: there is no room.
    explicit Places(std::size_t size = 0);

    /// Where so many bytes > 0 are from now on: in the smallest gap with room for them, the first of several.
    /// errors  std::bad_alloc, and nothing is taken
    std::optional<std::size_t> take(std::size_t bytes);
    /// What was taken at this place.
    std::size_t bytesAt(std::size_t place) const { return used_.at(place); }
    /// Returns the gap that it is a part of now.
    Span giveBack(std::size_t place) noexcept;

    /// From the first that is in use to the end of the last.
    Span used() const;
    const std::map<std::size_t, std::size_t>& gaps() const { return gaps_; }  ///< where each begins -> bytes

private:
    using Blocks = std::map<std::size_t, std::size_t>;            // place -> bytes
    using Sizes = std::set<std::pair<std::size_t, std::size_t>>;  // bytes, place

    Blocks used_, gaps_;
    Sizes used_by_size_, gaps_by_size_;  // the first of these so that what is given back needs no memory
};

}  // namespace betamesh
