
#include "io/output_file.h"

#include "betamesh/error.h"
#include "io/bytes.h"

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
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace betamesh {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".betamesh-tmp";
constexpr std::size_t kMaxNameBytes = 255;                 // of a file name, on all common file systems
constexpr std::size_t kFlushBytes = std::size_t{1} << 19;  // bytes after which write() requests a flush
constexpr auto kMaxForeignAge = std::chrono::hours(24);    // of temporaries of other hosts

/// Name of this host, without dots, and of its process namespace, because containers may share a host name.
std::string hostTag() {
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    std::string word(name.data());
    for (char& c : word)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
    struct stat status = {};
    if (::stat("/proc/self/ns/pid", &status) == 0) word += "-" + std::to_string(status.st_ino);
    return word;
}

/// Start time of a process, in clock ticks since boot; distinguishes it from a later process with the same id. "0" if
/// there is no such process.
std::string startTime(pid_t pid) {
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string line;
    std::getline(file, line);
    const std::size_t end_of_name = line.rfind(')');  // the name may contain any character
    if (end_of_name == std::string::npos) return "0";
    std::istringstream fields(line.substr(end_of_name + 1));
    std::string field;
    for (int i = 3; i <= 22 && fields >> field; ++i)
        if (field == "Z") return "0";  // a zombie
    return field;
}

std::string writerTag() { return hostTag() + "." + std::to_string(::getpid()) + "." + startTime(::getpid()); }

fs::path temporaryFor(const fs::path& final_path) {
    static std::atomic<unsigned> counter{0};
    const std::string tail = "." + writerTag() + "." + std::to_string(counter++) + std::string(kSuffix);
    std::string name = final_path.filename().string();
    name.resize(std::min(name.size(), kMaxNameBytes - std::min(kMaxNameBytes, tail.size() + 1)));
    return final_path.parent_path() / ("." + name + tail);
}

struct Writer {
    std::string host;
    pid_t pid = 0;
    std::string start;
};

/// The writer of a temporary, from its name .<name>.<host>.<pid>.<start>.<number>.betamesh-tmp
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

bool isRunning(const Writer& writer) {
    if (::kill(writer.pid, 0) != 0 && errno == ESRCH) return false;
    return startTime(writer.pid) == writer.start;
}

/// A writer holds a lock until it terminates for whatever reason. Locks also work on network file systems.
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
    return !error && fs::file_time_type::clock::now() - written > kMaxForeignAge;
}

}  // namespace

OutputFile::OutputFile(fs::path final_path)
    : final_path_(std::move(final_path)), temporary_path_(temporaryFor(final_path_)) {
    std::error_code ignored;          // if the path cannot be accessed, open() below reports why
    requireRegularFile(final_path_);  // renaming would replace a device
    if (final_path_.filename().empty() || fs::is_directory(final_path_, ignored)) fail("written", EISDIR);
    file_ = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) fail("written", errno);
    ::flock(file_, LOCK_EX | LOCK_NB);  // if the file system has no locks, the process id has to suffice
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : final_path_(std::move(other.final_path_)),
      temporary_path_(std::move(other.temporary_path_)),
      file_(std::exchange(other.file_, -1)),
      unflushed_(other.unflushed_) {}

OutputFile::~OutputFile() {
    if (file_ < 0) return;
    ::unlink(temporary_path_.c_str());
    ::close(file_);
}

void OutputFile::fail(const char* doing, int error_number) const {
    throw FileError(
        final_path_.string() + ": cannot be " + doing + ": " + std::generic_category().message(error_number),
        error_number);
}

void OutputFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(file_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail("written", errno);
        bytes = bytes.subspan(static_cast<std::size_t>(count));
        unflushed_ += static_cast<std::size_t>(count);
    }
    if (unflushed_ < kFlushBytes) return;
    unflushed_ = 0;
    ::sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE);  // only a hint: commit() waits and reports failures
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text.data(), text.size()))); }

void OutputFile::commit() {
    if (::fsync(file_) != 0) fail("flushed to the disk", errno);
    if (::rename(temporary_path_.c_str(), final_path_.c_str()) != 0) fail("renamed to its final name", errno);
    const int file = file_;
    file_ = -1;
    if (::close(file) != 0 && errno != EINTR) fail("closed", errno);
    // Flushing the folder makes the new name durable. Some file systems cannot; the contents are durable already.
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
    const std::string host = hostTag();
    for (const fs::path& path : leftovers) {
        const Writer writer = *writerOf(path.filename().string());
        const bool abandoned = writer.host == host ? !isRunning(writer) : isOld(path);
        if (abandoned && !isLocked(path)) fs::remove(path, error);
    }
}

void makeFoldersOf(const std::vector<std::string>& files) {
    std::set<fs::path> folders;
    for (const std::string& file : files) folders.insert(fs::path(file).parent_path());
    for (const fs::path& folder : folders) {
        std::error_code error;
        if (!folder.empty()) fs::create_directories(folder, error);
        if (error) throw Error("'" + folder.string() + "': the folder cannot be created: " + error.message());
        sweepTemporaries(folder);
    }
}

}  // namespace betamesh
