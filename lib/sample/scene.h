// Interface of sample scenes, and the functions that create them.

#pragma once

#include "sample/sample.h"

namespace betamesh {

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
