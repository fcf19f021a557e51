// Scenes simulated by the liquid solver. y is up; world units are metres in dambreak.

#include "base/random.h"
#include "sample/liquid.h"
#include "sample/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {

namespace {

class LiquidScene : public Scene {
public:
    LiquidScene(double frames_per_second, double cell) : frames_per_second_(frames_per_second), cell_(cell) {}

    Particles frame(int number) final {
        if (number < reached_ || liquid_.id.empty()) {
            liquid_ = initial();
            reached_ = std::min(number, 1);
        }
        for (reached_ = std::max(reached_, 1); reached_ < number; ++reached_)
            advance(liquid_, surroundings_, 1 / frames_per_second_);

        const std::size_t n = liquid_.id.size();
        Particles particles;
        particles.position.resize(n);
        particles.velocity.resize(n);
        particles.id.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t row = liquid_.id[i];
            particles.position[row] = Vec3f((liquid_.position[i] - origin_) * cell_);
            particles.velocity[row] = Vec3f(liquid_.moved[i] * cell_);
            particles.id[row] = row;
        }
        return particles;
    }
    double spacing() const final { return cell_ / 2; }

protected:
    virtual Liquid initial() const = 0;

    double frames_per_second_, cell_;
    Surroundings surroundings_;
    Vec3 origin_{0, 0, 0};  // of the world's coordinates, in cells

private:
    Liquid liquid_;
    int reached_ = 1;
};

// Adds a jittered block of particles at half a cell's distance, layer by layer along y. low: cells; size: particles.
void fill(Liquid& liquid, const Vec3& low, const std::array<std::size_t, 3>& size, std::uint64_t seed) {
    for (std::size_t y = 0; y < size[1]; ++y)
        for (std::size_t z = 0; z < size[2]; ++z)
            for (std::size_t x = 0; x < size[0]; ++x) {
                const auto id = static_cast<std::uint32_t>(liquid.id.size());
                const Vec3 index(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
                liquid.position.push_back(low + (index + Vec3(0.5, 0.5, 0.5) + Random(seed, id).cube() * 0.2) * 0.5);
                liquid.id.push_back(id);
            }
    liquid.velocity.resize(liquid.id.size(), Vec3(0, 0, 0));
    liquid.gradient.resize(liquid.id.size(), {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)});
    liquid.moved = liquid.velocity;
}

// A column of liquid, about one unit along each axis, at the end of a tank three units long and one wide, with an
// obstacle on the floor.
class DamBreak final : public LiquidScene {
public:
    explicit DamBreak(const SampleParams& params) : DamBreak(params, across(params)) {}

protected:
    Liquid initial() const override {
        Liquid liquid;
        fill(liquid, {0, 0, 0}, {2 * across_, layers_, 2 * across_}, seed_);
        return liquid;
    }

private:
    static std::size_t across(const SampleParams& params) {
        return static_cast<std::size_t>(
            std::max(1.0, std::round(std::cbrt(static_cast<double>(params.particles) / 8))));
    }
    // across: cells per world unit
    DamBreak(const SampleParams& params, std::size_t across)
        : LiquidScene(params.frames_per_second, 1 / static_cast<double>(across)),
          across_(across),
          layers_(std::max<std::size_t>(1, (params.particles + 2 * across * across) / (4 * across * across))),
          seed_(params.seed) {
        const auto n = static_cast<double>(across);
        const auto cells = [&](double units) { return static_cast<std::int64_t>(std::round(units * n)); };
        surroundings_.gravity = {0, -9.81 * n, 0};
        surroundings_.cohesion = 6;
        surroundings_.tank = true;
        surroundings_.tank_box = {{0, 0, 0}, {cells(3), 0, cells(1)}};
        surroundings_.obstacle = {{cells(1.5), 0, cells(0.3)}, {cells(1.8), cells(0.5), cells(0.7)}};
    }

    std::size_t across_, layers_;
    std::uint64_t seed_;
};

// In the plane z = 0: a column one unit wide and high collapses in a tank three units long. The tank is one cell deep
// and all particles are in its middle plane, so that no force acts across the plane.
class PlaneDamBreak final : public LiquidScene {
public:
    explicit PlaneDamBreak(const SampleParams& params)
        : PlaneDamBreak(params, static_cast<std::size_t>(
                                    std::max(1.0, std::round(std::sqrt(static_cast<double>(params.particles) / 4))))) {}

protected:
    Liquid initial() const override {
        Liquid liquid;
        fill(liquid, {0, 0, 0}, {2 * across_, layers_, 1}, seed_);
        for (Vec3& p : liquid.position) p.z = origin_.z;
        return liquid;
    }

private:
    // across: cells per world unit
    PlaneDamBreak(const SampleParams& params, std::size_t across)
        : LiquidScene(params.frames_per_second, 1 / static_cast<double>(across)),
          across_(across),
          layers_(std::max<std::size_t>(1, (params.particles + across) / (2 * across))),
          seed_(params.seed) {
        const auto n = static_cast<std::int64_t>(across);
        surroundings_.gravity = {0, -9.81 * static_cast<double>(n), 0};
        surroundings_.cohesion = 6;
        surroundings_.tank = true;
        surroundings_.tank_box = {{0, 0, 0}, {3 * n, 0, 1}};
        surroundings_.particles_per_cell = 4;
        origin_ = {0, 0, 0.5};
    }

    std::size_t across_, layers_;
    std::uint64_t seed_;
};

// A unit cube centred on the origin that rotates about an oblique axis, initially at 0.9 revolutions per second.
class RotatingCube final : public LiquidScene {
public:
    explicit RotatingCube(const SampleParams& params)
        : LiquidScene(params.frames_per_second, 2 / std::cbrt(static_cast<double>(params.particles))),
          side_(static_cast<std::size_t>(std::max(1.0, std::round(2 / cell_)))),
          layers_(std::max<std::size_t>(1, (params.particles + side_ * side_ / 2) / (side_ * side_))),
          seed_(params.seed) {
        surroundings_.cohesion = 18;
    }

protected:
    Liquid initial() const override {
        Liquid liquid;
        const Vec3 half(static_cast<double>(side_) / 4, static_cast<double>(layers_) / 4,
                        static_cast<double>(side_) / 4);
        fill(liquid, -half, {side_, layers_, side_}, seed_);
        const Vec3 angular_velocity = Vec3(0.3, 1, 0.2).normalized() * (0.9 * 2 * std::numbers::pi);
        for (std::size_t i = 0; i < liquid.id.size(); ++i) {
            liquid.velocity[i] = cross(angular_velocity, liquid.position[i]);
            liquid.gradient[i] = {Vec3(0, -angular_velocity.z, angular_velocity.y),
                                  Vec3(angular_velocity.z, 0, -angular_velocity.x),
                                  Vec3(-angular_velocity.y, angular_velocity.x, 0)};
        }
        liquid.moved = liquid.velocity;
        return liquid;
    }

private:
    std::size_t side_, layers_;
    std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<Scene> makeDamBreak(const SampleParams& params) { return std::make_unique<DamBreak>(params); }
std::unique_ptr<Scene> makePlaneDamBreak(const SampleParams& params) { return std::make_unique<PlaneDamBreak>(params); }
std::unique_ptr<Scene> makeRotatingCube(const SampleParams& params) { return std::make_unique<RotatingCube>(params); }

}  // namespace betamesh
