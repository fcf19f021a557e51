// A lock on the output files of a frame, between threads, processes and hosts.

#pragma once

#include <filesystem>
#include <functional>

namespace betamesh {

/// At most one FrameLock exists per output, among all processes on this host, and on other hosts if the file system
/// supports locks. It is a hidden file beside the output, which the destructor removes. If that file cannot be created
/// or locked there is no lock, and the error is left to whoever writes the output.
class FrameLock {
public:
    /// Waits for the lock. Calls whileWaiting() repeatedly meanwhile, which may throw to give up.
    FrameLock(const std::filesystem::path& output, const std::function<void()>& whileWaiting);
    ~FrameLock();
    FrameLock(const FrameLock&) = delete;
    FrameLock& operator=(const FrameLock&) = delete;

private:
    std::filesystem::path path_;
    int file_ = -1;
};

/// Removes the locks in a folder that killed processes have left. Locks that are held stay.
void sweepLocks(const std::filesystem::path& folder);

}  // namespace betamesh
