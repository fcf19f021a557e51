#include "skin/structure.h"

#include "betamesh/error.h"
#include "skin/coverage.h"
#include "skin/features.h"

#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace betamesh {

namespace {

std::string describe(const Particles& particles, std::uint32_t row) {
    const Vec3f& p = particles.position[row];
    return "particle " + std::to_string(row) + " (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
           std::to_string(p.z) + ")";
}

// Fills in a structure from snapped particles. Returns the edge that makes the boundary invalid, if boundaryOf() finds
// one.
template <typename BoundaryOf>
std::optional<UnpairedEdge> buildStructure(const Particles& particles, const SkinParams& params,
                                           SnappedParticles&& snapped, const BoundaryOf& boundaryOf,
                                           const std::vector<Vec3>& directions, Structure& structure) {
    structure = {};
    structure.snapped = std::move(snapped);
    structure.distinct_particles = structure.snapped.size();
    structure.left_out = removeDroplets(particles, params.features, structure.snapped, structure.spheres);
    for (;;) {
        std::variant<BallBoundary, UnpairedEdge> built =
            boundaryOf(structure.snapped, exposureCandidates(structure.snapped), directions);
        if (const auto* unpaired = std::get_if<UnpairedEdge>(&built)) return *unpaired;
        structure.boundary = std::move(std::get<BallBoundary>(built));
        if (params.features.tendrils == Tendrils::mesh) return std::nullopt;
        // Without these tendrils the alpha mesh only gains triangles, and seldom a new tendril: repeat.
        const std::vector<std::uint32_t> tendrils = tendrilParticles(structure.boundary);
        if (tendrils.empty()) return std::nullopt;
        addSpheres(particles, structure.snapped, tendrils, structure.spheres);
        structure.tendril_particles += tendrils.size();
        structure.snapped = withoutRows(structure.snapped, tendrils);
    }
}

Structure exactStructure(const Particles& particles, const NearSurface& near, const SkinParams& params,
                         const ParticleSizes& sizes, const std::vector<Vec3>& directions) {
    const auto boundaryOf = [&](const SnappedParticles& snapped, const std::vector<std::uint32_t>& exposed,
                                const std::vector<Vec3>& towards) {
        return ballBoundary(snapped, exposed, towards,
                            params.surface == SurfaceKind::alpha ? ArcTracing::none : ArcTracing::traced);
    };
    Structure structure;
    buildStructure(particles, params,
                   sizes.radius.empty() ? snapParticles(particles, params.radius, near)
                                        : snapParticles(particles, sizes.radius, near),
                   boundaryOf, directions, structure);
    std::vector<double>& rate = structure.boundary.radius_rate;
    for (const std::uint32_t row : structure.boundary.row)
        if (!sizes.rate.empty()) rate.push_back(sizes.rate[row]);
    return structure;
}

// The paper's method: predicates in floating point, validated by counting edges, repeated on perturbed particles.
Structure floatStructure(const Particles& particles, const SkinParams& params, const std::vector<Vec3>& directions) {
    for (int attempt = 0;; ++attempt) {
        Structure structure;
        const auto edge = buildStructure(particles, params,
                                         snapParticles(particles, params.radius, Jitter{params.tolerance, attempt}),
                                         ballBoundaryInFloats, directions, structure);
        structure.retries = attempt;
        if (!edge) return structure;
        if (attempt >= params.retries)
            throw Error("floating-point predicates left the alpha mesh open after " + std::to_string(params.retries) +
                        " retries: the edge from " + describe(particles, edge->from) + " to " +
                        describe(particles, edge->to) + " " + std::string(edge->fault) +
                        ", but every oriented edge needs exactly one opposite. Use exact predicates, more retries or a "
                        "larger tolerance");
    }
}

}  // namespace

Structure exposedStructure(const Particles& particles, const NearSurface& near, const SkinParams& params,
                           const ParticleSizes& sizes, Icosphere&& directions) {
    Structure structure = params.predicates == PredicateKind::exact
                              ? exactStructure(particles, near, params, sizes, directions.position)
                              : floatStructure(particles, params, directions.position);
    structure.directions = std::move(directions);
    return structure;
}

}  // namespace betamesh
