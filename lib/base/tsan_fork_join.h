// Happens-before annotations for ThreadSanitizer, which cannot see the synchronisation inside libtbb, because libtbb is
// not compiled with it.

#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>

#include <cstddef>
#endif

namespace betamesh {

/// Annotates one parallel loop: its constructor happens before every Branch, and every Branch before its destructor,
/// also when the loop ends with an exception. Branches stay unordered among themselves, so races between them are
/// still found. Does nothing in builds without ThreadSanitizer.
class TsanForkJoin {
public:
    TsanForkJoin() { release(&begun_); }
    ~TsanForkJoin() {
        acquire(&ended_);
        acquireBelow(static_cast<char*>(__builtin_frame_address(0)));
    }
    TsanForkJoin(const TsanForkJoin&) = delete;
    TsanForkJoin& operator=(const TsanForkJoin&) = delete;

    /// Lives as long as one branch of the loop.
    class Branch {
    public:
        explicit Branch(TsanForkJoin& loop) : loop_(loop) { acquire(&loop_.begun_); }
        ~Branch() { release(&loop_.ended_); }
        Branch(const Branch&) = delete;
        Branch& operator=(const Branch&) = delete;

    private:
        TsanForkJoin& loop_;
    };

    /// A branch that happens after all ordered branches of the loop that ended before it.
    class OrderedBranch {
    public:
        explicit OrderedBranch(TsanForkJoin& loop) : branch_(loop), loop_(loop) { acquire(&loop_.order_); }
        ~OrderedBranch() { release(&loop_.order_); }
        OrderedBranch(const OrderedBranch&) = delete;
        OrderedBranch& operator=(const OrderedBranch&) = delete;

    private:
        Branch branch_;
        TsanForkJoin& loop_;
    };

private:
#if defined(__SANITIZE_THREAD__)
    static void release(char* address) { __tsan_release(address); }
    static void acquire(char* address) { __tsan_acquire(address); }
    // TBB keeps the loop's own node on the stack below this frame. Other threads decrement its counter after their last
    // branch, which happens before any later use of that memory.
    static void acquireBelow(char* frame) {
        constexpr std::ptrdiff_t kBytes = 4096;
        for (std::ptrdiff_t i = -kBytes; i < 0; i += 4) acquire(frame + i);
    }
#else
    static void release(char*) {}
    static void acquire(char*) {}
    static void acquireBelow(char*) {}
#endif

    char begun_ = 0, ended_ = 0, order_ = 0;
};

}  // namespace betamesh
