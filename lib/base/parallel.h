// The door of oneTBB: every loop that runs on several cores goes through these functions.

#pragma once

#include "base/fork.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace betamesh {

/// How many threads loops may run on here, about.
inline std::size_t threadsHere() { return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()); }

/// What a loop throws that was left undone because one round it has failed: nothing may go on with what it did not
/// make. The loop round it ends with its own exception.
struct LoopLeft {};
inline void throwIfLeft() {
    if (tbb::is_current_task_group_canceling()) throw LoopLeft();
}

/// Calls body(begin, end) over pieces that cover [0, n) once. A body writes only its own rows, so the
/// result is the same for any number of threads. grain: the smallest piece worth a task.
template <typename Body>
void parallelRanges(std::size_t n, std::size_t grain, const Body& body) {
    if (n <= grain) {
        if (n > 0) body(std::size_t{0}, n);
        return;
    }
    Fork fork;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& range) {
        const Fork::Branch branch(fork);
        body(range.begin(), range.end());
    });
    throwIfLeft();
}

/// Calls body(i) for every i in [0, n).
template <typename Body>
void parallelFor(std::size_t n, std::size_t grain, const Body& body) {
    parallelRanges(n, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// How many shares of n rows are worth a task of their own: as many as there are threads, eight at most.
inline std::size_t sharesOf(std::size_t n) {
    constexpr std::size_t kLeast = 1024, kMost = 8;
    return std::clamp<std::size_t>(std::min(threadsHere(), n / kLeast), 1, kMost);
}

/// Calls body(share, begin, end) for so many parts of [0, n), in any order.
template <typename Body>
void parallelShares(std::size_t n, const Body& body) {
    const std::size_t shares = sharesOf(n);
    parallelFor(shares, 1, [&](std::size_t share) { body(share, n * share / shares, n * (share + 1) / shares); });
}

/// Calls body(). While it waits for loops in it, its thread begins nothing else: it may hold a lock.
template <typename Body>
void alone(const Body& body) {
    tbb::this_task_arena::isolate(body);
}

/// Calls both, at the same time where there are threads for it.
template <typename First, typename Second>
void parallelBoth(const First& first, const Second& second) {
    parallelFor(2, 1, [&](std::size_t i) {
        if (i == 0)
            first();
        else
            second();
    });
}

/// Makes room for n rows. Memory is handed out page by page as it is touched for the first time, which takes longer
/// than to fill it: all threads do the touching.
template <typename T>
void firstTouchReserve(std::vector<T>& rows, std::size_t n) {
    constexpr std::size_t kPage = 4096;
    if (n <= rows.capacity()) return;
    rows.reserve(n);
    auto* const begin = reinterpret_cast<volatile unsigned char*>(rows.data() + rows.size());
    const std::size_t bytes = (n - rows.size()) * sizeof(T);
    parallelFor((bytes + kPage - 1) / kPage, 64, [&](std::size_t page) { begin[page * kPage] = 0; });
}

/// As rows.resize(n), in such room.
template <typename T>
void firstTouchResize(std::vector<T>& rows, std::size_t n) {
    firstTouchReserve(rows, n);
    rows.resize(n);
}

/// The rows of some parts, one part after another; rowsOf(part): a member, where the part is not itself a list of them.
template <typename Part, typename CompressedRows = std::identity>
auto concatenate(const std::vector<Part>& parts, const CompressedRows& rowsOf = {}) {
    std::vector<std::size_t> first(parts.size() + 1, 0);
    for (std::size_t p = 0; p < parts.size(); ++p) first[p + 1] = first[p] + std::invoke(rowsOf, parts[p]).size();
    std::remove_cvref_t<std::invoke_result_t<CompressedRows, const Part&>> rows;
    firstTouchResize(rows, first.back());
    parallelFor(parts.size(), 1, [&](std::size_t p) {
        const auto& some = std::invoke(rowsOf, parts[p]);
        std::copy(some.begin(), some.end(), rows.begin() + static_cast<std::ptrdiff_t>(first[p]));
    });
    return rows;
}

/// The rows i of [0, n) for which is(i), ascending.
template <typename Is>
std::vector<std::uint32_t> indicesWhere(std::size_t n, const Is& is) {
    constexpr std::size_t kRowsPerTask = 16384;
    std::vector<std::vector<std::uint32_t>> rows((n + kRowsPerTask - 1) / kRowsPerTask);
    parallelFor(rows.size(), 1, [&](std::size_t task) {
        for (std::size_t i = task * kRowsPerTask; i < std::min(n, (task + 1) * kRowsPerTask); ++i)
            if (is(static_cast<std::uint32_t>(i))) rows[task].push_back(static_cast<std::uint32_t>(i));
    });
    return concatenate(rows);
}

/// How many rows i of [0, n) there are for which is(i).
template <typename Is>
std::size_t countWhere(std::size_t n, const Is& is) {
    std::atomic<std::size_t> count = 0;
    parallelRanges(n, 16384, [&](std::size_t begin, std::size_t end) {
        std::size_t here = 0;
        for (std::size_t i = begin; i < end; ++i) here += is(static_cast<std::uint32_t>(i));
        count += here;
    });
    return count;
}

/// The first row i of [0, n) for which is(i), n where there is none. is: asked of all rows of a range without a branch,
/// so several at a time where it has none itself.
template <typename Is>
std::size_t firstRowWhere(std::size_t n, const Is& is) {
    constexpr std::size_t kRowsPerTask = 16384;
    std::atomic<std::size_t> first = n;
    parallelRanges(n, kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        bool any = false;
        for (std::size_t i = begin; i < end; ++i) any |= is(i);
        if (!any) return;
        while (!is(begin)) ++begin;
        for (std::size_t least = first; begin < least && !first.compare_exchange_weak(least, begin);) {
        }
    });
    return first;
}

/// Sorts by a strict total order, so the result is the same for any number of threads.
template <typename T, typename Less>
void parallelSort(std::vector<T>& rows, const Less& less) {
#if defined(__SANITIZE_THREAD__)
    std::sort(rows.begin(), rows.end(), less);  // pieces go from thread to thread, and nobody tells what that orders
#else
    tbb::parallel_sort(rows.begin(), rows.end(), less);
    throwIfLeft();
#endif
}

/// Runs body() with at most this many threads (>= 1), its own included, in everything it calls.
template <typename Body>
void withThreads(int threads, const Body& body) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena(threads).execute(body);
}

/// Makes sure that the threads of withThreads(threads) are there, so that none need be made when memory is short. Gives
/// up waiting for them after half a second.
inline void startThreads(int threads) {
    std::atomic<int> arrived = 0;
    const auto latest = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    Fork fork;
    tbb::parallel_for(
        0, threads,
        [&](int) {
            const Fork::Branch branch(fork);
            ++arrived;
            while (arrived < threads && std::chrono::steady_clock::now() < latest) std::this_thread::yield();
        },
        tbb::simple_partitioner());
}

/// Calls body(i) for i = 0, 1 … n - 1, begun in this order, at most in_flight (>= 1) of them at once; begins
/// no further one once goOn() is false. A body may use parallel loops; while it waits for them its thread
/// begins no other body.
template <typename GoOn, typename Body>
void parallelInFlight(std::size_t n, std::size_t in_flight, const GoOn& goOn, const Body& body) {
    std::size_t next = 0;
    Fork fork;
    const auto take = [&](tbb::flow_control& control) {
        const Fork::Turn turn(fork);
        if (next == n || !goOn()) control.stop();
        return next++;
    };
    const auto work = [&](std::size_t i) {
        const Fork::Branch branch(fork);
        alone([&] { body(i); });
    };
    tbb::parallel_pipeline(in_flight, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
                                          tbb::make_filter<std::size_t, void>(tbb::filter_mode::parallel, work));
}

/// Goes through what take() gives, an optional that is empty at the end: make(item) is called for several items at
/// once, while the next are taken; give(made) for one after the other, in the order in which they were taken. Ends with
/// the first exception of any of them in this order.
template <typename Take, typename Make, typename Give>
void parallelInOrder(const Take& take, const Make& make, const Give& give) {
    struct Step {
        std::invoke_result_t<Take> item;
        std::optional<std::invoke_result_t<Make, typename decltype(item)::value_type&&>> made;
        std::exception_ptr failure;
    };
    std::vector<Step> steps(2 * threadsHere());  // as many as are under way; the next begins where the first has ended
    std::size_t next = 0;
    bool ended = false;
    Fork fork;
    const auto taking = [&](tbb::flow_control& control) {
        const Fork::Turn turn(fork);
        Step& step = steps[next++ % steps.size()] = {};
        try {
            if (!ended) step.item = take();
        } catch (...) {
            step.failure = std::current_exception();
        }
        if (!step.item && !step.failure) control.stop();
        ended = !step.item;
        return &step;
    };
    const auto making = [&](Step* step) {
        const Fork::Turn turn(fork);
        try {
            if (step->item) step->made = make(*std::move(step->item));
        } catch (...) {
            step->failure = std::current_exception();
        }
        return step;
    };
    const auto giving = [&](Step* step) {
        const Fork::Turn turn(fork);
        if (step->failure) std::rethrow_exception(step->failure);
        alone([&] { give(*std::move(step->made)); });
    };
    tbb::parallel_pipeline(steps.size(), tbb::make_filter<void, Step*>(tbb::filter_mode::serial_in_order, taking) &
                                             tbb::make_filter<Step*, Step*>(tbb::filter_mode::parallel, making) &
                                             tbb::make_filter<Step*, void>(tbb::filter_mode::serial_in_order, giving));
    throwIfLeft();
}

/// Turns counts into places: returns n + 1 entries, the sums of all counts before each, then of all.
template <typename Count>
std::vector<Count> exclusiveScan(const std::vector<Count>& counts) {
    std::vector<Count> places(counts.size() + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), places.begin() + 1);
    return places;
}

}  // namespace betamesh
