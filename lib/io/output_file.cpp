
#include "io/output_file.h"

#include "betamesh/error.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace betamesh {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".betamesh-tmp";
constexpr std::size_t kMaxNameBytes = 255;                    // of a file name, on every file system in use
constexpr std::size_t kStartFlushing = std::size_t{1} << 19;  // bytes after which the disk is set to work
constexpr auto kForeignAge = std::chrono::hours(24);

/// This host as a word without dots. Containers may share a name, hence the process number space too.
std::string hostWord() {
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    std::string word(name.data());
    for (char& c : word)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
    struct stat status = {};
    if (::stat("/proc/self/ns/pid", &status) == 0) word += "-" + std::to_string(status.st_ino);
    return word;
}

/// When a process began, in clock ticks after the machine did; tells it from a later one of the same number.
std::string startOf(pid_t pid) {
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string line;
    std::getline(file, line);
    const std::size_t end_of_name = line.rfind(')');  // the name may hold anything
    if (end_of_name == std::string::npos) return "0";
    std::istringstream fields(line.substr(end_of_name + 1));
    std::string field;
    for (int i = 3; i <= 22 && fields >> field; ++i)
        if (field == "Z") return "0";  // has ended, and nobody has asked how
    return field;
}

std::string writerWord() { return hostWord() + "." + std::to_string(::getpid()) + "." + startOf(::getpid()); }

fs::path temporaryFor(const fs::path& final_path) {
    static std::atomic<unsigned> counter{0};
    const std::string tail = "." + writerWord() + "." + std::to_string(counter++) + std::string(kSuffix);
    std::string name = final_path.filename().string();
    name.resize(std::min(name.size(), kMaxNameBytes - std::min(kMaxNameBytes, tail.size() + 1)));
    return final_path.parent_path() / ("." + name + tail);
}

struct Writer {
    std::string host;
    pid_t pid = 0;
    std::string start;
};

/// Who wrote a temporary, from its name: .<name>.<host>.<pid>.<start>.<number>.betamesh-tmp
std::optional<Writer> writerOf(const std::string& file_name) {
    if (!file_name.starts_with('.') || !file_name.ends_with(kSuffix)) return std::nullopt;
    std::string rest = file_name.substr(1, file_name.size() - 1 - kSuffix.size());
    std::vector<std::string> fields;
    for (int i = 0; i < 4; ++i) {
        const std::size_t dot = rest.rfind('.');
        if (dot == std::string::npos) return std::nullopt;
        fields.push_back(rest.substr(dot + 1));
        rest.resize(dot);
    }
    Writer writer{fields[3], 0, fields[1]};
    const std::string& pid = fields[2];
    const auto [stop, error] = std::from_chars(pid.data(), pid.data() + pid.size(), writer.pid);
    if (error != std::errc() || stop != pid.data() + pid.size() || writer.pid <= 0) return std::nullopt;
    return writer;
}

bool lives(const Writer& writer) {
    if (::kill(writer.pid, 0) != 0 && errno == ESRCH) return false;
    return startOf(writer.pid) == writer.start;
}

/// A writer holds a lock until it ends, however it ends; network file systems know of it too.
bool isLocked(const fs::path& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) return true;
    const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ::close(file);
    return locked;
}

bool isOld(const fs::path& path) {
    std::error_code error;
    const auto written = fs::last_write_time(path, error);
    return !error && fs::file_time_type::clock::now() - written > kForeignAge;
}

}  // namespace

OutputFile::OutputFile(fs::path final_path)
    : final_path_(std::move(final_path)), temporary_path_(temporaryFor(final_path_)) {
    std::error_code ignored;  // whatever keeps it from being looked at, opening it will tell
    if (final_path_.filename().empty() || fs::is_directory(final_path_, ignored)) fail("written", EISDIR);
    file_ = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) fail("written", errno);
    ::flock(file_, LOCK_EX | LOCK_NB);  // where locks do not work, the process number must do
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : final_path_(std::move(other.final_path_)),
      temporary_path_(std::move(other.temporary_path_)),
      file_(std::exchange(other.file_, -1)),
      waiting_(other.waiting_) {}

OutputFile::~OutputFile() {
    if (file_ < 0) return;
    ::unlink(temporary_path_.c_str());
    ::close(file_);
}

void OutputFile::fail(const char* doing, int error_number) const {
    throw Error(final_path_.string() + ": cannot be " + doing + ": " + std::generic_category().message(error_number));
}

void OutputFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(file_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail("written", errno);
        bytes = bytes.subspan(static_cast<std::size_t>(count));
        waiting_ += static_cast<std::size_t>(count);
    }
    if (waiting_ < kStartFlushing) return;
    waiting_ = 0;
    ::sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE);  // only a hint: commit() waits, and tells of failures
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text.data(), text.size()))); }

void OutputFile::commit() {
    if (::fsync(file_) != 0) fail("flushed to the disk", errno);
    if (::rename(temporary_path_.c_str(), final_path_.c_str()) != 0) fail("given its name", errno);
    const int file = file_;
    file_ = -1;
    if (::close(file) != 0 && errno != EINTR) fail("closed", errno);
    // The name itself reaches the disk with the folder. Some file systems cannot flush one; the file is safe.
    const fs::path folder = final_path_.parent_path();
    const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    ::fsync(descriptor);
    ::close(descriptor);
}

void writeFile(const fs::path& path, std::string_view text) {
    OutputFile file(path);
    file.write(text);
    file.commit();
}

void sweepTemporaries(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> leftovers;
    for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end;
         entry.increment(error))
        if (writerOf(entry->path().filename().string())) leftovers.push_back(entry->path());
    const std::string host = hostWord();
    for (const fs::path& path : leftovers) {
        const Writer writer = *writerOf(path.filename().string());
        const bool gone = writer.host == host ? !lives(writer) : isOld(path);
        if (gone && !isLocked(path)) fs::remove(path, error);
    }
}

}  // namespace betamesh
