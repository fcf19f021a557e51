// Each stage over decades of particles. items_per_second is particles per second, where nothing else is said.

#include "bench_clouds.h"
#include "core/parallel.h"
#include "exact/near_surface.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "skin/arc_points.h"
#include "skin/ball_boundary.h"
#include "skin/ball_faces.h"
#include "skin/boundary_samples.h"
#include "skin/complete_mesh.h"
#include "skin/face_points.h"
#include "skin/skin_frame.h"
#include "skin/smooth_coherent.h"
#include "skin/spacing.h"
#include "skin/survivors.h"
#include "skin/velocity.h"
#include "support/temporary_folder.h"

#include <benchmark/benchmark.h>

#include <string>

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
    const std::vector<std::uint32_t> exposed = survivors(snapped);
    for (auto _ : state) benchmark::DoNotOptimize(ballBoundary(snapped, exposed));
    count(state, particles);
}

// On one core: what smoothing takes beside a tessellation, velocities included. items_per_second: vertices.
void smoothing(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const SnappedParticles snapped = snapParticles(particles, kRadius);
    const Icosphere directions = icosphereOf(0.37);
    BallBoundary boundary = ballBoundary(snapped, survivors(snapped), directions.position);
    groupFaces(snapped, boundary);
    const std::vector<Moving> balls = movingBalls(boundary, particles);
    const Spins spun = spinsOfBalls(boundary, balls, particles);
    ArcSubdivision subdivision;
    subdivision.appearance = Appearance::gradual;
    const ArcNetwork network =
        arcPoints(boundary, balls, spun.of_points, movingVertices(particles, snapped, boundary, balls), subdivision);
    const FacePoints points = facePoints(snapped, boundary, balls, spun.of_points, directions);
    const BetaMesh mesh =
        completeTessellation(boundary, balls, spun.of_points, network, points, subdivision.appearance);
    withThreads(1, [&] {
        for (auto _ : state) {
            state.PauseTiming();
            BetaMesh smooth = mesh;
            state.ResumeTiming();
            const Spins spins = spinsOfBalls(boundary, balls, particles);
            CoherentSmoother(boundarySamples(boundary, balls, spins.of_points, network, points),
                             {kRadius, 2.8 * kRadius, 1, 0})
                .smooth(smooth);
            slideWithParticles(boundary, balls, spins.of_liquid, smooth);
        }
    });
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.vertex.size()));
}

void wholeFrame(benchmark::State& state, Particles (*cloud)(std::size_t n)) {
    const Particles particles = cloud(static_cast<std::size_t>(state.range(0)));
    SkinParams params;
    params.radius = kRadius;
    for (auto _ : state) benchmark::DoNotOptimize(skinFrame(particles, params));
    count(state, particles);
}

// From the system's cache.
void reading(benchmark::State& state, const std::string& extension) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    const TemporaryFolder folder;
    const std::string file = folder / ("particles" + extension);
    writeParticles(file, particles);
    for (auto _ : state) benchmark::DoNotOptimize(readParticles(file));
    count(state, particles);
}

// Triangles per second; the disk may still be writing.
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
    for (auto _ : state) benchmark::DoNotOptimize(spacing(particles.position));
    count(state, particles);
}

void decades(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(10)->Range(1000, 1000000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void tensOfThousands(benchmark::internal::Benchmark* bench) {
    bench->RangeMultiplier(10)->Range(1000, 100000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

BENCHMARK(culling)->Apply(decades);
BENCHMARK(snapping)->Apply(decades);
BENCHMARK(boundary)->Apply(decades);
BENCHMARK(smoothing)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, splash, splash)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, spray, spray)->Apply(decades);
BENCHMARK_CAPTURE(wholeFrame, dense_sheet, denseSheet)->Apply(tensOfThousands);
BENCHMARK_CAPTURE(wholeFrame, dense_thread, denseThread)->Apply(tensOfThousands);
BENCHMARK_CAPTURE(reading, ply, ".ply")->Apply(decades);
BENCHMARK_CAPTURE(reading, bgeo_gz, ".bgeo.gz")->Apply(decades);
BENCHMARK_CAPTURE(reading, vdb, ".vdb")->Apply(decades);
BENCHMARK_CAPTURE(writing, ply, ".ply")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, bgeo_gz, ".bgeo.gz")->Apply(tensOfThousands);
BENCHMARK_CAPTURE(writing, obj, ".obj")->Apply(tensOfThousands);
BENCHMARK(estimatingSpacing)->Apply(decades);

}  // namespace betamesh
