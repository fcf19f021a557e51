
#include "batch/job/distinct_files.h"

#include "betamesh/error.h"

#include <sys/stat.h>

#include <filesystem>
#include <system_error>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

/// Device and inode; empty if there is no such file.
std::string identityOf(const std::string& path) {
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) return "";
    return std::to_string(status.st_dev) + ':' + std::to_string(status.st_ino);
}

[[noreturn]] void fail(const std::string& path, const std::string& first, const std::string& second) {
    throw Error(path + " is both " + first + " and " + second + ". Choose another path for one of them.");
}

void refuse(const std::string& path, const std::string& what, const std::map<std::string, std::string>& others,
            const std::string& key) {
    if (key.empty()) return;
    const auto other = others.find(key);
    if (other != others.end() && other->second != what) fail(path, other->second, what);
}

}  // namespace

std::string DistinctFiles::placeOf(const std::string& path) {
    const fs::path whole(path);
    const std::string folder = whole.parent_path().empty() ? "." : whole.parent_path().string();
    const auto [known, is_new] = folders_.try_emplace(folder);
    if (is_new) {
        std::error_code error;
        known->second = fs::weakly_canonical(fs::absolute(folder), error).string();
        if (error) known->second = fs::absolute(folder).lexically_normal().string();
    }
    return known->second + '/' + whole.filename().string();
}

void DistinctFiles::read(const std::string& path, const std::string& what) {
    const std::string place = placeOf(path), identity = identityOf(path);
    refuse(path, what, written_, place);
    refuse(path, what, existed_, identity);
    read_.try_emplace(place, what);
    if (!identity.empty()) identity_.try_emplace(identity, what);
}

void DistinctFiles::written(const std::string& path, const std::string& what) {
    const std::string place = placeOf(path), identity = identityOf(path);
    refuse(path, what, read_, place);
    refuse(path, what, written_, place);
    refuse(path, what, identity_, identity);
    written_.try_emplace(place, what);
    if (!identity.empty()) existed_.try_emplace(identity, what);
}

}  // namespace betamesh
