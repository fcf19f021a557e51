// Particle sequences to try and test with: no file needed, no two runs different.

#pragma once

#include "betamesh/particles.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace betamesh {

struct SampleParams {
    std::string name;           ///< one of samples()
    std::size_t particles = 0;  ///< about so many; 0: the scene's default
    std::uint64_t seed = 1;
    double frames_per_second = 24;  ///< > 0
};

struct SampleInfo {
    std::string name;
    std::string description;  ///< one line
    std::size_t particles;    ///< by default
};

/// Every scene there is, in the order in which to list them.
std::vector<SampleInfo> samples();

class Scene;

/// A sequence. Frame 1 is the initial state; the scenes that a solver moves stand still before it.
///
/// Velocities are world units per second: the derivative of the path where there is a formula, what the
/// particles last moved with where a solver makes the motion. Row i is the particle with id i.
///
/// same    bytes for the same params and frame, whatever the order of asking and the number of threads
/// cost    dambreak and rotcube integrate from frame 1 to the frame asked for and remember where they are:
///         ascending frames are cheap, an earlier one starts again. The others have a formula
/// errors  an unknown name (lists the known ones); frames per second that are not positive
class Sample {
public:
    explicit Sample(const SampleParams& params);
    ~Sample();
    Sample(Sample&&) noexcept;
    Sample& operator=(Sample&&) noexcept;

    Particles frame(int number);
    /// Nominal distance between neighbours, world units.
    double spacing() const;

private:
    std::unique_ptr<Scene> scene_;
};

}  // namespace betamesh
