// The alpha mesh by other means, on the same particles in the same run.

#include "bench_clouds.h"
#include "skin/skin_frame.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Fixed_alpha_shape_3.h>
#include <CGAL/Fixed_alpha_shape_cell_base_3.h>
#include <CGAL/Fixed_alpha_shape_vertex_base_3.h>
#include <benchmark/benchmark.h>

namespace betamesh {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Fixed_alpha_shape_vertex_base_3<Kernel>;
using CellBase = CGAL::Fixed_alpha_shape_cell_base_3<Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;
using AlphaShape = CGAL::Fixed_alpha_shape_3<Triangulation>;

constexpr double kRadius = 1.5;

void alphaMeshOurs(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    SkinParams params;
    params.radius = kRadius;
    params.surface = SurfaceKind::alpha;
    std::size_t triangles = 0;
    for (auto _ : state) triangles = skinFrame(particles, params).report.alpha_triangles;
    state.counters["triangles"] = static_cast<double>(triangles);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(particles.size()));
}

void alphaMeshCgal(benchmark::State& state) {
    const Particles particles = splash(static_cast<std::size_t>(state.range(0)));
    std::vector<Kernel::Point_3> points;
    for (const Vec3f& p : particles.position) points.emplace_back(p.x, p.y, p.z);
    std::size_t triangles = 0;
    for (auto _ : state) {
        const AlphaShape shape(points.begin(), points.end(), kRadius * kRadius);
        triangles = 0;
        for (auto facet = shape.finite_facets_begin(); facet != shape.finite_facets_end(); ++facet) {
            const auto kind = shape.classify(*facet);
            triangles += kind == AlphaShape::REGULAR ? 1 : kind == AlphaShape::SINGULAR ? 2 : 0;
        }
    }
    state.counters["triangles"] = static_cast<double>(triangles);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(particles.size()));
}

void sizes(benchmark::internal::Benchmark* bench) {
    bench->Arg(10000)->Arg(110000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

BENCHMARK(alphaMeshOurs)->Apply(sizes);
BENCHMARK(alphaMeshCgal)->Apply(sizes);

}  // namespace betamesh
