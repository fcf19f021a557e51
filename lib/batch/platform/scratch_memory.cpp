
#include "batch/platform/scratch_memory.h"

#include "batch/job/places.h"
#include "batch/platform/huge_pages.h"
#include "batch/platform/machine.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/output_file.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <malloc.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>

namespace betamesh {
namespace {

constexpr std::size_t kLargeBlock = std::size_t{1} << 15;   // bytes
constexpr std::size_t kLargestFile = std::size_t{1} << 43;  // in addresses; the disk is asked for what is used
constexpr std::size_t kSmallestFile = std::size_t{1} << 28;
constexpr std::uint64_t kLeftOnDisk = std::uint64_t{64} << 20;  // for what the file system notes down, and for meshes
constexpr std::uint64_t kShareInMemory = 4;                     // of the budget: one in so many
constexpr std::uint64_t kMostReadAhead = 32;  // the same of what may be read at once, where it replaces as much
constexpr auto kTrimEvery = std::chrono::milliseconds(2);

/// errors  a folder that takes none
int fileWithoutName(const std::string& folder) {
    int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, 0600);
    if (file >= 0) return file;
    sweepTemporaries(folder);
    const OutputFile named(folder + "/scratch");  // not every file system can without; its name goes right away
    file = ::open(named.temporaryPath().c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) throw Error("'" + folder + "': " + std::strerror(errno));
    return file;
}

/// Makes what is written again need no other place, where the file system goes by that.
void writeInPlace(int file) {
    int flags = 0;
    if (::ioctl(file, FS_IOC_GETFLAGS, &flags) != 0) return;
    flags |= FS_NOCOW_FL;
    ::ioctl(file, FS_IOC_SETFLAGS, &flags);
}

/// Blocks in a file that is mapped whole: where a block is in the mapping it is in the file. Stays while the process
/// does, as blocks may.
class ScratchFile {
public:
    /// budget: as much of it as is to be at hand, bytes.
    ScratchFile(const std::string& folder, std::uint64_t budget)
        : file_(fileWithoutName(folder)), page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))) {
        rlimit longest{};
        ::getrlimit(RLIMIT_FSIZE, &longest);  // a longer file would be a signal
        int error = EFBIG;
        for (size_ = kLargestFile; size_ >= kSmallestFile; size_ /= 2) {
            if (size_ > longest.rlim_cur) continue;
            void* const begin = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
            error = errno;
            if (begin == MAP_FAILED) continue;
            writeInPlace(file_);
            ::madvise(begin, size_, MADV_DONTDUMP);
            if (readAhead(file_) > budget / kMostReadAhead) ::madvise(begin, size_, MADV_RANDOM);
            begin_ = static_cast<std::byte*>(begin);
            places_ = Places(size_);
            return;
        }
        ::close(file_);
        throw Error("'" + folder + "': a file of " + std::to_string(kSmallestFile >> 20) +
                    " MiB: " + std::strerror(error));
    }

    bool owns(const void* block) const { return block >= begin_ && block < begin_ + size_; }

    /// Null where there is no room. bytes > 0.
    void* allocate(std::size_t bytes, std::size_t alignment) {
        if (alignment > page_) return nullptr;
        std::call_once(memory_is_short_, returnFreedMemory);
        bytes = (bytes + page_ - 1) / page_ * page_;
        std::unique_lock lock(mutex_);
        const std::optional<std::size_t> place = places_.take(bytes);
        if (!place) return nullptr;
        in_use_ += bytes;
        lock.unlock();
        void* const block = begin_ + *place;
        if (!reserve(*place, bytes)) {
            release(block);
            return nullptr;
        }
        lock.lock();
        most_in_use_ = std::max(most_in_use_, in_use_);
        return block;
    }

    void release(void* block) noexcept {
        const auto place = static_cast<std::size_t>(static_cast<std::byte*>(block) - begin_);
        std::unique_lock lock(mutex_);
        const std::size_t bytes = places_.bytesAt(place);
        lock.unlock();
        // What nobody will read need not be written.
        ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place),
                    static_cast<off_t>(bytes));
        lock.lock();
        in_use_ -= bytes;
        places_.giveBack(place);
    }

    /// Lets go of all that is at hand; as it is touched it comes back, from the system's cache where it is there still.
    void trim() {
        const std::scoped_lock lock(mutex_);
        const auto [begin, end] = places_.used();
        if (begin < end) ::madvise(begin_ + begin, end - begin, MADV_DONTNEED);
    }

    std::uint64_t peak() {
        const std::scoped_lock lock(mutex_);
        return most_in_use_;
    }

private:
    /// Whether the disk has room for a block: to touch it would end the process where it has not, or not for what the
    /// file system notes down of it.
    bool reserve(std::size_t place, std::size_t bytes) const {
        int error = 0;
        do error = ::posix_fallocate(file_, static_cast<off_t>(place), static_cast<off_t>(bytes));
        while (error == EINTR);
        struct statvfs disk = {};
        return error == 0 && (::fstatvfs(file_, &disk) != 0 || disk.f_bavail * disk.f_frsize >= kLeftOnDisk);
    }

    int file_;
    std::size_t page_, size_ = 0;
    std::byte* begin_ = nullptr;
    std::once_flag memory_is_short_;
    std::mutex mutex_;  // guards what follows
    Places places_;
    std::uint64_t in_use_ = 0, most_in_use_ = 0;
};

std::atomic<ScratchFile*> scratch_file = nullptr;  // is never destroyed, as blocks may be freed last of all
std::atomic<std::uint64_t> in_memory = 0;          // of large blocks, bytes
std::atomic<std::uint64_t> most_in_memory = 0;     // before others go to the file; 0: they do not

void trimAbove(std::uint64_t most, const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    while (!stopped.wait_for(lock, stop, kTrimEvery, [&] { return stop.stop_requested(); })) {
        try {
            if (currentMemory() > most) scratch_file.load()->trim();
        } catch (const std::bad_alloc&) {  // there was not even room to ask
        }
    }
}

std::size_t countedBytes(void* block) {
    const std::size_t bytes = isHuge(block) ? bytesOfHuge(block) : ::malloc_usable_size(block);
    return bytes >= kLargeBlock ? bytes : 0;
}

}  // namespace

ScratchMemory::ScratchMemory(std::uint64_t budget, const std::string& folder) {
    const std::uint64_t most = currentMemory() + budget;
    try {
        if (scratch_file.load() == nullptr) scratch_file = new ScratchFile(folder, budget);
        trimming_ = std::jthread([most](const std::stop_token& stop) { trimAbove(most, stop); });
        most_in_memory = std::max<std::uint64_t>(1, budget / kShareInMemory);
    } catch (const std::exception& error) {
        logWarning(std::string(error.what()) + ": what has no room in memory cannot lie in a file there (run.scratch)");
    }
}

ScratchMemory::~ScratchMemory() { most_in_memory = 0; }

void* allocateMemory(std::size_t bytes, std::size_t alignment) {
    if (bytes > std::numeric_limits<std::ptrdiff_t>::max() - alignment) throw std::bad_alloc();
    bytes = std::max<std::size_t>(bytes, 1);
    const bool may_be_large = bytes + alignment >= kLargeBlock / 2;
    if (may_be_large) {
        const std::uint64_t most = most_in_memory;
        if (most > 0 && in_memory + bytes > most)
            if (void* const block = scratch_file.load()->allocate(bytes, alignment)) return block;
    }
    void* block = alignment <= kHugeAlignment ? takeHuge(bytes) : nullptr;
    if (block == nullptr)
        block = alignment <= alignof(std::max_align_t)
                    ? std::malloc(bytes)
                    : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (block == nullptr) throw std::bad_alloc();
    if (may_be_large) in_memory += countedBytes(block);
    return block;
}

void releaseMemory(void* block) noexcept {
    if (block == nullptr) return;
    ScratchFile* const file = scratch_file.load();
    if (file != nullptr && file->owns(block)) return file->release(block);
    if (const std::size_t bytes = countedBytes(block); bytes > 0) in_memory -= bytes;
    if (isHuge(block)) return giveBackHuge(block);
    std::free(block);
}

std::uint64_t peakScratch() {
    ScratchFile* const file = scratch_file.load();
    return file == nullptr ? 0 : file->peak();
}

}  // namespace betamesh
