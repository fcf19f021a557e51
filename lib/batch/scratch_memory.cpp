#include "batch/scratch_memory.h"

#include "batch/log.h"
#include "batch/machine.h"

#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <system_error>

namespace betamesh {
namespace {

constexpr std::size_t kLargeBlock = std::size_t{1} << 15;   // bytes
constexpr std::size_t kLargestFile = std::size_t{1} << 43;  // in addresses; the disk is asked for what is used
constexpr std::size_t kSmallestFile = std::size_t{1} << 28;
constexpr std::uint64_t kShareInMemory = 4;   // of the budget: one in so many
constexpr std::uint64_t kMostReadAhead = 32;  // the same of what may be read at once, where it replaces as much
constexpr auto kTrimEvery = std::chrono::milliseconds(2);

/// The first that goes, from the folder's point of view; -1 and errno where it takes none.
int fileWithoutName(const std::string& folder) {
    const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, 0600);
    if (file >= 0) return file;
    std::string name = folder + "/.betamesh-scratch-XXXXXX";  // not every file system can without
    const int named = ::mkostemp(name.data(), O_CLOEXEC);
    if (named >= 0) ::unlink(name.c_str());
    return named;
}

/// Blocks in a file that is mapped whole: where a block is in the mapping it is in the file. Stays while the process
/// does, as blocks may.
class ScratchFile {
public:
    /// budget: as much of it as is to be at hand, bytes.
    ScratchFile(const std::string& folder, std::uint64_t budget)
        : file_(fileWithoutName(folder)), page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))) {
        rlimit largest{};
        ::getrlimit(RLIMIT_FSIZE, &largest);  // a longer file would be a signal
        for (size_ = kLargestFile; file_ >= 0 && size_ >= kSmallestFile; size_ /= 2) {
            if (size_ > largest.rlim_cur || ::ftruncate(file_, static_cast<off_t>(size_)) != 0) continue;
            void* const begin = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
            if (begin == MAP_FAILED) continue;
            if (readAhead(file_) > budget / kMostReadAhead) ::madvise(begin, size_, MADV_RANDOM);
            begin_ = static_cast<std::byte*>(begin);
            free_[0] = size_;
            return;
        }
        const int error = file_ < 0 ? errno : EFBIG;
        if (file_ >= 0) ::close(file_);
        throw std::system_error(error, std::generic_category());
    }

    bool owns(const void* block) const { return block >= begin_ && block < begin_ + size_; }

    /// Begins with a page. Null where there is no room.
    void* allocate(std::size_t bytes) {
        bytes = (bytes + page_ - 1) / page_ * page_;
        std::call_once(memory_is_short_, returnFreedMemory);
        const std::size_t place = take(bytes);
        if (place == size_) return nullptr;
        void* const block = begin_ + place;
        // The disk's promise; without it, to touch the block would end the process where the disk is full.
        if (::posix_fallocate(file_, static_cast<off_t>(place), static_cast<off_t>(bytes)) == 0) return block;
        release(block);
        return nullptr;
    }

    void release(void* block) noexcept {
        const auto place = static_cast<std::size_t>(static_cast<std::byte*>(block) - begin_);
        std::unique_lock lock(mutex_);
        auto gap = used_.extract(place);
        const std::size_t bytes = gap.mapped();
        lock.unlock();
        // What nobody will read need not be written.
        ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place),
                    static_cast<off_t>(bytes));
        lock.lock();
        in_use_ -= bytes;
        const auto at = free_.insert(std::move(gap)).position;
        if (const auto next = std::next(at); next != free_.end() && next->first == place + bytes) {
            at->second += next->second;
            free_.erase(next);
        }
        if (at == free_.begin()) return;
        if (const auto before = std::prev(at); before->first + before->second == place) {
            before->second += at->second;
            free_.erase(at);
        }
    }

    /// Lets go of all that is at hand; as it is touched it comes back, from the system's cache where it is there still.
    void trim() {
        const std::scoped_lock lock(mutex_);
        if (used_.empty()) return;
        const std::size_t begin = used_.begin()->first, end = used_.rbegin()->first + used_.rbegin()->second;
        ::madvise(begin_ + begin, end - begin, MADV_DONTNEED);
    }

    std::uint64_t peak() {
        const std::scoped_lock lock(mutex_);
        return most_in_use_;
    }

private:
    /// The place of a block; size_ where there is no gap for it.
    std::size_t take(std::size_t bytes) {
        const std::scoped_lock lock(mutex_);
        const auto fits =
            std::find_if(free_.begin(), free_.end(), [&](const auto& gap) { return gap.second >= bytes; });
        if (fits == free_.end()) return size_;
        const auto [place, room] = *fits;
        used_.emplace(place, bytes);
        auto gap = free_.extract(fits);
        if (room > bytes) {
            gap.key() = place + bytes;
            gap.mapped() = room - bytes;
            free_.insert(std::move(gap));
        }
        in_use_ += bytes;
        most_in_use_ = std::max(most_in_use_, in_use_);
        return place;
    }

    int file_;
    std::size_t page_, size_ = 0;
    std::byte* begin_ = nullptr;
    std::once_flag memory_is_short_;
    std::mutex mutex_;                                // guards what follows
    std::map<std::size_t, std::size_t> free_, used_;  // places -> bytes
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
    const std::size_t bytes = ::malloc_usable_size(block);
    return bytes >= kLargeBlock ? bytes : 0;
}

}  // namespace

ScratchMemory::ScratchMemory(std::uint64_t budget, const std::string& folder) {
    const std::uint64_t most = currentMemory() + budget;
    try {
        if (scratch_file.load() == nullptr) scratch_file = new ScratchFile(folder, budget);
        trimming_ = std::jthread([most](const std::stop_token& stop) { trimAbove(most, stop); });
        most_in_memory = std::max<std::uint64_t>(1, budget / kShareInMemory);
    } catch (const std::system_error& error) {
        logWarning("'" + folder + "': " + error.code().message() +
                   ": what has no room in memory cannot lie in a file there (run.scratch)");
    }
}

ScratchMemory::~ScratchMemory() { most_in_memory = 0; }

void* allocateMemory(std::size_t bytes, std::size_t alignment) {
    if (bytes >= kLargeBlock / 2) {
        const std::uint64_t most = most_in_memory.load(std::memory_order_relaxed);
        if (most > 0 && in_memory.load(std::memory_order_relaxed) + bytes > most)
            if (void* const block = scratch_file.load()->allocate(bytes)) return block;
    }
    bytes = std::max<std::size_t>(bytes, 1);
    void* const block = alignment <= alignof(std::max_align_t)
                            ? std::malloc(bytes)
                            : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (block == nullptr) throw std::bad_alloc();
    if (bytes >= kLargeBlock / 2) in_memory += countedBytes(block);
    return block;
}

void releaseMemory(void* block) noexcept {
    if (block == nullptr) return;
    ScratchFile* const file = scratch_file.load();
    if (file != nullptr && file->owns(block)) return file->release(block);
    if (const std::size_t bytes = countedBytes(block); bytes > 0) in_memory -= bytes;
    std::free(block);
}

std::uint64_t peakScratch() {
    ScratchFile* const file = scratch_file.load();
    return file == nullptr ? 0 : file->peak();
}

}  // namespace betamesh
