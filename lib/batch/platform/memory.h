// Estimates the memory of frames before they are read, and corrects the estimates by the memory that frames have used.

#pragma once

#include <cstdint>
#include <mutex>
#include <string>

namespace betamesh {

/// The estimated peak memory of a frame in bytes, from the size and format of its file. 0 if there is no file.
std::uint64_t workingMemory(const std::string& input);

/// The estimated number of particles in a file, from its size and format. 0 if there is no file.
double estimatedParticles(const std::string& input);

/// The estimated area of the surface around particles, in squared particle spacings.
double estimatedArea(double particles);

/// The estimated memory of particles and the surface around them, bytes.
std::uint64_t memoryOf(double particles);

/// Decides how many frames may be in progress at once. Estimates are those of workingMemory(). Once frames have ended,
/// they are scaled by the ratio of the peak memory of the process to the estimates of the frames in progress then.
class MemoryWatch {
public:
    /// budget: memory for all frames in progress together, bytes.
    explicit MemoryWatch(std::uint64_t budget);

    /// The number of frames with this estimate that fit together, at least 1.
    std::size_t fitting(std::uint64_t estimate) const;

    /// Whether another frame fits, both into the budget and into the free memory of the machine. Always true for the
    /// first.
    bool hasRoomFor(std::uint64_t estimate) const;

    void begins(std::uint64_t estimate);
    void ends(std::uint64_t estimate);
    std::size_t atWork() const;

private:
    double scale() const;

    mutable std::mutex mutex_;  // guards all members
    double budget_;
    std::uint64_t before_;  // memory of the process at construction, plus a constant
    std::size_t count_ = 0, ended_ = 0;
    std::uint64_t at_work_ = 0, most_at_work_ = 0;  // sums of estimates: now, at most
};

}  // namespace betamesh
