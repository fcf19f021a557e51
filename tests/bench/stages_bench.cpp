// Benchmarks of each stage for thousands to millions of particles. items_per_second is particles per second unless
// stated otherwise.

#include "base/dual.h"
#include "base/parallel.h"
#include "bench_clouds.h"
#include "betamesh/skin.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "skin/ball_boundary.h"
#include "skin/coverage.h"
#include "skin/near_surface.h"
#include "skin/spacing.h"
#include "support/temporary_folder.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace betamesh {

namespace {

constexpr double kRadius = 1.5;

void count(benchmark::State& state, const Particles& particles) {
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(particles.size()));
}

NearSurface nearSurfaceOf(const Particles& particles) {
    SkinParams params;
    params.radius = kRadius;
    NearSurfaceFinder finder(params);
    finder.add(particles.position);
    return finder.find();
}

void culling(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(nearSurfaceOf(particles));
    count(state, particles);
}

void snapping(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const NearSurface near = nearSurfaceOf(particles);
    for (auto _ : state) benchmark::DoNotOptimize(snapParticles(particles, kRadius, near));
    count(state, particles);
}

void boundary(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    const std::vector<std::uint32_t> exposed = exposureCandidates(snapped);
    for (auto _ : state) benchmark::DoNotOptimize(ballBoundary(snapped, exposed));
    count(state, particles);
}

// threads: 0: all. Counters are the stages of the frame, in nanoseconds per particle.
void wholeFrame(benchmark::State& state, Particles (*cloud)(std::size_t n), int threads) {
    const Particles particles = cloud(static_cast<std::size_t>(state.range(0)));
    SkinParams params;
    params.radius = kRadius;
    using Clock = std::chrono::steady_clock;
    std::map<std::string, double, std::less<>> seconds;
    withThreads(threads > 0 ? threads : static_cast<int>(threadsHere()), [&] {
        for (auto _ : state) {
            Clock::time_point begin = Clock::now();
            benchmark::DoNotOptimize(skinFrame(particles, params, [&](Stage stage) {
                const Clock::time_point end = Clock::now();
                seconds[std::string(nameOf(stage))] +=
                    std::chrono::duration<double>(end - std::exchange(begin, end)).count();
            }));
        }
    });
    for (const auto& [stage, sum] : seconds)
        state.counters[stage] =
            benchmark::Counter(sum * 1e9 / static_cast<double>(particles.size()), benchmark::Counter::kAvgIterations);
    count(state, particles);
}

// Memory bandwidth: bytes per second, read and written, of copying an array, and of gathering rows of the size of a
// vertex with its velocity from random positions. The argument is the size of the array in bytes.
void copying(benchmark::State& state) {
    const auto bytes = static_cast<std::size_t>(state.range(0));
    const std::vector<std::byte> from(bytes, std::byte{1});
    std::vector<std::byte> to(bytes);
    for (auto _ : state) {
        parallelRanges(bytes, 4096, [&](std::size_t begin, std::size_t end) {
            std::memcpy(to.data() + begin, from.data() + begin, end - begin);
        });
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(2 * state.iterations() * state.range(0));
}

void gathering(benchmark::State& state) {
    const std::size_t rows = static_cast<std::size_t>(state.range(0)) / sizeof(DualVec3);
    const std::vector<DualVec3> from(rows);
    std::vector<std::uint32_t> row(rows);
    std::iota(row.begin(), row.end(), 0U);
    std::shuffle(row.begin(), row.end(), std::mt19937(1));
    for (auto _ : state)
        parallelRanges(rows, 128, [&](std::size_t begin, std::size_t end) {
            DualVec3 sum;
            for (std::size_t i = begin; i < end; ++i) sum = sum + from[row[i]];
            benchmark::DoNotOptimize(sum);
        });
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(rows * sizeof(DualVec3)));
}

// Reads from the system's cache.
void reading(benchmark::State& state, const std::string& extension) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const TemporaryFolder folder;
    const std::string file = folder / ("particles" + extension);
    writeParticles(file, particles);
    for (auto _ : state) benchmark::DoNotOptimize(readParticles(file));
    count(state, particles);
}

// items_per_second is triangles per second. Does not wait for the disk.
void writing(benchmark::State& state, const std::string& extension) {
    SkinParams params;
    params.radius = kRadius;
    const Mesh mesh = skinFrame(splash(static_cast<std::size_t>(state.range(0))), params).mesh;
    const TemporaryFolder folder;
    for (auto _ : state) writeMesh(folder / ("mesh" + extension), mesh);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

void estimatingSpacing(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(medianSixNearest(particles.position));
    count(state, particles);
}

void decades(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(10)->Range(1000, 1000000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void tensOfThousands(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(10)->Range(1000, 100000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void sizesOfMemory(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(16)->Range(1 << 16, 1 << 28)->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

BENCHMARK(culling)->Apply(decades);
BENCHMARK(snapping)->Apply(decades);
BENCHMARK(boundary)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, splash, splash, 0)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, splash_on_one_thread, splash, 1)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, calm, calm, 0)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, spray, spray, 0)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, dense_sheet, denseSheet, 0)->Apply(tensOfThousands);
BENCHMARK_CAPTURE(wholeFrame, dense_thread, denseThread, 0)->Apply(tensOfThousands);
BENCHMARK_CAPTURE(reading, ply, ".ply")->Apply(decades);
BENCHMARK_CAPTURE(reading, bgeo_gz, ".bgeo.gz")->Apply(decades);
BENCHMARK_CAPTURE(reading, bgeo_sc, ".bgeo.sc")->Apply(decades);
BENCHMARK_CAPTURE(reading, vdb, ".vdb")->Apply(decades);
BENCHMARK_CAPTURE(writing, ply, ".ply")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, bgeo_gz, ".bgeo.gz")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, bgeo, ".bgeo")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, bgeo_sc, ".bgeo.sc")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, vtp, ".vtp")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, obj, ".obj")->Apply(tensOfThousands);
BENCHMARK(estimatingSpacing)->Apply(decades);
BENCHMARK(copying)->Apply(sizesOfMemory);
BENCHMARK(gathering)->Apply(sizesOfMemory);

}  // namespace betamesh
