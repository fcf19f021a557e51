// How much memory frames take: guessed before they are read, corrected by what earlier ones took.

#pragma once

#include <cstdint>
#include <mutex>
#include <string>

namespace betamesh {

/// What a frame is likely to take at its peak, by the size and the format of its file; bytes. 0 where there is no file.
std::uint64_t workingMemory(const std::string& input);

/// What particles with their share of the surface are likely to take; bytes.
std::uint64_t memoryOf(double particles);

/// Decides how many frames may be at work at once. Estimates are those of workingMemory(); they are trusted until
/// frames have ended, then scaled by what the process has held while so and so much was at work.
class MemoryWatch {
public:
    /// budget: bytes that all frames at work may take together.
    explicit MemoryWatch(std::uint64_t budget);

    /// Frames of such an estimate that fit at once, at least 1.
    std::size_t fitting(std::uint64_t estimate) const;

    /// Whether there is room for one more beside those at work, in the budget and on the machine.
    bool hasRoomFor(std::uint64_t estimate) const;

    void begins(std::uint64_t estimate);
    void ends(std::uint64_t estimate);
    std::size_t atWork() const;

private:
    double scale() const;

    mutable std::mutex mutex_;  // guards what follows
    double budget_;
    std::uint64_t before_;  // what the process held when it was made
    std::size_t count_ = 0, ended_ = 0;
    std::uint64_t at_work_ = 0, most_at_work_ = 0;  // sums of estimates
};

}  // namespace betamesh
