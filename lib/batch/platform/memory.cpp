
#include "batch/platform/memory.h"

#include "batch/platform/machine.h"
#include "io/extension.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace betamesh {
namespace {

constexpr double kBytesPerParticle = 1400;  // measured on splashes: 800 to 1500 with its share of the surface

constexpr double kAreaPerParticle = 0.5;  // measured on splashes: 0.35 to 0.6; on sheets 2

constexpr std::uint64_t kProgram = std::uint64_t{32}
                                   << 20;  // bytes for threads and libraries, independent of the frames
constexpr double kMargin = 1.25;  // frames that have not reached their peaks at the same time yet may do so later
constexpr double kLeastScale = 0.1, kLargestScale = 20;

}  // namespace

std::uint64_t workingMemory(const std::string& input) { return memoryOf(estimatedParticles(input)); }

double estimatedParticles(const std::string& input) {
    std::error_code error;
    const auto bytes = static_cast<double>(std::filesystem::file_size(input, error));
    return error ? 0 : bytes / fileBytesPerParticle(input);
}

double estimatedArea(double particles) { return particles * kAreaPerParticle; }

std::uint64_t memoryOf(double particles) { return static_cast<std::uint64_t>(particles * kBytesPerParticle); }

MemoryWatch::MemoryWatch(std::uint64_t budget)
    : budget_(static_cast<double>(budget)), before_(currentMemory() + kProgram) {}

double MemoryWatch::scale() const {
    if (ended_ == 0 || most_at_work_ == 0) return 1;
    const std::uint64_t peak = std::max(peakMemory(), before_);
    const double measured = static_cast<double>(peak - before_) / static_cast<double>(most_at_work_);
    return std::clamp(measured * kMargin, kLeastScale, kLargestScale);
}

std::size_t MemoryWatch::fitting(std::uint64_t estimate) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(
        std::max(1.0, budget_ / (scale() * static_cast<double>(std::max<std::uint64_t>(1, estimate)))));
}

bool MemoryWatch::hasRoomFor(std::uint64_t estimate) const {
    const std::scoped_lock lock(mutex_);
    if (count_ == 0) return true;
    const double wanted = scale() * static_cast<double>(estimate);
    return scale() * static_cast<double>(at_work_) + wanted <= budget_ && wanted <= static_cast<double>(freeMemory());
}

void MemoryWatch::begins(std::uint64_t estimate) {
    const std::scoped_lock lock(mutex_);
    ++count_;
    at_work_ += estimate;
    most_at_work_ = std::max(most_at_work_, at_work_);
}

void MemoryWatch::ends(std::uint64_t estimate) {
    const std::scoped_lock lock(mutex_);
    --count_;
    ++ended_;
    at_work_ -= estimate;
}

std::size_t MemoryWatch::atWork() const {
    const std::scoped_lock lock(mutex_);
    return count_;
}

}  // namespace betamesh
