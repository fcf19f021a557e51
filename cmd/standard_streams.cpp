#include "standard_streams.h"

#include "batch/report/printable.h"
#include "betamesh/error.h"
#include "io/extension.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string_view>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

/// A file descriptor, closed with this object.
struct Descriptor {
    explicit Descriptor(int file) : number(file) {}
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number;
};

[[noreturn]] void fail(const std::string& what) { throw Error(what + ": " + std::generic_category().message(errno)); }

/// Copies until the end. from, to: names for errors.
void copyAll(int source, const std::string& from, int target, const std::string& to) {
    std::array<char, 1U << 16U> block{};
    for (;;) {
        const ssize_t got = ::read(source, block.data(), block.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(from + ": cannot be read");
        if (got == 0) return;
        for (ssize_t done = 0; done < got;) {
            const ssize_t count = ::write(target, block.data() + done, static_cast<std::size_t>(got - done));
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) fail(to + ": cannot be written");
            done += count;
        }
    }
}

}  // namespace

StandardStreams::~StandardStreams() {
    std::error_code ignored;
    if (owner_ == ::getpid()) fs::remove_all(folder_, ignored);
}

fs::path StandardStreams::folder() {
    if (!folder_.empty()) return folder_;
    std::error_code failure;
    const fs::path parent = fs::temp_directory_path(failure);
    if (failure) throw Error("the folder for temporary files, TMPDIR, does not exist. Set it to one that does.");
    std::string name = (parent / "betamesh-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        fail(parent.string() +
             ": no temporary folder for stdin and stdout can be made there. Set TMPDIR to one with space");
    owner_ = ::getpid();
    hideFolder(name + '/');  // messages and reports call the files stdin.ply and stdout.ply
    return folder_ = name;
}

std::string StandardStreams::fileOfStdin() {
    if (::isatty(STDIN_FILENO) != 0)
        throw Error("stdin is a terminal. Give a file to it, as in betamesh mesh - out.ply < in.ply.");
    if (!stdin_file_.empty()) throw Error("stdin (-) is named twice, but can be read only once.");
    const fs::path copy = folder() / "stdin";
    {
        const Descriptor file(::open(copy.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
        if (file.number < 0) fail(copy.string() + ": cannot be written");
        copyAll(STDIN_FILENO, "stdin", file.number, copy.string());
        std::array<char, kSignatureBytes> head{};
        const ssize_t got = ::pread(file.number, head.data(), head.size(), 0);
        const std::string extension =
            extensionOfContents({head.data(), got > 0 ? static_cast<std::size_t>(got) : std::size_t{0}});
        if (extension.empty())
            throw Error(got == 0 ? std::string("stdin is empty. Give it a .ply, .bgeo or .vdb file.")
                                 : std::string("stdin has an unknown format. Give it a .ply, .bgeo or .vdb file."));
        fs::path named = copy;
        named += extension;
        fs::rename(copy, named);
        return (stdin_file_ = named).string();
    }
}

std::string StandardStreams::fileForStdout(const std::string& extension) {
    if (::isatty(STDOUT_FILENO) != 0)
        throw Error("stdout is a terminal. Redirect it, as in betamesh mesh in.ply - > out.ply.");
    return stdout_file_ = folder() / ("stdout" + extension);
}

bool StandardStreams::writeStdout() const {
    if (owner_ != ::getpid() || stdout_file_.empty()) return false;
    std::ifstream file(stdout_file_, std::ios::binary);
    if (!file) fail(stdout_file_.string() + ": cannot be read");
    if (file.peek() != std::ifstream::traits_type::eof()) std::cout << file.rdbuf();
    return static_cast<bool>(std::cout.flush());
}

}  // namespace betamesh
