// A library to preload into the program: makes chosen calls on chosen files fail as disks and servers do.
//
// BETAMESH_FAULT=CALL:ERRNO:NAME[:TIMES] makes CALL (open, read, write, fsync, rename) fail with the number ERRNO for
// files whose path contains NAME, at most TIMES times. A negative ERRNO ends the process with signal -ERRNO. The word
// stall instead of ERRNO lets the call never return.
// If CALL is thread, starting the n-th thread of a process fails, whose path is thread/n/.

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr int kStall = 1 << 20;  // stands for an error number

struct Fault {
    char call[16] = "";
    char name[256] = "";
    int error = 0;
    std::atomic<int> times = 1 << 30;
};

Fault& theFault() {
    static Fault fault;
    static const bool read_once = [] {
        const char* text = std::getenv("BETAMESH_FAULT");
        int times = 1 << 30;
        char error[16] = "0";
        if (text != nullptr) std::sscanf(text, "%15[^:]:%15[^:]:%255[^:]:%d", fault.call, error, fault.name, &times);
        fault.error = std::strcmp(error, "stall") == 0 ? kStall : std::atoi(error);
        fault.times = times;
        return true;
    }();
    static_cast<void>(read_once);
    return fault;
}

bool fails(const char* call, const char* path) {
    Fault& fault = theFault();
    if (fault.error == 0 || std::strcmp(call, fault.call) != 0 || std::strstr(path, fault.name) == nullptr)
        return false;
    if (fault.times-- <= 0) return false;
    while (fault.error == kStall) pause();
    if (fault.error < 0) raise(-fault.error);  // in this thread, which therefore does not go on
    errno = fault.error;
    return true;
}

bool fails(const char* call, int file) {
    if (theFault().error == 0) return false;
    char link[64];
    char path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return false;
    path[length] = '\0';
    return fails(call, path);
}

template <typename Function>
Function next(const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

mode_t modeOf(int flags, va_list arguments) { return (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : mode_t{0}; }

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = modeOf(flags, arguments);
    va_end(arguments);
    return fails("open", path) ? -1 : next<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = modeOf(flags, arguments);
    va_end(arguments);
    return fails("open", path) ? -1 : next<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}

ssize_t read(int file, void* bytes, size_t count) {
    return fails("read", file) ? -1 : next<ssize_t (*)(int, void*, size_t)>("read")(file, bytes, count);
}

ssize_t write(int file, const void* bytes, size_t count) {
    return fails("write", file) ? -1 : next<ssize_t (*)(int, const void*, size_t)>("write")(file, bytes, count);
}

int fsync(int file) { return fails("fsync", file) ? -1 : next<int (*)(int)>("fsync")(file); }

int rename(const char* from, const char* to) {
    return fails("rename", to) ? -1 : next<int (*)(const char*, const char*)>("rename")(from, to);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* how, void* (*body)(void*), void* argument) {
    static std::atomic<int> made = 0;
    char path[32];
    std::snprintf(path, sizeof path, "thread/%d/", ++made);
    if (fails("thread", path)) return errno;
    return next<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create")(thread, how,
                                                                                                       body, argument);
}

}  // extern "C"
