// The wrapper of oneTBB: every parallel loop goes through these functions.

#pragma once

#include "base/tsan_fork_join.h"

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

/// The number of threads that loops started here may use, approximately.
inline std::size_t threadsHere() { return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()); }

/// Thrown by an inner loop that TBB cancelled because the loop around it has failed: its result is incomplete and must
/// not be used. The outer loop ends with the exception that made it fail.
struct LoopCancelled {};
inline void throwIfCancelled() {
    if (tbb::is_current_task_group_canceling()) throw LoopCancelled();
}

/// Calls body(begin, end) for ranges that cover [0, n) exactly once. A body writes only its own rows, so the result is
/// the same for any number of threads. grain: the smallest range worth a task.
template <typename Body>
void parallelRanges(std::size_t n, std::size_t grain, const Body& body) {
    if (n <= grain) {
        if (n > 0) body(std::size_t{0}, n);
        return;
    }
    TsanForkJoin loop;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& range) {
        const TsanForkJoin::Branch branch(loop);
        body(range.begin(), range.end());
    });
    throwIfCancelled();
}

/// Calls body(i) for every i in [0, n).
template <typename Body>
void parallelFor(std::size_t n, std::size_t grain, const Body& body) {
    parallelRanges(n, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// The number of equal shares into which n rows are split where each share needs memory of its own: one per thread, at
/// most eight, each of at least 1024 rows.
inline std::size_t sharesOf(std::size_t n) {
    constexpr std::size_t kLeastRows = 1024, kMostShares = 8;
    return std::clamp<std::size_t>(std::min(threadsHere(), n / kLeastRows), 1, kMostShares);
}

/// Calls body(share, begin, end) for each of the sharesOf(n) shares of [0, n), in any order.
template <typename Body>
void parallelShares(std::size_t n, const Body& body) {
    const std::size_t shares = sharesOf(n);
    parallelFor(shares, 1, [&](std::size_t share) { body(share, n * share / shares, n * (share + 1) / shares); });
}

/// Calls body(begin, end, part) for ranges of rows_per_part rows that cover [0, n), the last of which may be shorter,
/// in any order. Returns the parts, in the order of the ranges: the same for any number of threads.
template <typename Part, typename Body>
std::vector<Part> parallelParts(std::size_t n, std::size_t rows_per_part, const Body& body) {
    std::vector<Part> parts((n + rows_per_part - 1) / rows_per_part);
    parallelFor(parts.size(), 1,
                [&](std::size_t p) { body(p * rows_per_part, std::min(n, (p + 1) * rows_per_part), parts[p]); });
    return parts;
}

/// Calls body() as an isolated task: while its thread waits for loops inside body, it starts no unrelated task. So body
/// may hold a lock.
template <typename Body>
void runIsolated(const Body& body) {
    tbb::this_task_arena::isolate(body);
}

/// Calls both functions, concurrently if a second thread is available.
template <typename First, typename Second>
void parallelBoth(const First& first, const Second& second) {
    parallelFor(2, 1, [&](std::size_t i) {
        if (i == 0)
            first();
        else
            second();
    });
}

/// As rows.reserve(n). The system maps memory page by page on first touch, which takes longer than filling it, so all
/// threads touch the new pages in parallel.
template <typename T>
void firstTouchReserve(std::vector<T>& rows, std::size_t n) {
    constexpr std::size_t kPage = 4096;
    if (n <= rows.capacity()) return;
    rows.reserve(n);
    auto* const begin = reinterpret_cast<volatile unsigned char*>(rows.data() + rows.size());
    const std::size_t bytes = (n - rows.size()) * sizeof(T);
    parallelFor((bytes + kPage - 1) / kPage, 64, [&](std::size_t page) { begin[page * kPage] = 0; });
}

/// As rows.resize(n), with memory from firstTouchReserve().
template <typename T>
void firstTouchResize(std::vector<T>& rows, std::size_t n) {
    firstTouchReserve(rows, n);
    rows.resize(n);
}

/// The concatenated vectors of all parts. vectorOf(part): the vector, usually a member pointer; by default the part
/// itself.
template <typename Part, typename VectorOf = std::identity>
auto concatenate(const std::vector<Part>& parts, const VectorOf& vectorOf = {}) {
    std::vector<std::size_t> first(parts.size() + 1, 0);
    for (std::size_t p = 0; p < parts.size(); ++p) first[p + 1] = first[p] + std::invoke(vectorOf, parts[p]).size();
    std::remove_cvref_t<std::invoke_result_t<VectorOf, const Part&>> rows;
    firstTouchResize(rows, first.back());
    parallelFor(parts.size(), 1, [&](std::size_t p) {
        const auto& part = std::invoke(vectorOf, parts[p]);
        std::copy(part.begin(), part.end(), rows.begin() + static_cast<std::ptrdiff_t>(first[p]));
    });
    return rows;
}

/// The indices i of [0, n) for which holds(i), ascending.
template <typename Predicate>
std::vector<std::uint32_t> indicesWhere(std::size_t n, const Predicate& holds) {
    using Indices = std::vector<std::uint32_t>;
    return concatenate(parallelParts<Indices>(n, 16384, [&](std::size_t begin, std::size_t end, Indices& rows) {
        for (std::size_t i = begin; i < end; ++i)
            if (holds(static_cast<std::uint32_t>(i))) rows.push_back(static_cast<std::uint32_t>(i));
    }));
}

/// The number of indices i of [0, n) for which holds(i).
template <typename Predicate>
std::size_t countWhere(std::size_t n, const Predicate& holds) {
    std::atomic<std::size_t> count = 0;
    parallelRanges(n, 16384, [&](std::size_t begin, std::size_t end) {
        std::size_t in_range = 0;
        for (std::size_t i = begin; i < end; ++i) in_range += holds(static_cast<std::uint32_t>(i));
        count += in_range;
    });
    return count;
}

/// The first index i of [0, n) for which holds(i), or n. holds() is evaluated for whole ranges without branching, so it
/// is vectorised if it has no branches itself.
template <typename Predicate>
std::size_t firstIndexWhere(std::size_t n, const Predicate& holds) {
    constexpr std::size_t kRowsPerTask = 16384;
    std::atomic<std::size_t> first = n;
    parallelRanges(n, kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        bool any = false;
        for (std::size_t i = begin; i < end; ++i) any |= holds(i);
        if (!any) return;
        while (!holds(begin)) ++begin;
        for (std::size_t least = first; begin < least && !first.compare_exchange_weak(least, begin);) {
        }
    });
    return first;
}

/// Sorts by a strict total order, so that the result is the same for any number of threads.
template <typename T, typename Less>
void parallelSort(std::vector<T>& rows, const Less& less) {
#if defined(__SANITIZE_THREAD__)
    std::sort(rows.begin(), rows.end(), less);  // TBB's sort hands ranges between threads without annotations
#else
    tbb::parallel_sort(rows.begin(), rows.end(), less);
    throwIfCancelled();
#endif
}

/// Runs work whose parallel loops, and those inside them, another thread can cancel.
class CancellableRun {
public:
    /// May be called from any thread, at any time: before run(), too. A loop that is being executed ends soon, and no
    /// further one begins; work between loops goes on until the next one.
    void cancel() { context_.cancel_group_execution(); }

    /// Calls body(), with at most `threads` threads, the calling one included; 0: as many as there are processors. Does
    /// not limit loops of other threads. Returns whether body() has returned; false if it was cancelled. Passes on
    /// what else body() throws.
    template <typename Body>
    bool run(int threads, const Body& body) {
        bool has_returned = false;
        std::exception_ptr failure;  // TBB drops exceptions of a cancelled loop
        const auto runBody = [&](int) {
            try {
                body();
                has_returned = true;
            } catch (const LoopCancelled&) {
            } catch (...) {
                failure = std::current_exception();
            }
        };
        TsanForkJoin loop;
        tbb::task_arena(threads > 0 ? threads : tbb::task_arena::automatic).execute([&] {
            tbb::parallel_for(
                0, 1,
                [&](int i) {
                    const TsanForkJoin::Branch branch(loop);
                    runBody(i);
                },
                tbb::simple_partitioner(), context_);
        });
        if (failure) std::rethrow_exception(failure);
        return has_returned;
    }

private:
    tbb::task_group_context context_{tbb::task_group_context::isolated};
};

/// Runs body() with at most `threads` >= 1 threads, its own included, for all loops that it starts.
template <typename Body>
void withThreads(int threads, const Body& body) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena(threads).execute(body);
}

/// Starts the threads that withThreads(threads) will use, so that none has to be created later, when memory may be
/// short. Waits for them at most half a second.
inline void startThreads(int threads) {
    std::atomic<int> arrived = 0;
    const auto latest = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    TsanForkJoin loop;
    tbb::parallel_for(
        0, threads,
        [&](int) {
            const TsanForkJoin::Branch branch(loop);
            ++arrived;
            while (arrived < threads && std::chrono::steady_clock::now() < latest) std::this_thread::yield();
        },
        tbb::simple_partitioner());
}

/// Calls body(i) for i = 0, 1 … n - 1, started in this order, with at most in_flight >= 1 of them running at once.
/// Starts no further one once goOn() is false. Bodies may use parallel loops; a thread that waits for such a loop
/// starts no other body.
template <typename GoOn, typename Body>
void parallelInFlight(std::size_t n, std::size_t in_flight, const GoOn& goOn, const Body& body) {
    std::size_t next = 0;
    TsanForkJoin loop;
    const auto take = [&](tbb::flow_control& control) {
        const TsanForkJoin::OrderedBranch branch(loop);
        if (next == n || !goOn()) control.stop();
        return next++;
    };
    const auto work = [&](std::size_t i) {
        const TsanForkJoin::Branch branch(loop);
        runIsolated([&] { body(i); });
    };
    tbb::parallel_pipeline(in_flight, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
                                          tbb::make_filter<std::size_t, void>(tbb::filter_mode::parallel, work));
}

/// An ordered pipeline. take() gives the next item, an empty optional at the end; make(item) turns items into results,
/// several at once; give(result) is called for one result after another, in the order of the items. Ends with the first
/// exception of any of the three, in the order of the items.
template <typename Take, typename Make, typename Give>
void parallelInOrder(const Take& take, const Make& make, const Give& give) {
    struct Step {
        std::invoke_result_t<Take> item;
        std::optional<std::invoke_result_t<Make, typename decltype(item)::value_type&&>> made;
        std::exception_ptr failure;
    };
    std::vector<Step> steps(2 * threadsHere());  // a ring buffer of the items in flight
    std::size_t next = 0;
    bool ended = false;
    TsanForkJoin loop;
    const auto taking = [&](tbb::flow_control& control) {
        const TsanForkJoin::OrderedBranch branch(loop);
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
        const TsanForkJoin::OrderedBranch branch(loop);
        try {
            if (step->item) step->made = make(*std::move(step->item));
        } catch (...) {
            step->failure = std::current_exception();
        }
        return step;
    };
    const auto giving = [&](Step* step) {
        const TsanForkJoin::OrderedBranch branch(loop);
        if (step->failure) std::rethrow_exception(step->failure);
        runIsolated([&] { give(*std::move(step->made)); });
    };
    tbb::parallel_pipeline(steps.size(), tbb::make_filter<void, Step*>(tbb::filter_mode::serial_in_order, taking) &
                                             tbb::make_filter<Step*, Step*>(tbb::filter_mode::parallel, making) &
                                             tbb::make_filter<Step*, void>(tbb::filter_mode::serial_in_order, giving));
    throwIfCancelled();
}

/// The exclusive prefix sums of n counts: n + 1 entries, of which the last is the sum of all counts. With counts of
/// items per row, entry i is the position of row i's first item.
template <typename Count>
std::vector<Count> exclusiveScan(const std::vector<Count>& counts) {
    std::vector<Count> sums(counts.size() + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), sums.begin() + 1);
    return sums;
}

}  // namespace betamesh
