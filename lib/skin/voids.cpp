
#include "skin/voids.h"

#include "base/cell_order.h"
#include "base/index.h"
#include "base/parallel.h"
#include "skin/ball_boundary.h"
#include "skin/exposure_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace betamesh {

namespace {

constexpr double kOnEdge = 1e-9;            // how far a ray may pass by a triangle that it hits, as a sine
constexpr std::size_t kMostInCell = 20000;  // as wide as the ball, on average: many more take for ever, and then throw

// Closed triangles in columns along x, to tell how often they enclose a point.
class Columns {
public:
    Columns(const BetaMesh& mesh, std::span<const std::uint32_t> triangles, const Box& box)
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
                for (std::size_t z = placeOf(around.min.z - low_.z, columns_z_),
                                 last_z = placeOf(around.max.z - low_.z, columns_z_);
                     z <= last_z; ++z)
                    for (std::size_t y = placeOf(around.min.y - low_.y, columns_y_),
                                     last_y = placeOf(around.max.y - low_.y, columns_y_);
                         y <= last_y; ++y)
                        visit(z * columns_y_ + y, static_cast<std::uint32_t>(i));
            });
    }

    // Of a point in the box that is not near a triangle: what a ray along x crosses, by the side from which it does.
    int windingNumber(const Vec3& point) const {
        int winding = 0;
        const std::size_t column =
            placeOf(point.z - low_.z, columns_z_) * columns_y_ + placeOf(point.y - low_.y, columns_y_);
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
    std::size_t placeOf(double offset, std::size_t columns) const {
        return std::min(static_cast<std::size_t>(std::max(offset, 0.0) / edge_), columns - 1);
    }
    // On which side of an edge the ray passes, seen along x: 1 to its left, -1 to its right, the opposite for the edge
    // the other way. A ray that meets the edge counts as moved a little along y, and yet less along z.
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
    IndexRows in_column_;  // places in triangles_
};

// One that a triangle was made for.
std::uint32_t ballOf(const BetaMesh& mesh, std::uint32_t triangle) {
    const auto after = std::upper_bound(mesh.ball_begin.begin(), mesh.ball_begin.end(), triangle);
    return static_cast<std::uint32_t>(after - mesh.ball_begin.begin()) - 1;
}

// The piece whose triangle a ray from a ball's centre leaves the ball by; kInvalidIndex where it does by none.
std::uint32_t pieceTowards(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces, std::uint32_t ball,
                           const Vec3& direction) {
    const Vec3 centre = boundary.centre(ball);
    const double least = -kOnEdge * boundary.worldRadius() * boundary.worldRadius() * direction.length();
    for (std::uint32_t row = mesh.ball_begin[ball]; row < mesh.ball_begin[ball + 1]; ++row) {
        const Triangle& t = mesh.triangles[row];
        const Vec3 a = mesh.vertex[t[0]].position - centre, b = mesh.vertex[t[1]].position - centre,
                   c = mesh.vertex[t[2]].position - centre;
        if (dot(direction, cross(a, b)) >= least && dot(direction, cross(b, c)) >= least &&
            dot(direction, cross(c, a)) >= least && dot(a, cross(b, c)) > 0)
            return pieces.of_vertex[t[0]];
    }
    return kInvalidIndex;
}

// The same answer as voidsWithRoom, where the ball fits round the mean of a void's vertices: in round voids, where with
// a ball nearly as large all particles are neighbours of each other. False where it does not.
std::vector<bool> haveRoomInTheMiddle(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces,
                                      const std::vector<std::uint32_t>& void_of, double radius) {
    struct Middle {
        Vec3 place{0};
        double corners = 0, squared = std::numeric_limits<double>::infinity();
        std::uint32_t nearest = 0;  // ball round the void
    };
    std::vector<Middle> middle(pieces.count);
    for (const Triangle& t : mesh.triangles) {
        const std::uint32_t piece = pieces.of_vertex[t[0]];
        if (void_of[piece] != piece) continue;
        for (const std::uint32_t v : t) middle[piece].place += mesh.vertex[v].position;
        middle[piece].corners += 3;
    }
    for (Middle& m : middle)
        if (m.corners > 0) m.place /= m.corners;
    for (std::uint32_t ball = 0; ball < boundary.position.size(); ++ball) {
        std::uint32_t last = kInvalidIndex;
        for (std::uint32_t row = mesh.ball_begin[ball]; row < mesh.ball_begin[ball + 1]; ++row) {
            const std::uint32_t hollow = void_of[pieces.of_vertex[mesh.triangles[row][0]]];
            if (hollow == kInvalidIndex || hollow == last) continue;
            last = hollow;
            Middle& m = middle[hollow];
            const double squared = (m.place - boundary.centre(ball)).length2();
            if (squared < m.squared) m.squared = squared, m.nearest = ball;
        }
    }
    std::vector<bool> has_room(pieces.count, false);
    for (std::uint32_t piece = 0; piece < pieces.count; ++piece) {
        const Middle& m = middle[piece];
        if (void_of[piece] != piece || m.squared < radius * radius) continue;
        const std::uint32_t towards =
            pieceTowards(mesh, boundary, pieces, m.nearest, m.place - boundary.centre(m.nearest));
        has_room[piece] = towards != kInvalidIndex && void_of[towards] == piece;
    }
    return has_room;
}

}  // namespace

std::vector<std::uint32_t> voidsRoundBodies(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces,
                                            const std::vector<std::uint32_t>& voids, const std::vector<bool>& is_body) {
    std::vector<std::uint32_t> round(pieces.count, kInvalidIndex);
    if (voids.empty()) return round;
    const IndexRows triangles =
        sortedIntoRows<std::uint32_t>(pieces.count, mesh.triangles.size(), [&](std::size_t t, const auto& visit) {
            visit(pieces.of_vertex[mesh.triangles[t][0]], static_cast<std::uint32_t>(t));
        });
    struct Body {
        Vec3 particle;  // one of its own: a radius away from the triangles of voids that it floats in
        std::uint32_t piece;
    };
    std::vector<Body> bodies;
    for (std::uint32_t piece = 0; piece < pieces.count; ++piece)
        if (is_body[piece]) bodies.push_back({boundary.centre(ballOf(mesh, triangles[piece][0])), piece});
    std::sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) {
        return a.particle.x != b.particle.x ? a.particle.x < b.particle.x : a.piece < b.piece;
    });
    std::vector<Body> in_box;
    std::vector<std::uint8_t> is_inside;
    for (const std::uint32_t hollow : voids) {
        Box box;
        for (const std::uint32_t t : triangles[hollow])
            for (const std::uint32_t v : mesh.triangles[t]) box.extendBy(mesh.vertex[v].position);
        in_box.clear();
        for (auto body = std::lower_bound(bodies.begin(), bodies.end(), box.min.x,
                                          [](const Body&b, double x) { return b.particle.x < x; });
             body != bodies.end() && body->particle.x <= box.max.x; ++body)
            if (box.intersects(body->particle)) in_box.push_back(*body);
        if (in_box.empty()) continue;
        const Columns columns(mesh, triangles[hollow], box);
        is_inside.resize(in_box.size());
        parallelFor(in_box.size(), 64,
                    [&](std::size_t i) { is_inside[i] = columns.windingNumber(in_box[i].particle) != 0; });
        for (std::size_t i = 0; i < in_box.size(); ++i)
            if (is_inside[i]) round[in_box[i].piece] = hollow;
    }
    return round;
}

std::vector<bool> voidsWithRoom(const BetaMesh& mesh, const BallBoundary& boundary, const Components& pieces,
                                std::vector<std::uint32_t> void_of, double radius) {
    std::vector<bool> has_room = haveRoomInTheMiddle(mesh, boundary, pieces, void_of, radius);
    for (std::uint32_t& hollow : void_of)
        if (hollow != kInvalidIndex && has_room[hollow]) hollow = kInvalidIndex;
    const std::vector<std::uint32_t> balls = indicesWhere(boundary.position.size(), [&](std::uint32_t ball) {
        const auto first = mesh.triangles.begin() + mesh.ball_begin[ball];
        const auto last = mesh.triangles.begin() + mesh.ball_begin[ball + 1];
        return std::any_of(first, last, [&](const Triangle& t) { return void_of[pieces.of_vertex[t[0]]] != kInvalidIndex; });
    });
    const auto centreOf = [&](std::size_t i) { return boundary.centre(balls[i]); };
    if (balls.size() > kMostInCell &&
        balls.size() > kMostInCell * CellOrder(balls.size(), 2 * radius, centreOf).cells()) {
        for (const std::uint32_t hollow : void_of)
            if (hollow != kInvalidIndex) has_room[hollow] = true;
        return has_room;
    }
    Particles particles;
    particles.position.resize(balls.size());
    parallelFor(balls.size(), 4096, [&](std::size_t i) { particles.position[i] = Vec3f(centreOf(i)); });
    const SnappedParticles snapped = snapParticles(particles, radius);
    const BallBoundary larger = ballBoundary(snapped, exposureCandidates(snapped), {}, Arcs::left_out);

    std::vector<std::uint32_t> void_at(larger.vertex.size(), kInvalidIndex);
    parallelFor(void_at.size(), 256, [&](std::size_t v) {
        const std::uint32_t ball = balls[larger.row[larger.triangle[v][0]]];
        const std::uint32_t piece =
            pieceTowards(mesh, boundary, pieces, ball, larger.vertex[v] - boundary.centre(ball));
        if (piece != kInvalidIndex) void_at[v] = void_of[piece];
    });
    for (const std::uint32_t hollow : void_at)
        if (hollow != kInvalidIndex) has_room[hollow] = true;
    return has_room;
}

}  // namespace betamesh
