#include "batch/job/provenance.h"

#include "betamesh/error.h"
#include "io/bytes.h"
#include "io/digest.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <vector>

namespace betamesh {
namespace {

constexpr std::streamsize kBlock = std::streamsize{1} << 17;  // bytes read at once
constexpr std::int64_t kCoarsestClock =
    2LL * 1'000'000'000LL;  // resolution of file times in nanoseconds: that of FAT, others are finer

[[noreturn]] void failReading(const std::string& file) {
    throw Error(file + ": cannot be read: " + std::generic_category().message(errno));
}

std::string hexDigits(const Digest& digest) {
    std::array<char, 33> text{};
    std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(digest[1]),
                  static_cast<unsigned long long>(digest[0]));
    return text.data();
}

std::int64_t now() {
    const auto since = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

std::string contentHash(const std::string& file) {
    Digester digester;
    std::ifstream in(file, std::ios::binary);
    const auto block = std::make_unique_for_overwrite<char[]>(kBlock);
    while (in.read(block.get(), kBlock) || in.gcount() > 0)
        digester.add(std::as_bytes(std::span(block.get(), static_cast<std::size_t>(in.gcount()))));
    if (!in.eof()) failReading(file);
    return hexDigits(digester.value());
}

/// The hash of the values of some keys.
template <typename IsWanted>
std::string hashOfKeys(const Config& config, const IsWanted& isWanted) {
    std::string text;
    for (const ConfigKey& key : configKeys())
        if (isWanted(key)) text += key.path + '=' + key.get(config) + '\n';
    return hashOf(text);
}

}  // namespace

std::string hashOf(std::string_view bytes) { return hexDigits(digestOf(std::as_bytes(std::span(bytes)))); }

std::string configHash(const Config& config) {
    return hashOfKeys(config, [&](const ConfigKey& key) {
        const bool is_irrelevant = key.path.starts_with("run.") || key.path.starts_with("preview.") ||
                                   key.path == "frames" || key.path == "preset" || key.path == "input.path" ||
                                   key.path == "output.path";
        const bool is_unused =
            key.path.starts_with("perturbation.") && config.surface.predicates == PredicateKind::exact;
        return !is_irrelevant && !is_unused;
    });
}

std::string previewHash(const Config& config) {
    return hashOfKeys(
        config, [](const ConfigKey& key) { return key.path.starts_with("preview.") && key.path != "preview.path"; });
}

std::string listedName(const std::string& file, const std::string& output) {
    const std::filesystem::path name =
        std::filesystem::path(file).lexically_relative(std::filesystem::path(output).parent_path());
    return name.empty() ? std::filesystem::absolute(file).lexically_normal().string() : name.string();
}

FileFingerprint fileFingerprint(const std::string& file) {
    requireRegularFile(file);
    struct stat status = {};
    if (::stat(file.c_str(), &status) != 0) failReading(file);
    return {static_cast<std::uint64_t>(status.st_size),
            std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

FileIdentity fileIdentity(const std::string& file) {
    const std::int64_t start = now();
    FileIdentity identity;
    identity.fingerprint = fileFingerprint(file);
    if (identity.fingerprint.modified > start - kCoarsestClock) identity.fingerprint.modified = 0;
    identity.content_hash = contentHash(file);
    return identity;
}

bool isSame(const std::string& file, const FileIdentity& identity) {
    const FileFingerprint current = fileFingerprint(file);
    if (current.bytes != identity.fingerprint.bytes) return false;
    if (identity.fingerprint.modified != 0 && current.modified == identity.fingerprint.modified) return true;
    return contentHash(file) == identity.content_hash;
}

}  // namespace betamesh
