// The door of oneTBB: every loop that runs on several cores goes through these functions.

#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace betamesh {

/// Calls body(begin, end) over pieces that cover [0, n) once. A body writes only its own rows, so the
/// result is the same for any number of threads. grain: the smallest piece worth a task.
template <typename Body>
void parallelRanges(std::size_t n, std::size_t grain, const Body& body) {
    if (n <= grain) {
        if (n > 0) body(std::size_t{0}, n);
        return;
    }
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                      [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
}

/// Calls body(i) for every i in [0, n).
template <typename Body>
void parallelFor(std::size_t n, std::size_t grain, const Body& body) {
    parallelRanges(n, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// Sorts by a strict total order, so the result is the same for any number of threads.
template <typename T, typename Less>
void parallelSort(std::vector<T>& rows, const Less& less) {
    tbb::parallel_sort(rows.begin(), rows.end(), less);
}

/// Turns counts into places: returns n + 1 entries, the sums of all counts before each, then of all.
template <typename Count>
std::vector<Count> placesOf(const std::vector<Count>& counts) {
    std::vector<Count> places(counts.size() + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), places.begin() + 1);
    return places;
}

}  // namespace betamesh
