
#include "io/bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace betamesh {

namespace {

/// Why a file with this mode cannot be read as a whole; empty if it is a regular file or a folder.
std::string whyNotRegular(mode_t mode) {
    if (S_ISREG(mode) || S_ISDIR(mode)) return "";
    const std::string kind = S_ISFIFO(mode)                   ? "a FIFO (named pipe)"
                             : S_ISSOCK(mode)                 ? "a socket"
                             : S_ISCHR(mode) || S_ISBLK(mode) ? "a device"
                                                              : "a special file";
    return "this is " + kind + ". Use a regular file";
}

[[noreturn]] void failReading(const std::filesystem::path& path, int error_number) {
    throw FileError(path.string() + ": cannot be read: " + std::generic_category().message(error_number), error_number);
}

// A file that is read, not mapped: if a mapped file shrinks, the process gets a signal and ends.
class File {
public:
    explicit File(const std::filesystem::path& path)
        : path_(path), number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {  // else a FIFO would block
        const int error_number = errno;
        if (number_ < 0) requireRegularFile(path);  // sockets cannot even be opened
        if (number_ < 0) failReading(path, error_number);
        struct stat status = {};
        if (::fstat(number_, &status) != 0) failReading(path, errno);
        if (S_ISDIR(status.st_mode)) failReading(path, EISDIR);
        if (const std::string why = whyNotRegular(status.st_mode); !why.empty())
            throw Error(path.string() + ": " + why);
        size_ = static_cast<std::uint64_t>(status.st_size);
    }
    ~File() {
        if (number_ >= 0) ::close(number_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    std::uint64_t size() const { return size_; }
    std::size_t read(std::byte* to, std::size_t count) {
        for (;;) {
            const ssize_t got = ::read(number_, to, count);
            if (got >= 0) return static_cast<std::size_t>(got);
            if (errno != EINTR) failReading(path_, errno);
        }
    }

private:
    std::filesystem::path path_;
    int number_;
    std::uint64_t size_ = 0;
};

}  // namespace

void Cursor::fetch(std::size_t count) {
    constexpr std::uint64_t kBlock = std::uint64_t{1} << 18;
    if (!source_) return;
    std::size_t kept = bytes_.size() - at_;
    if (kept > 0) std::memmove(buffer_.data(), bytes_.data() + at_, kept);
    before_ += std::exchange(at_, 0);
    const auto block = static_cast<std::size_t>(std::min(kBlock, size_ - before_));
    buffer_.resize(std::max({count, block, buffer_.size()}));
    while (kept < count) {
        const std::size_t got = source_(buffer_.data() + kept, buffer_.size() - kept);
        kept += got;
        if (got > 0) continue;
        size_ = before_ + kept;
        source_ = nullptr;
        break;
    }
    bytes_ = std::span(buffer_).first(kept);
}

Cursor openFile(const std::filesystem::path& path) {
    const auto file = std::make_shared<File>(path);
    const auto read = [file](std::byte* to, std::size_t count) { return file->read(to, count); };
    return {read, file->size(), path.string()};
}

std::string whyNotRegular(const std::filesystem::path& path) {
    struct stat status = {};
    return ::stat(path.c_str(), &status) == 0 ? whyNotRegular(status.st_mode) : "";
}

void requireRegularFile(const std::filesystem::path& path) {
    if (const std::string why = whyNotRegular(path); !why.empty()) throw Error(path.string() + ": " + why);
}

Bytes readWholeFile(const std::filesystem::path& path) {
    File file(path);
    Bytes bytes(static_cast<std::size_t>(file.size()));
    std::size_t done = 0;
    while (done < bytes.size()) {
        const std::size_t got = file.read(bytes.data() + done, bytes.size() - done);
        if (got == 0) break;
        done += got;
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace betamesh
