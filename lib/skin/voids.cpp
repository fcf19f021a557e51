#include "skin/voids.h"

#include "base/cell_grid.h"
#include "base/index.h"
#include "base/parallel.h"
#include "skin/ball_boundary.h"
#include "skin/constants.h"
#include "skin/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace betamesh {

namespace {

constexpr double kEdgeTolerance = 1e-9;     // sine of the angle by which a ray may miss a triangle and still meet it
constexpr std::size_t kMaxPerCell = 20000;  // mean number of balls per cell as wide as the ball; more take too long

// Triangles of a closed surface sorted into columns along x, to compute winding numbers of points.
class TriangleColumns {
public:
    TriangleColumns(const BetaMesh& mesh, std::span<const std::uint32_t> triangles, const Box& box)
        : mesh_(mesh), triangles_(triangles), low_(box.min) {
        const Vec3 size = box.size();
        edge_ = std::max({std::sqrt(size.y * size.z * 2 / static_cast<double>(triangles.size())),
                          std::max(size.y, size.z) / static_cast<double>(triangles.size()),
                          std::numeric_limits<double>::min()});
        columns_y_ = static_cast<std::size_t>(size.y / edge_) + 1;
        columns_z_ = static_cast<std::size_t>(size.z / edge_) + 1;
        in_column_ = sortedIntoRows<std::uint32_t>(
            columns_y_ * columns_z_, triangles.size(), [&](std::size_t i, const auto& visit) {
                Box around;
                for (const std::uint32_t v : mesh.triangles[triangles[i]]) around.extendBy(mesh.vertex[v].position);
                for (std::size_t z = columnIndex(around.min.z - low_.z, columns_z_),
                                 last_z = columnIndex(around.max.z - low_.z, columns_z_);
                     z <= last_z; ++z)
                    for (std::size_t y = columnIndex(around.min.y - low_.y, columns_y_),
                                     last_y = columnIndex(around.max.y - low_.y, columns_y_);
                         y <= last_y; ++y)
                        visit(z * columns_y_ + y, static_cast<std::uint32_t>(i));
            });
    }

    // Winding number of a point in the box that is not near a triangle: the signed crossings of a ray along x.
    int windingNumber(const Vec3& point) const {
        int winding = 0;
        const std::size_t column =
            columnIndex(point.z - low_.z, columns_z_) * columns_y_ + columnIndex(point.y - low_.y, columns_y_);
        for (const std::uint32_t i : in_column_[column]) {
            const Triangle& t = mesh_.triangles[triangles_[i]];
            const Vec3 a = mesh_.vertex[t[0]].position - point, b = mesh_.vertex[t[1]].position - point,
                       c = mesh_.vertex[t[2]].position - point;
            const int side = sideOf(a, b);
            if (side != 0 && side == sideOf(b, c) && side == sideOf(c, a) && dot(a, cross(b, c)) * side > 0)
                winding += side;
        }
        return winding;
    }

private:
    std::size_t columnIndex(double offset, std::size_t columns) const {
        return std::min(static_cast<std::size_t>(std::max(offset, 0.0) / edge_), columns - 1);
    }
    // The side of an edge on which the ray passes, seen along x: 1 for left, -1 for right; opposite for the reverse
    // edge. A ray that meets the edge is moved by an infinitesimal amount along y, and by a smaller one along z.
    static int sideOf(const Vec3& from, const Vec3& to) {
        for (const double side : {from.y * to.z - from.z * to.y, from.z - to.z, to.y - from.y})
            if (side != 0) return side > 0 ? 1 : -1;
        return 0;
    }

    const BetaMesh& mesh_;
    std::span<const std::uint32_t> triangles_;
    Vec3 low_;
    double edge_ = 1;
    std::size_t columns_y_ = 1, columns_z_ = 1;
    IndexRows in_column_;  // indices of triangles_
};

// The ball that a triangle belongs to.
std::uint32_t ballOf(const BetaMesh& mesh, std::uint32_t triangle) {
    const auto after = std::upper_bound(mesh.ball_begin.begin(), mesh.ball_begin.end(), triangle);
    return static_cast<std::uint32_t>(after - mesh.ball_begin.begin()) - 1;
}

// Is a direction no farther from that of a corner than the other corners? Of triangles without a size, nearly every
// direction is within the tolerance of all three edges.
bool isNear(const Vec3& direction, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto cosine = [&](const Vec3& other) { return dot(a, other) / (a.length() * other.length()); };
    return cosine(direction) >= std::min(cosine(b), cosine(c)) - kEdgeTolerance;
}

// The component whose triangle a ray from a ball's centre meets on that ball; kInvalidIndex if it meets none.
std::uint32_t componentTowards(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components,
                               std::uint32_t ball, const Vec3& direction) {
    const Vec3 centre = boundary.centre(ball);
    const double radius = boundary.worldRadiusOf(ball).value;
    const double least = -kEdgeTolerance * radius * radius * direction.length();
    for (std::uint32_t row = mesh.ball_begin[ball]; row < mesh.ball_begin[ball + 1]; ++row) {
        const Triangle& t = mesh.triangles[row];
        const Vec3 a = mesh.vertex[t[0]].position - centre, b = mesh.vertex[t[1]].position - centre,
                   c = mesh.vertex[t[2]].position - centre;
        if (dot(direction, cross(a, b)) >= least && dot(direction, cross(b, c)) >= least &&
            dot(direction, cross(c, a)) >= least && dot(a, cross(b, c)) > 0 && isNear(direction, a, b, c))
            return components.of_vertex[t[0]];
    }
    return kInvalidIndex;
}

// Radius of a ball that is enlarged by as much as the largest, which gets `radius`; world units.
double enlargedRadius(const BallBoundary& boundary, std::size_t ball, double radius) {
    return radius - static_cast<double>(boundary.radius - boundary.radiusOf(ball)) * boundary.quantum;
}

// A quick form of voidsFittingBall(): is the ball round the centroid of a void's vertices empty and in the void?
// Decides round voids with a ball nearly as large, where all particles would be neighbours of each other. If false,
// the void is undecided.
std::vector<bool> fitsAtCentroid(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components,
                                 const std::vector<std::uint32_t>& void_of, double radius) {
    struct Centroid {
        Vec3 position{0};
        double corners = 0, room = std::numeric_limits<double>::infinity();  // distance to the nearest enlarged ball
        std::uint32_t nearest = 0;                                           // ball that bounds the void
    };
    std::vector<Centroid> centroid(components.count);
    for (const Triangle& t : mesh.triangles) {
        const std::uint32_t component = components.of_vertex[t[0]];
        if (void_of[component] != component) continue;
        for (const std::uint32_t v : t) centroid[component].position += mesh.vertex[v].position;
        centroid[component].corners += 3;
    }
    for (Centroid& m : centroid)
        if (m.corners > 0) m.position /= m.corners;
    for (std::uint32_t ball = 0; ball < boundary.position.size(); ++ball) {
        std::uint32_t last = kInvalidIndex;
        for (std::uint32_t row = mesh.ball_begin[ball]; row < mesh.ball_begin[ball + 1]; ++row) {
            const std::uint32_t void_component = void_of[components.of_vertex[mesh.triangles[row][0]]];
            if (void_component == kInvalidIndex || void_component == last) continue;
            last = void_component;
            Centroid& m = centroid[void_component];
            const double room = (m.position - boundary.centre(ball)).length() - enlargedRadius(boundary, ball, radius);
            if (room < m.room) m.room = room, m.nearest = ball;
        }
    }
    std::vector<bool> fits(components.count, false);
    for (std::uint32_t component = 0; component < components.count; ++component) {
        const Centroid& m = centroid[component];
        if (void_of[component] != component || m.room < 0) continue;
        const std::uint32_t towards =
            componentTowards(mesh, boundary, components, m.nearest, m.position - boundary.centre(m.nearest));
        fits[component] = towards != kInvalidIndex && void_of[towards] == component;
    }
    return fits;
}

constexpr double kVolumeRounding = 0.999;  // factor that allows for rounding errors

double ballVolume(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }

// The least radius of a ball that has triangles in each component, world units.
std::vector<double> smallestBalls(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components) {
    std::vector<double> smallest(components.count, boundary.worldRadius());
    if (boundary.radius_of.empty()) return smallest;
    for (std::size_t ball = 0; ball < boundary.position.size(); ++ball) {
        const double radius = boundary.worldRadiusOf(ball).value;
        for (std::uint32_t t = mesh.ball_begin[ball]; t < mesh.ball_begin[ball + 1]; ++t) {
            double& least = smallest[components.of_vertex[mesh.triangles[t][0]]];
            least = std::min(least, radius);
        }
    }
    return smallest;
}

void removeComponents(BetaMesh& mesh, const Components& components, const std::vector<bool>& is_removed) {
    keepTriangles(mesh, [&](std::size_t t) { return !is_removed[components.of_vertex[mesh.triangles[t][0]]]; });
    std::vector<std::uint32_t> new_index(mesh.vertex.size());
    std::uint32_t vertices = 0;
    for (std::size_t v = 0; v < new_index.size(); ++v) {
        if (components.of_vertex[v] == kInvalidIndex || is_removed[components.of_vertex[v]]) continue;
        mesh.vertex[vertices] = mesh.vertex[v];
        if (!mesh.rim_distance.empty()) mesh.rim_distance[vertices] = mesh.rim_distance[v];
        if (!mesh.scale.empty()) mesh.scale[vertices] = mesh.scale[v];
        new_index[v] = vertices++;
    }
    mesh.vertex.resize(vertices);
    if (!mesh.rim_distance.empty()) mesh.rim_distance.resize(vertices);
    if (!mesh.scale.empty()) mesh.scale.resize(vertices);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t) v = new_index[v];
    const auto isGone = [&](const auto& listed) {
        const std::uint32_t component = components.of_vertex[listed.vertex];
        return component == kInvalidIndex || is_removed[component];
    };
    for (auto& group : mesh.fading) {
        std::erase_if(group, isGone);
        for (FadingVertex& fading : group) {
            fading.vertex = new_index[fading.vertex];
            for (std::uint32_t& v : fading.support) v = new_index[v];
        }
    }
    std::erase_if(mesh.volume_offsets, isGone);
    for (VolumeOffset& offset : mesh.volume_offsets) offset.vertex = new_index[offset.vertex];
}

}  // namespace

std::vector<std::uint32_t> enclosingVoids(const BetaMesh& mesh, const BallBoundary& boundary,
                                          const Components& components, const std::vector<std::uint32_t>& voids,
                                          const std::vector<bool>& is_liquid) {
    std::vector<std::uint32_t> enclosing(components.count, kInvalidIndex);
    if (voids.empty()) return enclosing;
    const IndexRows triangles =
        sortedIntoRows<std::uint32_t>(components.count, mesh.triangles.size(), [&](std::size_t t, const auto& visit) {
            visit(components.of_vertex[mesh.triangles[t][0]], static_cast<std::uint32_t>(t));
        });
    struct LiquidComponent {
        Vec3 particle;  // one of the component's: its radius away from the triangles of voids that it floats in
        std::uint32_t component;
    };
    std::vector<LiquidComponent> liquid_components;
    for (std::uint32_t component = 0; component < components.count; ++component)
        if (is_liquid[component])
            liquid_components.push_back({boundary.centre(ballOf(mesh, triangles[component][0])), component});
    std::sort(liquid_components.begin(), liquid_components.end(),
              [](const LiquidComponent& a, const LiquidComponent& b) {
                  return a.particle.x != b.particle.x ? a.particle.x < b.particle.x : a.component < b.component;
              });
    std::vector<LiquidComponent> in_box;
    std::vector<std::uint8_t> is_inside;
    for (const std::uint32_t void_component : voids) {
        Box box;
        for (const std::uint32_t t : triangles[void_component])
            for (const std::uint32_t v : mesh.triangles[t]) box.extendBy(mesh.vertex[v].position);
        in_box.clear();
        for (auto liquid = std::lower_bound(liquid_components.begin(), liquid_components.end(), box.min.x,
                                            [](const LiquidComponent&b, double x) { return b.particle.x < x; });
             liquid != liquid_components.end() && liquid->particle.x <= box.max.x; ++liquid)
            if (box.intersects(liquid->particle)) in_box.push_back(*liquid);
        if (in_box.empty()) continue;
        const TriangleColumns columns(mesh, triangles[void_component], box);
        is_inside.resize(in_box.size());
        parallelFor(in_box.size(), 64,
                    [&](std::size_t i) { is_inside[i] = columns.windingNumber(in_box[i].particle) != 0; });
        for (std::size_t i = 0; i < in_box.size(); ++i)
            if (is_inside[i]) enclosing[in_box[i].component] = void_component;
    }
    return enclosing;
}

std::vector<bool> voidsFittingBall(const BetaMesh& mesh, const BallBoundary& boundary, const Components& components,
                                   std::vector<std::uint32_t> void_of, double radius) {
    std::vector<bool> fits = fitsAtCentroid(mesh, boundary, components, void_of, radius);
    for (std::uint32_t& void_component : void_of)
        if (void_component != kInvalidIndex && fits[void_component]) void_component = kInvalidIndex;
    const std::vector<std::uint32_t> balls = indicesWhere(boundary.position.size(), [&](std::uint32_t ball) {
        const auto first = mesh.triangles.begin() + mesh.ball_begin[ball];
        const auto last = mesh.triangles.begin() + mesh.ball_begin[ball + 1];
        return std::any_of(first, last,
                           [&](const Triangle& t) { return void_of[components.of_vertex[t[0]]] != kInvalidIndex; });
    });
    const auto centreOf = [&](std::size_t i) { return boundary.centre(balls[i]); };
    if (balls.size() > kMaxPerCell &&
        balls.size() > kMaxPerCell * CellGrid(balls.size(), 2 * radius, centreOf).cells()) {
        for (const std::uint32_t void_component : void_of)
            if (void_component != kInvalidIndex) fits[void_component] = true;
        return fits;
    }
    Particles particles;
    particles.position.resize(balls.size());
    parallelFor(balls.size(), 4096, [&](std::size_t i) { particles.position[i] = Vec3f(centreOf(i)); });
    std::vector<double> radii(boundary.radius_of.empty() ? 0 : balls.size());
    for (std::size_t i = 0; i < radii.size(); ++i) radii[i] = enlargedRadius(boundary, balls[i], radius);
    const SnappedParticles snapped =
        radii.empty() ? snapParticles(particles, radius) : snapParticles(particles, radii, radius);
    const BallBoundary larger = ballBoundary(snapped, exposureCandidates(snapped), {}, ArcTracing::none);

    std::vector<std::uint32_t> void_at(larger.vertex.size(), kInvalidIndex);
    parallelFor(void_at.size(), 256, [&](std::size_t v) {
        const std::uint32_t ball = balls[larger.row[larger.triangle[v][0]]];
        const std::uint32_t component =
            componentTowards(mesh, boundary, components, ball, larger.vertex[v] - boundary.centre(ball));
        if (component != kInvalidIndex) void_at[v] = void_of[component];
    });
    for (const std::uint32_t void_component : void_at)
        if (void_component != kInvalidIndex) fits[void_component] = true;
    return fits;
}

std::size_t fillBubbles(BetaMesh& mesh, const BallBoundary& boundary, const Features& features,
                        double reference_radius) {
    const double empty_radius = features.bubble_gap / 2;
    const bool by_gap = features.bubble_gap > 0;
    // Whether the reference radius is that of the largest balls, whose radius in quanta then counts.
    const bool is_of_largest = std::abs(reference_radius - boundary.worldRadius()) <= boundary.quantum;
    const double reference = is_of_largest ? boundary.worldRadius() : reference_radius;
    const double room = empty_radius - reference;  // radius of a ball that has to fit between those of the particles
    if (by_gap && room <= 0) return 0;
    const Components components = componentsOf(mesh.vertex.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; };
    const std::vector<double> enclosed = enclosedVolumes(components, mesh.triangles, positionOf);
    const std::vector<double> smallest = smallestBalls(mesh, boundary, components);
    const double smallest_of_all =
        smallest.empty() ? boundary.worldRadius() : *std::min_element(smallest.begin(), smallest.end());
    const double least_void = by_gap ? kVolumeRounding * ballVolume(room) : features.bubble_volume;
    std::vector<bool> is_removed(components.count), is_liquid(components.count);
    std::vector<std::uint32_t> large_voids;  // voids that could hold a liquid component
    std::vector<std::uint32_t> void_of(components.count, kInvalidIndex);
    bool any_undecided = false;
    for (std::uint32_t component = 0; component < components.count; ++component) {
        is_liquid[component] = enclosed[component] >= kMinLiquidVolume * ballVolume(smallest[component]);
        if (is_liquid[component]) continue;
        is_removed[component] = enclosed[component] > -least_void;
        if (enclosed[component] < -kMinLiquidVolume * ballVolume(smallest_of_all)) large_voids.push_back(component);
        if (by_gap && !is_removed[component]) any_undecided = true, void_of[component] = component;
    }
    std::sort(large_voids.begin(), large_voids.end(), [&](std::uint32_t a, std::uint32_t b) {
        return enclosed[a] != enclosed[b] ? enclosed[a] < enclosed[b] : a < b;
    });
    const std::vector<std::uint32_t> enclosing = enclosingVoids(mesh, boundary, components, large_voids, is_liquid);
    if (any_undecided) {
        for (std::uint32_t component = 0; component < components.count; ++component)
            if (enclosing[component] != kInvalidIndex) void_of[component] = void_of[enclosing[component]];
        const std::vector<bool> fits = voidsFittingBall(mesh, boundary, components, void_of,
                                                        is_of_largest ? empty_radius : boundary.worldRadius() + room);
        for (std::uint32_t component = 0; component < components.count; ++component)
            if (void_of[component] == component) is_removed[component] = !fits[component];
    }
    const auto filled = static_cast<std::size_t>(std::count(is_removed.begin(), is_removed.end(), true));
    for (std::uint32_t component = 0; component < components.count; ++component)
        if (enclosing[component] != kInvalidIndex) is_removed[component] = is_removed[enclosing[component]];
    if (filled > 0) removeComponents(mesh, components, is_removed);
    return filled;
}

}  // namespace betamesh
