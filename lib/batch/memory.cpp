#include "batch/memory.h"

#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

namespace betamesh {
namespace {

// A particle of a splash takes 800 to 1900 bytes with its share of the surface, and so many on disk:
constexpr std::array<std::pair<std::string_view, double>, 4> kFileBytesOfParticle{
    {{".vdb", 12}, {".gz", 14}, {".ply", 28}, {".bgeo", 32}}};
constexpr double kBytesOfParticle = 1400;

}  // namespace

std::uint64_t workingMemory(const std::string& input) {
    std::error_code error;
    const auto bytes = static_cast<double>(std::filesystem::file_size(input, error));
    if (error) return 0;
    double of_particle = kFileBytesOfParticle.front().second;
    for (const auto& [extension, file_bytes] : kFileBytesOfParticle)
        if (input.ends_with(extension)) of_particle = file_bytes;
    return static_cast<std::uint64_t>(bytes / of_particle * kBytesOfParticle);
}

}  // namespace betamesh
