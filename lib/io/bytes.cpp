#include "io/bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace betamesh {

namespace {

[[noreturn]] void failReading(const std::filesystem::path& path, int error_number) {
    throw Error(path.string() + ": cannot be read: " + std::generic_category().message(error_number));
}

struct Descriptor {
    int number;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

}  // namespace

// Read, not mapped: a file that shrinks while it is mapped ends the process.
Bytes readWholeFile(const std::filesystem::path& path) {
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.number < 0) failReading(path, errno);
    struct stat status = {};
    if (::fstat(file.number, &status) != 0) failReading(path, errno);
    if (S_ISDIR(status.st_mode)) failReading(path, EISDIR);
    if (!S_ISREG(status.st_mode)) throw Error(path.string() + ": cannot be read: expected a regular file");

    Bytes bytes(static_cast<std::size_t>(status.st_size));
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::read(file.number, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) failReading(path, errno);
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace betamesh
