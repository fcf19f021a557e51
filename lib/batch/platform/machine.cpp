
#include "batch/platform/machine.h"

#include "batch/platform/huge_pages.h"
#include "betamesh/error.h"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr int kLargeBlock = 1 << 18;  // bytes
constexpr int kHeaps = 2;

/// Where the files of one control group controller are: from the group of this process up to the root.
/// Covers version 2 (one tree) and version 1 (a tree a controller).
std::vector<fs::path> groupFolders(const std::string& controller) {
    std::vector<fs::path> folders;
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        // number:controllers:/path
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = ',' + line.substr(first + 1, second - first - 1) + ',';
        fs::path root;
        if (controllers == ",,") root = "/sys/fs/cgroup";
        if (controllers.find(',' + controller + ',') != std::string::npos) root = "/sys/fs/cgroup/" + controller;
        if (root.empty()) continue;
        const fs::path group = fs::path(line.substr(second + 1)).relative_path();
        for (fs::path below = group; !below.empty(); below = below.parent_path()) folders.push_back(root / below);
        folders.push_back(root);
    }
    return folders;
}

/// The number at the front of a file; nothing when the file is absent or says "max".
std::optional<double> numberIn(const fs::path& file) {
    std::ifstream in(file);
    double number = 0;
    if (in >> number) return number;
    return std::nullopt;
}

/// The number behind a word in a file of lines "word number".
std::optional<double> valueIn(const fs::path& file, const std::string& word) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream in(line);
        std::string name;
        double value = 0;
        if (in >> name >> value && name == word) return value;
    }
    return std::nullopt;
}

/// A column of /proc/self/statm, counted from 0; bytes.
std::uint64_t pagesOf(int column) {
    std::ifstream in("/proc/self/statm");
    std::uint64_t pages = 0;
    for (int i = 0; i <= column; ++i) in >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// Processors' worth of time the containers around this process grant it.
std::optional<double> processorQuota() {
    std::optional<double> least;
    const auto take = [&](double processors) { least = std::min(least.value_or(processors), processors); };
    for (const fs::path& folder : groupFolders("cpu")) {
        std::ifstream version2(folder / "cpu.max");
        double quota = 0;
        double period = 0;
        if (version2 >> quota >> period && period > 0) take(quota / period);
        const auto quota1 = numberIn(folder / "cpu.cfs_quota_us");
        const auto period1 = numberIn(folder / "cpu.cfs_period_us");
        if (quota1 && period1 && *quota1 > 0 && *period1 > 0) take(*quota1 / *period1);
    }
    return least;
}

std::uint64_t stackOfAThread() {
    std::size_t bytes = 0;
    pthread_attr_t usual;
    if (pthread_getattr_default_np(&usual) != 0) return bytes;
    pthread_attr_getstacksize(&usual, &bytes);
    pthread_attr_destroy(&usual);
    return bytes;
}

std::optional<int> numberFromEnvironment(const char* name) {
    const char* text = std::getenv(name);
    if (text == nullptr) return std::nullopt;
    int number = 0;
    const auto [end, error] = std::from_chars(text, text + std::strlen(text), number);
    if (error != std::errc{} || *end != '\0' || number < 1) return std::nullopt;
    return number;
}

}  // namespace

int availableThreads() {
    int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) threads = std::min(threads, CPU_COUNT(&allowed));
    if (const auto quota = processorQuota()) threads = std::min(threads, static_cast<int>(std::ceil(*quota)));
    for (const char* name : {"SLURM_CPUS_PER_TASK", "CUE_THREADS"}) {
        if (const auto granted = numberFromEnvironment(name)) threads = std::min(threads, *granted);
    }
    return std::max(1, threads);
}

std::uint64_t availableMemory() {
    auto bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    for (const fs::path& folder : groupFolders("memory")) {
        for (const char* name : {"memory.max", "memory.limit_in_bytes"}) {
            if (const auto limit = numberIn(folder / name)) bytes = std::min(bytes, *limit);
        }
    }
    // Slurm's own enforcement need not be a container.
    if (const auto granted = numberFromEnvironment("SLURM_MEM_PER_NODE")) bytes = std::min(bytes, *granted * 1048576.0);
    return static_cast<std::uint64_t>(bytes);
}

std::uint64_t freeMemory() {
    auto bytes = static_cast<double>(availableMemory());
    if (const auto machine = valueIn("/proc/meminfo", "MemAvailable:")) bytes = std::min(bytes, *machine * 1024.0);
    for (const fs::path& folder : groupFolders("memory")) {  // version 2; the first version tells in other words
        const auto limit = numberIn(folder / "memory.max");
        const auto used = numberIn(folder / "memory.current");
        const auto cached = valueIn(folder / "memory.stat", "inactive_file");
        if (limit && used) bytes = std::min(bytes, std::max(0.0, *limit - *used + cached.value_or(0)));
    }
    return static_cast<std::uint64_t>(bytes);
}

std::uint64_t currentMemory() { return pagesOf(1); }

std::uint64_t peakMemory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

std::uint64_t readAhead(int file) {
    struct stat status = {};
    if (::fstat(file, &status) != 0) return 0;
    const std::string device = std::to_string(major(status.st_dev)) + ':' + std::to_string(minor(status.st_dev));
    for (const fs::path& place :
         {fs::path("/sys/dev/block") / device / "queue", fs::path("/sys/dev/block") / device / "../queue",
          fs::path("/sys/class/bdi") / device})
        if (const auto kibibytes = numberIn(place / "read_ahead_kb"))
            return static_cast<std::uint64_t>(*kibibytes) * 1024;
    return 0;
}

void keepFreedMemory() {
    mallopt(M_MMAP_THRESHOLD, std::numeric_limits<int>::max());
    mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
    useHugePages();
}

void releaseFreeMemory() {
    malloc_trim(0);
    releaseFreeHugePages();
}

void returnFreedMemory() {
    // Large blocks go back at once, small ones are not scattered over many heaps.
    mallopt(M_MMAP_THRESHOLD, kLargeBlock);
    mallopt(M_TRIM_THRESHOLD, kLargeBlock);
    mallopt(M_ARENA_MAX, kHeaps);
    malloc_trim(0);
    leaveHugePages();
}

void limitMemory(std::uint64_t bytes) {
    returnFreedMemory();
    std::uint64_t data = pagesOf(5);  // what RLIMIT_DATA counts: the heap, and the stacks of threads in full
    data += 2 * stackOfAThread();     // a job makes one that waits for signals, and one that trims scratch memory
    rlimit limit{};
    getrlimit(RLIMIT_DATA, &limit);
    limit.rlim_cur = std::min<rlim_t>(bytes + data, limit.rlim_max);
    if (setrlimit(RLIMIT_DATA, &limit) != 0) {
        throw Error("memory limit of " + std::to_string(bytes) + " bytes: " + std::strerror(errno));
    }
}

}  // namespace betamesh
