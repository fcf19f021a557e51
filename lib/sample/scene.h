// Parameters and interface of sample scenes, and the functions that create them.

#pragma once

#include "betamesh/particles.h"

#include <cstdint>
#include <memory>
#include <string>

namespace betamesh {

struct SampleParams {
    std::string name;           ///< one of samples()
    std::size_t particles = 0;  ///< approximate number; 0: the scene's default
    std::uint64_t seed = 1;
    double frames_per_second = 24;  ///< > 0
};

class Scene {
public:
    virtual ~Scene() = default;
    /// Row i has id i.
    virtual Particles frame(int number) = 0;
    /// Nominal distance between neighbours, world units.
    virtual double spacing() const = 0;
};

/// in      params.particles > 0; params.name is ignored
using SceneMaker = std::unique_ptr<Scene> (*)(const SampleParams& params);

// Scenes given by formulas.
std::unique_ptr<Scene> makeDrop(const SampleParams& params);
std::unique_ptr<Scene> makeBubble(const SampleParams& params);
std::unique_ptr<Scene> makePuddle(const SampleParams& params);
std::unique_ptr<Scene> makeSheet(const SampleParams& params);
std::unique_ptr<Scene> makeTendril(const SampleParams& params);
std::unique_ptr<Scene> makeLattice(const SampleParams& params);
std::unique_ptr<Scene> makeJitter(const SampleParams& params);

// Simulated scenes.
std::unique_ptr<Scene> makeDamBreak(const SampleParams& params);
std::unique_ptr<Scene> makePlaneDamBreak(const SampleParams& params);
std::unique_ptr<Scene> makeRotatingCube(const SampleParams& params);

}  // namespace betamesh
