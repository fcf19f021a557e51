// One writer at a time for the files of a frame, whichever process it is in.

#pragma once

#include <filesystem>
#include <functional>

namespace betamesh {

/// While it lives no other FrameLock of the same output does, in this process or another, on this host or, where the
/// file system knows of locks, another. It is a hidden file beside the output, gone at the end; where no such file can
/// be made or locked there is no lock, and writing the frame will tell.
class FrameLock {
public:
    /// Waits for its turn; meanwhile calls goOn() now and then, which may throw.
    FrameLock(const std::filesystem::path& output, const std::function<void()>& goOn);
    ~FrameLock();
    FrameLock(const FrameLock&) = delete;
    FrameLock& operator=(const FrameLock&) = delete;

private:
    std::filesystem::path path_;
    int file_ = -1;
};

/// Removes locks that ended processes left in a folder, none that is held.
void sweepLocks(const std::filesystem::path& folder);

}  // namespace betamesh
