// What ThreadSanitizer has to be told of loops that run on several cores, because libtbb is not compiled with it.

#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>

#include <cstddef>
#endif

namespace betamesh {

/// What came before the fork comes before each branch, and each branch before what follows the fork's end, be that an
/// exception. Branches stay unordered among themselves, so races between them are found. Nothing at all without the
/// sanitizer.
class Fork {
public:
    Fork() { release(&begun_); }
    ~Fork() {
        acquire(&ended_);
        acquireBelow(static_cast<char*>(__builtin_frame_address(0)));
    }
    Fork(const Fork&) = delete;
    Fork& operator=(const Fork&) = delete;

    /// Lives as long as one branch.
    class Branch {
    public:
        explicit Branch(Fork& fork) : fork_(fork) { acquire(&fork_.begun_); }
        ~Branch() { release(&fork_.ended_); }
        Branch(const Branch&) = delete;
        Branch& operator=(const Branch&) = delete;

    private:
        Fork& fork_;
    };

    /// A branch that comes after those of its kind that ended before.
    class Turn {
    public:
        explicit Turn(Fork& fork) : branch_(fork), fork_(fork) { acquire(&fork_.turn_); }
        ~Turn() { release(&fork_.turn_); }
        Turn(const Turn&) = delete;
        Turn& operator=(const Turn&) = delete;

    private:
        Branch branch_;
        Fork& fork_;
    };

private:
#if defined(__SANITIZE_THREAD__)
    static void release(char* what) { __tsan_release(what); }
    static void acquire(char* what) { __tsan_acquire(what); }
    // TBB's own node of the loop lay on the stack beneath. Other threads counted it down after their last branch, and
    // whoever uses that place next comes after them.
    static void acquireBelow(char* frame) {
        constexpr std::ptrdiff_t kBytes = 4096;
        for (std::ptrdiff_t i = -kBytes; i < 0; i += 4) acquire(frame + i);
    }
#else
    static void release(char*) {}
    static void acquire(char*) {}
    static void acquireBelow(char*) {}
#endif

    char begun_ = 0, ended_ = 0, turn_ = 0;
};

}  // namespace betamesh
