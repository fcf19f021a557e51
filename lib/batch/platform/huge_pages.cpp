
#include "batch/platform/huge_pages.h"

#include "base/parallel.h"
#include "batch/job/places.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <ctime>
#include <mutex>

namespace betamesh {
namespace {

constexpr std::size_t kSmallestBlock = std::size_t{1} << 13;
constexpr std::size_t kWorthIt = std::size_t{1} << 18;   // of such blocks in all, before there are huge pages for them
constexpr std::size_t kHugePage = std::size_t{1} << 21;  // where others are of 4 KiB
constexpr std::size_t kSmallPage = std::size_t{1} << 12;
constexpr int kDearInARow = 2;                       // huge pages, before there are no more
constexpr std::size_t kStep = std::size_t{1} << 24;  // by which what may be used grows
constexpr std::size_t kMost = std::size_t{1} << 40;  // in addresses
constexpr std::size_t kLeast = std::size_t{1} << 32;

std::size_t roundedUp(std::size_t bytes, std::size_t unit) { return (bytes + unit - 1) / unit * unit; }

/// What the system calls a huge page, bytes; 0 where it has none.
std::size_t hugePageHere() {
    const int file = ::open("/sys/kernel/mm/transparent_hugepage/hpage_pmd_size", O_RDONLY | O_CLOEXEC);
    if (file < 0) return 0;
    std::array<char, 32> text{};  // no stream: that takes memory
    const ssize_t length = ::read(file, text.data(), text.size());
    ::close(file);
    std::size_t bytes = 0;
    if (length > 0) std::from_chars(text.data(), text.data() + length, bytes);
    return bytes;
}

/// Seconds that it takes to touch a page for the first time; other threads' time does not count.
double timeOfTouching(std::byte* page) {
    std::timespec before{}, after{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
    *static_cast<volatile std::byte*>(page) = std::byte{0};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
    return static_cast<double>(after.tv_sec - before.tv_sec) +
           1e-9 * static_cast<double>(after.tv_nsec - before.tv_nsec);
}

/// Of some small pages, a quarter of which take less; 0 where none can be had.
double costOfSmallPage() {
    constexpr std::size_t kPages = 16;
    void* const pages =
        ::mmap(nullptr, kPages * kSmallPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) return 0;
    std::array<double, kPages> cost;
    for (std::size_t p = 0; p < kPages; ++p) cost[p] = timeOfTouching(static_cast<std::byte*>(pages) + p * kSmallPage);
    ::munmap(pages, kPages * kSmallPage);
    std::nth_element(cost.begin(), cost.begin() + kPages / 4, cost.end());
    return cost[kPages / 4];
}

/// Blocks in a range of addresses that was asked for at once, and is opened as far as it is used: what is open counts
/// as the process's data. Stays while the process does, as blocks may.
class HugePages {
public:
    HugePages() {
        rlimit addresses{};
        if (::getrlimit(RLIMIT_AS, &addresses) != 0 || addresses.rlim_cur != RLIM_INFINITY) return;
        if (hugePageHere() != kHugePage) return;  // half a gigabyte, where pages are large, is too much
        for (std::size_t size = kMost; size >= kLeast; size /= 2) {
            void* const begin = ::mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
            if (begin == MAP_FAILED) continue;
            const auto address = reinterpret_cast<std::uintptr_t>(begin);
            const std::size_t before = roundedUp(address, kHugePage) - address;
            auto* const first = static_cast<std::byte*>(begin) + before;
            const std::size_t rest = size - roundedUp(before, kHugePage);
            if (::madvise(first, rest, MADV_HUGEPAGE) == 0) {
                begin_ = first;
                size_ = rest;
                places_ = Places(size_);
                as_many_small_ = kHugePage / kSmallPage * costOfSmallPage();
            } else {
                ::munmap(begin, size);
            }
            return;
        }
    }

    bool owns(const void* block) const { return block >= begin_ && block < begin_ + size_; }

    void* take(std::size_t bytes) {
        const std::size_t whole = roundedUp(bytes, kHugeAlignment);
        std::unique_lock lock(mutex_);
        const auto place = places_.take(whole);
        if (!place) return nullptr;
        if (!open(*place + whole)) {
            places_.giveBack(*place);
            return nullptr;
        }
        const std::size_t first = std::max(taken_, roundedUp(*place, kHugePage)),
                          end = roundedUp(*place + whole, kHugePage);
        taken_ = std::max(taken_, end);
        lock.unlock();
        touch(first, end);
        return begin_ + *place;
    }

    std::size_t bytesOf(const void* block) {
        const std::scoped_lock lock(mutex_);
        return places_.bytesAt(placeOf(block));
    }

    void giveBack(void* block, bool keep) {
        const std::scoped_lock lock(mutex_);
        const Places::Span gap = places_.giveBack(placeOf(block));
        if (!keep) release(gap);
    }

    /// On all threads, as the system takes long for it.
    void releaseGaps() {
        constexpr std::size_t kPiece = 4 * kHugePage;
        const std::scoped_lock lock(mutex_);
        runIsolated([&] {
            parallelFor((taken_ + kPiece - 1) / kPiece, 1, [&](std::size_t piece) {
                const std::size_t begin = piece * kPiece, end = begin + kPiece;
                const auto& gaps = places_.gaps();
                auto gap = gaps.upper_bound(begin);  // the first that begins later
                if (gap != gaps.begin()) --gap;
                for (; gap != gaps.end() && gap->first < end; ++gap)
                    release({std::max(gap->first, begin), std::min(gap->first + gap->second, end)});
            });
        });
    }

private:
    std::size_t placeOf(const void* block) const {
        return static_cast<std::size_t>(static_cast<const std::byte*>(block) - begin_);
    }
    bool open(std::size_t end) {
        if (end <= open_) return true;
        end = std::min(roundedUp(end, kStep), size_);
        if (::mprotect(begin_ + open_, end - open_, PROT_READ | PROT_WRITE) != 0) return false;
        open_ = end;
        return true;
    }
    /// Huge pages are touched as they are taken, each by the thread whose block its first byte is in, until some in a
    /// row take longer than as many small ones would: from there on they are small.
    void touch(std::size_t first, std::size_t end) {
        for (std::size_t page = first; page < end && !are_small_; page += kHugePage) {
            const bool is_dear = timeOfTouching(begin_ + page) > as_many_small_;
            const int in_a_row = is_dear ? ++dear_in_a_row_ : (dear_in_a_row_ = 0);
            if (in_a_row < kDearInARow || are_small_.exchange(true)) continue;
            const std::size_t next = page + kHugePage;
            ::madvise(begin_ + next, size_ - next, MADV_NOHUGEPAGE);
        }
    }
    /// Whole pages alone: of others the system would keep the rest as it is.
    void release(const Places::Span& gap) {
        const std::size_t begin = roundedUp(gap.begin, kHugePage),
                          end = std::min(gap.end, open_) / kHugePage * kHugePage;
        if (begin < end) ::madvise(begin_ + begin, end - begin, MADV_DONTNEED);
    }

    std::byte* begin_ = nullptr;
    std::size_t size_ = 0;
    std::mutex mutex_;  // guards the next three
    Places places_;
    std::size_t open_ = 0;
    std::size_t taken_ = 0;  // pages up to here

    double as_many_small_ = 0;  // seconds
    std::atomic<int> dear_in_a_row_ = 0;
    std::atomic<bool> are_small_ = false;
};

std::atomic<HugePages*> huge_pages = nullptr;  // is never destroyed, as blocks may be given back last of all
std::atomic<bool> in_use = false;
std::atomic<std::size_t> asked_before = 0;  // bytes

}  // namespace

void useHugePages() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which look after what they give themselves
    if (huge_pages.load() == nullptr) huge_pages = new HugePages;
    in_use = true;
#endif
}

void releaseFreeHugePages() {
    if (HugePages* const pages = huge_pages.load()) pages->releaseGaps();
}

void leaveHugePages() {
    if (in_use.exchange(false)) releaseFreeHugePages();
}

void* takeHuge(std::size_t bytes) {
    if (bytes < kSmallestBlock || !in_use) return nullptr;
    if (asked_before < kWorthIt && asked_before.fetch_add(bytes) + bytes < kWorthIt) return nullptr;
    return huge_pages.load()->take(bytes);
}

bool isHuge(const void* block) {
    const HugePages* const pages = huge_pages.load();
    return pages != nullptr && pages->owns(block);
}

std::size_t bytesOfHuge(const void* block) { return huge_pages.load()->bytesOf(block); }

void giveBackHuge(void* block) noexcept { huge_pages.load()->giveBack(block, in_use); }

}  // namespace betamesh
