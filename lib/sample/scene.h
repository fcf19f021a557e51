// What a sample is made of, and the makers of all scenes.

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

/// params.particles > 0; the name is not looked at.
using SceneMaker = std::unique_ptr<Scene> (*)(const SampleParams& params);

// By formula.
std::unique_ptr<Scene> makeDrop(const SampleParams& params);
std::unique_ptr<Scene> makeBubble(const SampleParams& params);
std::unique_ptr<Scene> makePuddle(const SampleParams& params);
std::unique_ptr<Scene> makeSheet(const SampleParams& params);
std::unique_ptr<Scene> makeTendril(const SampleParams& params);
std::unique_ptr<Scene> makeLattice(const SampleParams& params);
std::unique_ptr<Scene> makeJitter(const SampleParams& params);

// By solver.
std::unique_ptr<Scene> makeDamBreak(const SampleParams& params);
std::unique_ptr<Scene> makePlaneDamBreak(const SampleParams& params);
std::unique_ptr<Scene> makeRotatingCube(const SampleParams& params);

}  // namespace betamesh
