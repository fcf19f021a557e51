
#include "io/vdb_process.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/bytes.h"
#include "io/vdb.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <new>
#include <thread>
#include <utility>

namespace betamesh {
namespace {

// What an honest file may take. Measured on the worst, points so sparse that each has nodes of the tree to itself: 33
// bytes a byte of the file, 0.1 s a MiB.
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30, kMemoryOfByte = 128;
constexpr std::uint64_t kSeconds = 10, kBytesOfSecond = std::uint64_t{1} << 20;

constexpr std::size_t kLongestRequest = 1 << 15;
constexpr int kPipeBytes = 1 << 20;

int requests = -1;  // to the process that was started
pid_t server = -1;  // its number

/// Followed by the name of the id and the path, which is empty where nothing is to be read but OpenVDB loaded.
struct Request {
    rlim_t memory;  // as of who asks
    std::uint32_t id_length;
    bool attributes;
};

enum class Answer : std::uint8_t { points, end, error, out_of_memory };

std::string reasonOf(int error_number) { return std::strerror(error_number); }

// Both sides of a pipe.

template <typename T>
void writeRows(const std::vector<T>& rows, ByteWriter& out) {
    out.little(std::uint64_t{rows.size()});
    out.text({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(T)});
}

void writeText(const std::string& text, ByteWriter& out) {
    out.little(std::uint64_t{text.size()});
    out.text(text);
}

std::uint64_t readNumber(Cursor& in) {
    return loadNumber<std::uint64_t>(in.take(8, "a number"), std::endian::native != std::endian::little);
}

/// A count is believed as far as rows arrive.
template <typename T>
void readRows(Cursor& in, std::vector<T>& rows) {
    constexpr std::uint64_t kAtOnce = 1 << 14;
    for (std::uint64_t left = readNumber(in); left > 0;) {
        const std::uint64_t count = std::min(left, kAtOnce);
        const std::byte* const bytes = in.take(count * sizeof(T), "rows");
        rows.resize(rows.size() + count);
        std::memcpy(static_cast<void*>(rows.data() + rows.size() - count), bytes, count * sizeof(T));
        left -= count;
    }
}

std::string readText(Cursor& in) {
    std::vector<char> characters;
    readRows(in, characters);
    return {characters.begin(), characters.end()};
}

void writePoints(const FileContents& points, std::uint64_t all, ByteWriter& out) {
    out.little(Answer::points);
    out.little(all);
    writeRows(points.position, out);
    writeRows(points.id, out);
    out.little(std::uint64_t{points.attributes.size()});
    for (const Attribute& a : points.attributes) {
        writeText(a.name, out);
        out.little(std::uint64_t{a.components});
        writeRows(a.real, out);
        writeRows(a.integer, out);
    }
}

/// Returns how many points the file says it has.
std::uint64_t readPoints(Cursor& in, FileContents& points) {
    const std::uint64_t all = readNumber(in);
    readRows(in, points.position);
    readRows(in, points.id);
    for (std::uint64_t left = readNumber(in); left > 0; --left) {
        Attribute& a = points.attributes.emplace_back();
        a.name = readText(in);
        a.components = static_cast<std::uint32_t>(readNumber(in));
        readRows(in, a.real);
        readRows(in, a.integer);
    }
    return all;
}

void writeEnd(const FileContents& contents, ByteWriter& out) {
    out.little(Answer::end);
    writeText(contents.format, out);
    out.little(std::uint64_t{contents.declared.size()});
    for (const AttributeInfo& info : contents.declared) {
        for (const std::string* text : {&info.name, &info.type, &info.codec}) writeText(*text, out);
        out.little(std::uint64_t{info.components});
    }
}

void readEnd(Cursor& in, FileContents& contents) {
    contents.format = readText(in);
    for (std::uint64_t left = readNumber(in); left > 0; --left) {
        AttributeInfo& info = contents.declared.emplace_back();
        for (std::string* text : {&info.name, &info.type, &info.codec}) *text = readText(in);
        info.components = static_cast<std::uint32_t>(readNumber(in));
    }
}

// The process that was started, and those that it starts.

void limit(int resource, rlim_t most) {
    rlimit limit{};
    ::getrlimit(resource, &limit);
    limit.rlim_cur = std::min({limit.rlim_cur, limit.rlim_max, most});
    ::setrlimit(resource, &limit);
}

/// What RLIMIT_DATA counts.
rlim_t dataHere() {
    std::ifstream sizes("/proc/self/statm");
    rlim_t pages = 0;
    for (int field = 0; field < 6; ++field) sizes >> pages;
    return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void limitTo(std::uint64_t file_bytes, rlim_t memory) {
    limit(RLIMIT_CPU, kSeconds + file_bytes / kBytesOfSecond);
    limit(RLIMIT_DATA, dataHere() + std::min<rlim_t>(memory, kMemory + kMemoryOfByte * file_bytes));
}

/// In a process for this file alone.
void answer(const Request& request, const std::string& id, const std::string& path, int pipe) {
    ByteWriter out([pipe](std::span<const std::byte> bytes) {
        while (!bytes.empty()) {
            const ssize_t count = ::write(pipe, bytes.data(), bytes.size());
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) ::_exit(1);  // nobody waits for it any more
            bytes = bytes.subspan(static_cast<std::size_t>(count));
        }
    });
    try {
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(path, error);
        limitTo(error ? 0 : size, request.memory);
        ReadOptions options{id, request.attributes};
        options.points = [&](FileContents&& points, std::uint64_t all) { writePoints(points, all, out); };
        withThreads(1, [&] { writeEnd(readVdb(path, options), out); });
    } catch (const std::bad_alloc&) {
        out.little(Answer::out_of_memory);
    } catch (const std::exception& error) {
        out.little(Answer::error);
        writeText(error.what(), out);
    }
    out.flush();
    ::_exit(0);
}

/// The next request, and the pipe for what it asks for (-1: none). Nothing when nobody asks any more.
std::string receive(int socket, int& pipe) {
    std::string request(kLongestRequest, '\0');
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    iovec text{request.data(), request.size()};
    msghdr message{};
    message.msg_iov = &text;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    ssize_t count = 0;
    while ((count = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC)) < 0 && errno == EINTR) {
    }
    request.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    const cmsghdr* const header = CMSG_FIRSTHDR(&message);
    pipe = -1;
    if (header != nullptr) std::memcpy(&pipe, CMSG_DATA(header), sizeof pipe);
    return request;
}

/// State of a thread, as the system names it: S asleep.
char stateOf(const std::filesystem::path& thread) {
    std::ifstream file(thread / "stat");
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    const std::size_t name_end = line.rfind(')');
    return name_end + 2 < line.size() ? line[name_end + 2] : 'S';
}

/// A library's log begins threads of its own when it is loaded. A fork must not find one at work: what it holds then,
/// nobody gives back in the child, which may wait for it for ever. Gives up after a second.
void awaitOtherThreads() {
    const std::string self = std::to_string(::getpid());
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    for (bool working = true; working && std::chrono::steady_clock::now() < latest;) {
        working = false;
        for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
            working |= thread.path().filename() != self && stateOf(thread) != 'S';
        if (working) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

/// Until nobody asks any more.
void serve(int socket) {
    bool loaded = false;
    for (;;) {
        int pipe = -1;
        const std::string text = receive(socket, pipe);
        Request request{};
        if (text.size() < sizeof request) return;
        std::memcpy(&request, text.data(), sizeof request);
        try {
            if (!std::exchange(loaded, true)) {
                loadVdb();
                awaitOtherThreads();
            }
        } catch (const std::exception&) {  // told when it is tried again, by the reader
        }
        if (pipe < 0) continue;
        const pid_t reader = ::fork();
        if (reader == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            answer(request, text.substr(sizeof request, request.id_length),
                   text.substr(sizeof request + request.id_length), pipe);
        }
        ::close(pipe);  // where there is no reader, whoever asked sees an end without an answer
    }
}

void closeFrom(int first) {
    if (::close_range(static_cast<unsigned>(first), ~0U, 0) == 0) return;
    std::vector<int> open;  // Linux before 5.9
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
        open.push_back(std::stoi(entry.path().filename().string()));
    for (const int file : open)
        if (file >= first) ::close(file);
}

/// Holds nothing of its parent but stderr; an exception ends it, rather than pass for one of its parent. What Blosc
/// says on stdout is for nobody.
[[noreturn]] void beServer(int socket) noexcept {
    constexpr int kSocket = STDERR_FILENO + 1;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::prctl(PR_SET_NAME, "betamesh_vdb");
    ::dup2(socket, kSocket);
    closeFrom(kSocket + 1);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO}) ::dup2(::open("/dev/null", O_RDWR), standard);
    for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) ::signal(ignored, SIG_IGN);
    serve(kSocket);
    ::_exit(0);
}

// Who asks.

/// pipe: -1 for none. Returns the number of an error, or 0.
int send(std::string text, int pipe) {
    if (text.size() > kLongestRequest) return ENAMETOOLONG;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    iovec part{text.data(), text.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (pipe >= 0) {
        message.msg_control = control.data();
        message.msg_controllen = control.size();
        cmsghdr* const header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(sizeof pipe);
        std::memcpy(CMSG_DATA(header), &pipe, sizeof pipe);
    }
    while (::sendmsg(requests, &message, MSG_NOSIGNAL) < 0)
        if (errno != EINTR) return errno;
    return 0;
}

std::string textOf(const Request& request, const std::string& id, const std::string& path) {
    return std::string(reinterpret_cast<const char*>(&request), sizeof request) + id + path;
}

class Pipe {
public:
    /// file: for errors.
    explicit Pipe(const std::string& file) : file_(file) {
        if (::pipe2(ends_.data(), O_CLOEXEC) != 0) fail(errno);
        ::fcntl(ends_[1], F_SETPIPE_SZ, kPipeBytes);  // fewer turns; any size is well
    }
    ~Pipe() {
        ::close(ends_[0]);
        closeForWriting();
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    int forWriting() const { return ends_[1]; }
    void closeForWriting() {
        if (ends_[1] >= 0) ::close(std::exchange(ends_[1], -1));
    }
    /// 0 at the end.
    std::size_t read(std::byte* to, std::size_t count) {
        for (;;) {
            const ssize_t got = ::read(ends_[0], to, count);
            if (got >= 0) return static_cast<std::size_t>(got);
            if (errno != EINTR) fail(errno);
        }
    }
    [[noreturn]] void fail(int error_number) const {
        throw Error(file_ + ": cannot be read: " + reasonOf(error_number));
    }

private:
    const std::string& file_;
    std::array<int, 2> ends_{-1, -1};
};

bool rowsMatch(const FileContents& points) {
    const std::size_t n = points.position.size();
    const auto matches = [&](const Attribute& a) {
        return std::max(a.real.size(), a.integer.size()) == n * a.components &&
               std::min(a.real.size(), a.integer.size()) == 0;
    };
    return (points.id.empty() || points.id.size() == n) &&
           std::all_of(points.attributes.begin(), points.attributes.end(), matches);
}

void endServer() {
    ::kill(server, SIGKILL);
    while (::waitpid(server, nullptr, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace

void startVdbProcess() {
    std::array<int, 2> sockets{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0)
        throw Error("a socket to a process cannot be made: " + reasonOf(errno));
    server = ::fork();
    if (server < 0) throw Error("a process cannot be made: " + reasonOf(errno));
    if (server == 0) beServer(sockets[1]);
    ::close(sockets[1]);
    requests = sockets[0];
    std::atexit(endServer);
    std::at_quick_exit(endServer);
}

bool hasVdbProcess() { return requests >= 0; }

void loadVdbApart() { send(textOf({}, {}, {}), -1); }  // what goes wrong, reading will tell

FileContents readVdbApart(const std::filesystem::path& path, const ReadOptions& options) {
    const std::string file = path.string();
    const auto lost = [&] {
        return Error(file +
                     ": the process that read it was ended; expected a file that is not damaged, and enough memory");
    };
    Pipe pipe(file);
    rlimit memory{};
    ::getrlimit(RLIMIT_DATA, &memory);
    const Request request{memory.rlim_cur, static_cast<std::uint32_t>(options.id.size()), options.attributes};
    if (const int error = send(textOf(request, options.id, file), pipe.forWriting())) pipe.fail(error);
    pipe.closeForWriting();
    const auto source = [&](std::byte* to, std::size_t count) {
        const std::size_t got = pipe.read(to, count);
        if (got == 0) throw lost();  // an answer says where it ends
        return got;
    };
    Cursor in(source, std::numeric_limits<std::uint64_t>::max(), file);
    FileContents contents;
    for (;;) {
        switch (static_cast<Answer>(*in.take(1, "an answer"))) {
            case Answer::points: {
                FileContents points;
                const std::uint64_t all = readPoints(in, points);
                if (!rowsMatch(points)) throw lost();
                deliver(std::move(points), all, options, contents);
                break;
            }
            case Answer::end:
                readEnd(in, contents);
                return contents;
            case Answer::error:
                throw Error(readText(in));
            case Answer::out_of_memory:
                throw std::bad_alloc();
            default:
                throw lost();
        }
    }
}

}  // namespace betamesh
