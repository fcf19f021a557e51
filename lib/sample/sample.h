// Generated particle sequences for demonstrations and tests, reproducible to the byte.

#pragma once

#include "betamesh/particles.h"
#include "sample/scene.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace betamesh {

struct SampleInfo {
    std::string name;
    std::string description;  ///< one line
    std::size_t particles;    ///< default number
};

/// All scenes, in the order in which to list them.
std::vector<SampleInfo> samples();

/// A particle sequence. Frame 1 is the initial state; earlier frames of simulated scenes equal it.
///
/// Velocities are in world units per second. Scenes given by formulas have the derivative of the position, simulated
/// scenes the displacement in the last time step divided by its duration. Row i is the particle with id i.
///
/// same    bytes for the same parameters and frame, in any order of requests and for any thread count
/// cost    simulated scenes (dambreak, dambreak2d, rotcube) integrate from the last requested frame, or from frame 1 if
///         an earlier frame is requested; all others evaluate a formula
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
