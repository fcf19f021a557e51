
#include "batch/platform/frame_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".betamesh-lock";
constexpr std::size_t kMostStem = 200;  // bytes; longer names that are equal up to there share a lock
constexpr auto kLockPoll = std::chrono::milliseconds(10);

enum class Attempt {
    locked,
    taken,      ///< another process or thread has the lock
    gone,       ///< the previous owner has removed the file: try again
    impossible  ///< the file system has no locks
};

Attempt tryLock(int file, const fs::path& path) {
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) return errno == EWOULDBLOCK ? Attempt::taken : Attempt::impossible;
    struct stat ours = {};
    struct stat named = {};
    const bool same = ::fstat(file, &ours) == 0 && ::stat(path.c_str(), &named) == 0 && ours.st_ino == named.st_ino &&
                      ours.st_dev == named.st_dev;
    return same ? Attempt::locked : Attempt::gone;
}

}  // namespace

FrameLock::FrameLock(const fs::path& output, const std::function<void()>& whileWaiting)
    : path_(output.parent_path() / ('.' + output.filename().string().substr(0, kMostStem) + kSuffix)) {
    for (;;) {
        file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (file_ < 0) return;
        const Attempt attempt = tryLock(file_, path_);
        if (attempt == Attempt::locked || attempt == Attempt::impossible) return;
        ::close(file_);
        file_ = -1;
        if (attempt == Attempt::gone) continue;
        std::this_thread::sleep_for(kLockPoll);
        whileWaiting();
    }
}

FrameLock::~FrameLock() {
    if (file_ < 0) return;
    ::unlink(path_.c_str());  // before unlocking, so that nobody else locks a file that has no name any more
    ::close(file_);
}

void sweepLocks(const fs::path& folder) {
    std::vector<fs::path> locks;
    std::error_code error;
    for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (name.starts_with('.') && name.ends_with(kSuffix)) locks.push_back(entry->path());
    }
    for (const fs::path& lock : locks) {
        const int file = ::open(lock.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
        if (file < 0) continue;
        if (tryLock(file, lock) == Attempt::locked) ::unlink(lock.c_str());
        ::close(file);
    }
}

}  // namespace betamesh
