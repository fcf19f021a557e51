// Scenes given by formulas for position and velocity, its derivative. Lengths are in world units, times in seconds.
// Motion starts at time 0, which is frame 1.

#include "base/angles.h"
#include "base/parallel.h"
#include "base/random.h"
#include "sample/scene.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

struct State {
    Vec3 position, velocity;
};

// Value of a function of time, and its derivative.
struct TimeValue {
    double value, slope;
};

// 0 until `start`, then rises towards 1 and reaches 1/2 after a further `half` seconds. Its derivative is continuous.
TimeValue rise(double seconds, double start, double half) {
    const double t = (seconds - start) / half;
    if (t <= 0) return {0, 0};
    const double d = 1 + t * t;
    return {t * t / d, 2 * t / (d * d * half)};
}

class FormulaScene : public Scene {
public:
    FormulaScene(double frames_per_second, double spacing) : frames_per_second_(frames_per_second), spacing_(spacing) {}

    Particles frame(int number) final {
        const double seconds = (static_cast<double>(number) - 1) / frames_per_second_;
        Particles particles;
        particles.position.resize(count());
        particles.velocity.resize(count());
        particles.id.resize(count());
        parallelFor(count(), 4096, [&](std::size_t i) {
            const State state = at(i, seconds);
            particles.position[i] = Vec3f(state.position);
            particles.velocity[i] = Vec3f(state.velocity);
            particles.id[i] = i;
        });
        return particles;
    }
    double spacing() const final { return spacing_; }

protected:
    virtual std::size_t count() const = 0;
    virtual State at(std::size_t particle, double seconds) const = 0;

private:
    double frames_per_second_, spacing_;
};

std::size_t atLeastOne(double n) { return static_cast<std::size_t>(std::max(1.0, std::round(n))); }

// A lattice of about n points: equally many along x and y, and the number of layers that comes closest to n.
struct LatticePoints {
    std::size_t x, y, z;
    explicit LatticePoints(std::size_t n) {
        x = y = atLeastOne(std::cbrt(static_cast<double>(n)));
        z = atLeastOne(static_cast<double>(n) / static_cast<double>(x * y));
    }
    std::size_t size() const { return x * y * z; }
    Vec3 point(std::size_t i) const {
        return {static_cast<double>(i % x), static_cast<double>(i / x % y), static_cast<double>(i / (x * y))};
    }
};

// A power of two, so that all coordinates are exact in single precision.
constexpr double kLatticeSpacing = 0x1p-6;

class Lattice : public FormulaScene {
public:
    explicit Lattice(const SampleParams& params)
        : FormulaScene(params.frames_per_second, kLatticeSpacing), points_(params.particles) {}

protected:
    std::size_t count() const override { return points_.size(); }
    State at(std::size_t i, double) const override { return {points_.point(i) * kLatticeSpacing, {0, 0, 0}}; }

    LatticePoints points_;
};

class Jitter final : public Lattice {
public:
    explicit Jitter(const SampleParams& params) : Lattice(params), seed_(params.seed) {}

protected:
    State at(std::size_t i, double seconds) const override {
        State state = Lattice::at(i, seconds);
        Random random(seed_, i);
        for (int axis = 0; axis < 3; ++axis) {
            const double turns_per_second = random.between(0.2, 0.6), phase = random.between(0, kTwoPi);
            const double amplitude = 0.25 * kLatticeSpacing, angle = kTwoPi * turns_per_second * seconds + phase;
            state.position[axis] += amplitude * std::sin(angle);
            state.velocity[axis] += amplitude * kTwoPi * turns_per_second * std::cos(angle);
        }
        return state;
    }

private:
    std::uint64_t seed_;
};

// A sheet one unit wide with two waves of different directions, drifting.
class Sheet final : public FormulaScene {
public:
    explicit Sheet(const SampleParams& params)
        : Sheet(params, atLeastOne(std::sqrt(static_cast<double>(params.particles)))) {}

protected:
    std::size_t count() const override { return columns_ * rows_; }
    State at(std::size_t i, double seconds) const override {
        Random random(seed_, i);
        const double x = (static_cast<double>(i % columns_) + random.between(-0.25, 0.25)) * spacing();
        const double z = (static_cast<double>(i / columns_) + random.between(-0.25, 0.25)) * spacing();
        const double a = kTwoPi * (1.25 * x + 0.5 * z - 0.6 * seconds),
                     b = kTwoPi * (0.9 * z - 0.3 * x + 0.35 * seconds);
        const Vec3 drift(0.1, 0, 0.05);
        return {Vec3(x, 0.08 * std::sin(a) + 0.05 * std::sin(b), z) + drift * seconds,
                Vec3(0, kTwoPi * (0.05 * 0.35 * std::cos(b) - 0.08 * 0.6 * std::cos(a)), 0) + drift};
    }

private:
    Sheet(const SampleParams& params, std::size_t columns)
        : FormulaScene(params.frames_per_second, 1 / static_cast<double>(columns)),
          columns_(columns),
          rows_(atLeastOne(static_cast<double>(params.particles) / static_cast<double>(columns))),
          seed_(params.seed) {}

    std::size_t columns_, rows_;
    std::uint64_t seed_;
};

// A pool 2 × 2 units wide and 0.5 deep, a drop of radius 0.3 above it and one isolated particle. The drop and the
// particle sink slowly into the pool and stay there; a wave spreads over the pool and decays with the distance from the
// drop.
class Drop final : public FormulaScene {
public:
    explicit Drop(const SampleParams& params)
        : FormulaScene(params.frames_per_second,
                       std::cbrt((kWidth * kWidth * kDepth + kTwoPi * 2 / 3 * kRadius * kRadius * kRadius) /
                                 static_cast<double>(params.particles))),
          seed_(params.seed) {
        fill({-kWidth / 2, -kDepth, -kWidth / 2}, {kWidth / 2, 0, kWidth / 2}, [](const Vec3&) { return true; });
        pool_ = points_.size();
        const Vec3 corner(kRadius, kRadius, kRadius);
        fill(-corner, corner, [](const Vec3& p) { return p.length() <= kRadius; });
        for (std::size_t i = 0; i < points_.size(); ++i) points_[i] += Random(seed_, i).cube() * (0.2 * spacing());
        points_.push_back({0.6 * kWidth / 2, 3 * spacing(), 0});  // the isolated particle
    }

protected:
    std::size_t count() const override { return points_.size(); }
    State at(std::size_t i, double seconds) const override {
        const Vec3 p = points_[i];
        if (i + 1 == points_.size()) {
            const TimeValue sinking = rise(seconds, 0, 1.0);
            return {p - Vec3(0, 3 * spacing() * sinking.value, 0), {0, -3 * spacing() * sinking.slope, 0}};
        }
        if (i >= pool_) {
            const TimeValue sinking = rise(seconds, 0, 0.6);
            const double height = kRadius + 4 * spacing(), fall = 1.5 * height;
            return {p + Vec3(0, height - fall * sinking.value, 0), {0, -fall * sinking.slope, 0}};
        }
        // The wave starts when the drop touches the pool. Its amplitude is zero at the floor.
        const TimeValue wave_growth = rise(seconds, 0.3, 0.5);
        const double from_axis = std::hypot(p.x, p.z), angle = kTwoPi * (1.5 * from_axis - 1.2 * seconds);
        const double amplitude = 0.06 * std::exp(-1.5 * from_axis) * (1 + p.y / kDepth);
        return {
            p + Vec3(0, amplitude * wave_growth.value * std::sin(angle), 0),
            {0, amplitude * (wave_growth.slope * std::sin(angle) - wave_growth.value * kTwoPi * 1.2 * std::cos(angle)),
             0}};
    }

private:
    static constexpr double kWidth = 2, kDepth = 0.5, kRadius = 0.3;

    template <typename Inside>
    void fill(const Vec3& low, const Vec3& high, const Inside& inside) {
        const double dx = spacing();
        for (double z = low.z + dx / 2; z < high.z; z += dx)
            for (double y = low.y + dx / 2; y < high.y; y += dx)
                for (double x = low.x + dx / 2; x < high.x; x += dx)
                    if (inside({x, y, z})) points_.push_back({x, y, z});
    }

    std::vector<Vec3> points_;
    std::size_t pool_ = 0;  // number of points of the pool; the last point is the isolated particle
    std::uint64_t seed_;
};

// A bubble grows below the surface of a pool 2 × 2 units wide and 0.9 deep: all particles move radially away from its
// centre, as an incompressible liquid would. The liquid above becomes a dome and a thin film, and tears.
class Bubble final : public FormulaScene {
public:
    explicit Bubble(const SampleParams& params)
        : FormulaScene(params.frames_per_second,
                       std::cbrt(kWidth * kDepth * kWidth / static_cast<double>(params.particles))) {
        const double dx = spacing();
        for (double z = (dx - kWidth) / 2; z < kWidth / 2; z += dx)
            for (double y = kAbove - dx / 2; y > kAbove - kDepth; y -= dx)
                for (double x = (dx - kWidth) / 2; x < kWidth / 2; x += dx)
                    points_.push_back(Vec3(x, y, z) + Random(params.seed, points_.size()).cube() * (0.2 * dx));
    }

protected:
    std::size_t count() const override { return points_.size(); }
    // The volume within the particle's radius grows by the volume of the bubble; without 4π/3: r³ = r₀³ + a³.
    State at(std::size_t i, double seconds) const override {
        const Vec3& p = points_[i];
        const TimeValue growth = rise(seconds, 0, 0.8);
        const double before = std::max(p.length(), 1e-6 * kRadius), volume = kRadius * kRadius * kRadius;
        const double after = std::cbrt(before * before * before + volume * growth.value);
        return {p * (after / before), p * (volume * growth.slope / (3 * after * after * before))};
    }

private:
    static constexpr double kWidth = 2, kDepth = 0.9, kRadius = 0.65;
    static constexpr double kAbove = 0.3;  // height of the surface above the bubble's centre

    std::vector<Vec3> points_;
};

// In the plane z = 0: a pool 2 units wide and 0.4 deep that contains a bubble, a jet one particle thick that is pulled
// out of the pool and thins out, a drop of radius 0.15 and an isolated particle, which both sink into the pool, and a
// wave.
class Puddle final : public FormulaScene {
public:
    explicit Puddle(const SampleParams& params)
        : FormulaScene(params.frames_per_second,
                       std::sqrt((kWidth * kDepth + kTwoPi / 2 * (kRadius * kRadius - kBubble * kBubble)) /
                                 static_cast<double>(params.particles))),
          seed_(params.seed) {
        const Vec3 bubble(-0.6, -0.2, 0);
        fill({-kWidth / 2, -kDepth, 0}, {kWidth / 2, 0, 0},
             [&](const Vec3& p) { return (p - bubble).length() >= kBubble; });
        pool_ = points_.size();
        fill({-kRadius, -kRadius, 0}, {kRadius, kRadius, 0}, [](const Vec3& p) { return p.length() <= kRadius; });
        drop_ = points_.size();
        for (std::size_t i = 0; i < points_.size(); ++i)
            points_[i] += Random(seed_, i).cube() * Vec3(0.2, 0.2, 0) * spacing();
        for (double height = spacing() / 2; height < kJet; height += 0.9 * spacing())
            points_.emplace_back(0.55 + 0.4 * height * height, height, 0);
        points_.emplace_back(-0.25, 3.5 * spacing(), 0);  // the isolated particle
    }

protected:
    std::size_t count() const override { return points_.size(); }
    State at(std::size_t i, double seconds) const override {
        const Vec3 p = points_[i];
        if (i + 1 == points_.size()) {
            const TimeValue sinking = rise(seconds, 0, 1.0);
            return {p - Vec3(0, 4 * spacing() * sinking.value, 0), {0, -4 * spacing() * sinking.slope, 0}};
        }
        if (i >= drop_) {
            const TimeValue pulling = rise(seconds, 0, 1.0);
            return {p * Vec3(1, 1 + 2 * pulling.value, 1), {0, 2 * p.y * pulling.slope, 0}};
        }
        if (i >= pool_) {
            const TimeValue sinking = rise(seconds, 0, 0.6);
            const double height = kRadius + 4 * spacing(), fall = 1.5 * height;
            return {p + Vec3(0, height - fall * sinking.value, 0), {0, -fall * sinking.slope, 0}};
        }
        const TimeValue wave_growth = rise(seconds, 0.3, 0.5);
        const double angle = kTwoPi * (1.5 * std::abs(p.x) - 1.2 * seconds);
        const double amplitude = 0.05 * std::exp(-1.5 * std::abs(p.x)) * (1 + p.y / kDepth);
        return {
            p + Vec3(0, amplitude * wave_growth.value * std::sin(angle), 0),
            {0, amplitude * (wave_growth.slope * std::sin(angle) - wave_growth.value * kTwoPi * 1.2 * std::cos(angle)),
             0}};
    }

private:
    static constexpr double kWidth = 2, kDepth = 0.4, kRadius = 0.15, kBubble = 0.11, kJet = 0.35;

    template <typename Inside>
    void fill(const Vec3& low, const Vec3& high, const Inside& inside) {
        for (double y = low.y + spacing() / 2; y < high.y; y += spacing())
            for (double x = low.x + spacing() / 2; x < high.x; x += spacing())
                if (inside({x, y, 0})) points_.emplace_back(x, y, 0);
    }

    std::vector<Vec3> points_;
    std::size_t pool_ = 0, drop_ = 0;  // ends of the ranges of the pool and the drop; the jet follows
    std::uint64_t seed_;
};

// Parallel threads, from a single row of particles to a rope. Each is stretched to several times its length. Its
// particles gather in beads, and its width changes so that the volume is preserved.
class Tendril final : public FormulaScene {
public:
    explicit Tendril(const SampleParams& params) : Tendril(params, crossSections()) {}

protected:
    std::size_t count() const override { return points_.size(); }
    State at(std::size_t i, double seconds) const override {
        const Point& p = points_[i];
        // x in [0, 1] along the thread moves to stretch · (x - bead · sin(k x) / k).
        const TimeValue stretched = rise(seconds, 0, 1.2), gathered = rise(seconds, 0.2, 1.5);
        const double stretch = 1 + 3 * stretched.value, stretch_slope = 3 * stretched.slope;
        const double bead = 0.85 * gathered.value, bead_slope = 0.85 * gathered.slope;
        const double k = kTwoPi * kBeads, wave = std::sin(k * p.x) / k, crest = std::cos(k * p.x);
        const double elongation = stretch * (1 - bead * crest);  // local stretch: new length divided by original length
        const double elongation_slope = stretch_slope * (1 - bead * crest) - stretch * bead_slope * crest;
        const double width = 1 / std::sqrt(elongation), width_slope = -0.5 * width * elongation_slope / elongation;
        const Vec3 across(0, p.y, p.z), row(0, 0, p.row);
        return {Vec3(stretch * (p.x - bead * wave), 0, 0) + across * width + row,
                Vec3(stretch_slope * (p.x - bead * wave) - stretch * bead_slope * wave, 0, 0) + across * width_slope};
    }

private:
    struct Point {
        double x, y, z, row;
    };
    static constexpr double kBeads = 5;

    // Offsets of the particles across each thread, in particle spacings.
    static std::vector<std::vector<Vec3>> crossSections() {
        std::vector<std::vector<Vec3>> threads;
        for (const double radius : {0.1, 1.1, 2.1, 3.1}) {
            threads.emplace_back();
            for (int y = -4; y <= 4; ++y)
                for (int z = -4; z <= 4; ++z)
                    if (std::hypot(y, z) <= radius) threads.back().push_back(Vec3(0, y, z));
        }
        return threads;
    }

    Tendril(const SampleParams& params, const std::vector<std::vector<Vec3>>& threads)
        : Tendril(params, threads, [&] {
              std::size_t across = 0;
              for (const std::vector<Vec3>& thread : threads) across += thread.size();
              return atLeastOne(static_cast<double>(params.particles) / static_cast<double>(across));
          }()) {}

    Tendril(const SampleParams& params, const std::vector<std::vector<Vec3>>& threads, std::size_t length)
        : FormulaScene(params.frames_per_second, 1 / static_cast<double>(length)) {
        const double dx = spacing();
        for (std::size_t row = 0; row < threads.size(); ++row)
            for (const Vec3& offset : threads[row])
                for (std::size_t i = 0; i < length; ++i) {
                    const Vec3 p = offset + Random(params.seed, points_.size()).cube() * Vec3(0.5, 0.2, 0.2);
                    points_.push_back({(static_cast<double>(i) + 0.5 + p.x) * dx, p.y * dx, p.z * dx,
                                       static_cast<double>(row) * 16 * dx});
                }
    }

    std::vector<Point> points_;
};

}  // namespace

std::unique_ptr<Scene> makeDrop(const SampleParams& params) { return std::make_unique<Drop>(params); }
std::unique_ptr<Scene> makeBubble(const SampleParams& params) { return std::make_unique<Bubble>(params); }
std::unique_ptr<Scene> makePuddle(const SampleParams& params) { return std::make_unique<Puddle>(params); }
std::unique_ptr<Scene> makeSheet(const SampleParams& params) { return std::make_unique<Sheet>(params); }
std::unique_ptr<Scene> makeTendril(const SampleParams& params) { return std::make_unique<Tendril>(params); }
std::unique_ptr<Scene> makeLattice(const SampleParams& params) { return std::make_unique<Lattice>(params); }
std::unique_ptr<Scene> makeJitter(const SampleParams& params) { return std::make_unique<Jitter>(params); }

}  // namespace betamesh
