// Each stage over decades of particles. items_per_second is particles per second.

#include "bench_clouds.h"
#include "skin/ball_boundary.h"
#include "skin/skin_frame.h"
#include "skin/spacing.h"
#include "skin/survivors.h"

#include <benchmark/benchmark.h>

namespace betamesh {

namespace {

constexpr double kRadius = 1.5;

void count(benchmark::State& state, const Particles& particles) {
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(particles.size()));
}

void snapping(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(snapParticles(particles, kRadius));
    count(state, particles);
}

void culling(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    for (auto _ : state) benchmark::DoNotOptimize(survivors(snapped));
    count(state, particles);
}

void boundary(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    const std::vector<std::uint32_t> exposed = survivors(snapped);
    for (auto _ : state) benchmark::DoNotOptimize(ballBoundary(snapped, exposed));
    count(state, particles);
}

void wholeFrame(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    SkinParams params;
    params.radius = kRadius;
    for (auto _ : state) benchmark::DoNotOptimize(skinFrame(particles, params));
    count(state, particles);
}

void estimatingSpacing(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(spacing(particles.position));
    count(state, particles);
}

void decades(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(10)->Range(1000, 1000000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

BENCHMARK(snapping)->Apply(decades);
BENCHMARK(culling)->Apply(decades);
BENCHMARK(boundary)->Apply(decades);
BENCHMARK(wholeFrame)->Apply(decades);
BENCHMARK(estimatingSpacing)->Apply(decades);

}  // namespace betamesh
