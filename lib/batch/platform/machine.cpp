
#include "batch/platform/machine.h"

#include "betamesh/error.h"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
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
constexpr int kArenas = 2;
constexpr std::uint64_t kFurtherThreads = 2;  // that a job starts after its memory is limited: signals, writing

/// The folders of a control group controller, from the group of this process up to the root. Covers version 2 (one
/// hierarchy) and version 1 (one hierarchy per controller).
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

/// The number at the start of a file; nullopt if the file is absent or contains "max".
std::optional<double> numberIn(const fs::path& file) {
    std::ifstream in(file);
    double number = 0;
    if (in >> number) return number;
    return std::nullopt;
}

/// The number after a word in a file of lines "word number".
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

/// A column of /proc/self/statm, counted from 0, in bytes.
std::uint64_t statmBytes(int column) {
    std::ifstream in("/proc/self/statm");
    std::uint64_t pages = 0;
    for (int i = 0; i <= column; ++i) in >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// The processor time per second that the containers around this process grant it.
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

std::uint64_t threadStackBytes() {
    std::size_t bytes = 0;
    pthread_attr_t attributes;
    if (pthread_getattr_default_np(&attributes) != 0) return bytes;
    pthread_attr_getstacksize(&attributes, &bytes);
    pthread_attr_destroy(&attributes);
    return bytes;
}

/// Limits the heap of this process. False if the system refuses.
bool setDataLimit(std::uint64_t bytes) {
    rlimit limit{};
    getrlimit(RLIMIT_DATA, &limit);
    limit.rlim_cur = std::min<rlim_t>(bytes, limit.rlim_max);
    return setrlimit(RLIMIT_DATA, &limit) == 0;
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

int mostThreads() {
    constexpr int kLeast = 64;
    return std::max(kLeast, availableThreads());
}

std::uint64_t availableMemory() {
    auto bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    for (const fs::path& folder : groupFolders("memory")) {
        for (const char* name : {"memory.max", "memory.limit_in_bytes"}) {
            if (const auto limit = numberIn(folder / name)) bytes = std::min(bytes, *limit);
        }
    }
    // Slurm does not have to enforce its limit by a container.
    if (const auto granted = numberFromEnvironment("SLURM_MEM_PER_NODE")) bytes = std::min(bytes, *granted * 1048576.0);
    return static_cast<std::uint64_t>(bytes);
}

std::uint64_t freeMemory() {
    auto bytes = static_cast<double>(availableMemory());
    if (const auto machine = valueIn("/proc/meminfo", "MemAvailable:")) bytes = std::min(bytes, *machine * 1024.0);
    for (const fs::path& folder : groupFolders("memory")) {  // version 2 only: version 1 names these files differently
        const auto limit = numberIn(folder / "memory.max");
        const auto used = numberIn(folder / "memory.current");
        const auto cached = valueIn(folder / "memory.stat", "inactive_file");
        if (limit && used) bytes = std::min(bytes, std::max(0.0, *limit - *used + cached.value_or(0)));
    }
    return static_cast<std::uint64_t>(bytes);
}

std::uint64_t currentMemory() { return statmBytes(1); }

std::uint64_t peakMemory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // ru_maxrss is in KiB
}

void keepFreedMemory() {
    mallopt(M_MMAP_THRESHOLD, std::numeric_limits<int>::max());
    mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

void releaseFreeMemory() { malloc_trim(0); }

void returnFreedMemory() {
    mallopt(M_MMAP_THRESHOLD, kLargeBlock);
    mallopt(M_TRIM_THRESHOLD, kLargeBlock);
    mallopt(M_ARENA_MAX, kArenas);  // small blocks spread over fewer arenas leave fewer partly used pages
    malloc_trim(0);
}

void limitToMachine() { setDataLimit(availableMemory() + statmBytes(5)); }

void limitMemory(std::uint64_t bytes) {
    returnFreedMemory();
    const std::uint64_t now = statmBytes(5);  // RLIMIT_DATA counts the heap and the whole stacks of threads
    if (!setDataLimit(bytes + now + kFurtherThreads * threadStackBytes()))
        throw Error("memory limit of " + std::to_string(bytes) + " bytes: " + std::strerror(errno));
}

}  // namespace betamesh
