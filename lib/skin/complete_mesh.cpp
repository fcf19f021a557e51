#include "skin/complete_mesh.h"

#include "core/icosphere.h"
#include "core/parallel.h"
#include "exact/bounded_hull.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

constexpr std::size_t kBallsPerTask = 32;
constexpr double kGrid = 0x1p38;    // of the hull's points, per radius
constexpr double kClearance = 0.4;  // of point_angle: how far points inside a face stay from its edges
constexpr double kIcosahedronAngle = 1.1071487177940904;

Vec3i onGrid(const Vec3& direction) {
    return {std::llround(direction.x * kGrid), std::llround(direction.y * kGrid), std::llround(direction.z * kGrid)};
}

// The faces of each ball are neighbours in the list: where those of each begin.
std::vector<std::uint32_t> firstFaces(const BallBoundary& boundary) {
    std::vector<std::uint32_t> count(boundary.position.size(), 0);
    for (const std::uint32_t ball : boundary.face_ball) ++count[ball];
    return placesOf(count);
}

// One ball's loops, with the network's numbers of their points.
struct BallLoops {
    LoopsOnSphere loops;
    std::vector<std::uint32_t> network_point;
    std::vector<std::vector<std::uint32_t>> face;  // loops of each face

    void clear() { *this = {}; }
};

class LoopMaker {
public:
    LoopMaker(const BallBoundary& boundary, const ArcNetwork& network) : boundary_(boundary), network_(network) {}

    void makeLoops(std::uint32_t ball, std::uint32_t first_face, std::uint32_t last_face, BallLoops& out) const {
        out.clear();
        for (std::uint32_t f = first_face; f < last_face; ++f) {
            out.face.emplace_back();
            for (const std::uint32_t c : boundary_.face[f]) {
                out.face.back().push_back(static_cast<std::uint32_t>(out.loops.is_hole.size()));
                if (c < boundary_.cycle.size())
                    addCycle(ball, boundary_.cycle[c], out);
                else
                    addCircle(ball, c - static_cast<std::uint32_t>(boundary_.cycle.size()), out);
                out.loops.loop_begin.push_back(static_cast<std::uint32_t>(out.loops.point.size()));
            }
        }
    }

private:
    void add(std::uint32_t ball, std::uint32_t point, std::uint32_t circle_before, std::uint32_t circle_after,
             BallLoops& out) const {
        const Vec3 offset = network_.point[point].position - boundary_.centre(ball);
        out.loops.point.push_back(onGrid(offset / boundary_.worldRadius()));
        out.loops.circles.push_back({circle_before, circle_after});
        out.network_point.push_back(point);
    }
    bool barelyMeets(std::uint32_t ball, std::uint32_t other) const {
        const Vec3 offset = toDouble(boundary_.position[other] - boundary_.position[ball]);
        const double diameter = 2 * static_cast<double>(boundary_.radius);
        return dot(offset, offset) > diameter * diameter * (1 - 1e-12);
    }
    void addCycle(std::uint32_t ball, std::span<const std::uint32_t> cycle, BallLoops& out) const {
        bool hole = true;
        for (const std::uint32_t h : cycle) {
            // arrives along the circle with the triangle's second particle, leaves along that with its third
            const std::uint32_t leaving = previousInTriangle(h), ahead = nextInTriangle(h);
            const std::uint32_t before = boundary_.triangle[h / 3][ahead % 3],
                                after = boundary_.triangle[h / 3][leaving % 3];
            add(ball, h / 3, before, after, out);
            hole = hole && barelyMeets(ball, after);
            const std::uint32_t arc = network_.arc_of[leaving], first = network_.arc_begin[arc];
            const std::uint32_t n = network_.arcSize(arc);
            const bool forward = network_.arc_start[arc] == leaving;
            for (std::uint32_t m = 0; m < n; ++m) add(ball, first + (forward ? m : n - 1 - m), after, after, out);
        }
        out.loops.is_hole.push_back(hole);
    }
    void addCircle(std::uint32_t ball, std::uint32_t circle_side, BallLoops& out) const {
        const std::uint32_t k = circle_side / 2, side = circle_side % 2, n = network_.circleSize(k);
        const std::uint32_t other = boundary_.circle[k][1 - side];
        for (std::uint32_t m = 0; m < n; ++m)
            add(ball, network_.circle_begin[k] + (side == 1 ? m : n - 1 - m), other, other, out);
        out.loops.is_hole.push_back(1);
    }

    const BallBoundary& boundary_;
    const ArcNetwork& network_;
};

// Directions that stay clear of every neighbour's cap.
void addFreePoints(const Icosphere& directions, const std::vector<Neighbour>& neighbours, double radius,
                   double point_angle, LoopsOnSphere& loops) {
    struct Cap {
        Vec3 direction;
        double cosine;  // of the angle within which no point may lie
    };
    std::vector<Cap> caps;
    for (const Neighbour& n : neighbours) {
        const double distance = std::sqrt(n.squared), angle = std::acos(std::min(1.0, distance / (2 * radius)));
        const double clearance = kClearance * std::min(point_angle, angle);
        caps.push_back({n.offset / distance, std::cos(angle + clearance)});
    }
    for (const Vec3& d : directions.position)
        if (std::none_of(caps.begin(), caps.end(), [&](const Cap& cap) { return dot(d, cap.direction) > cap.cosine; }))
            loops.point.push_back(onGrid(d));
}

// What one task makes: triangles by network point, or by place among the new points from kNew on.
struct Part {
    std::vector<Triangle> triangles;
    std::vector<Moving> points;
};
constexpr std::uint32_t kNew = std::uint32_t{1} << 31;

void addFilling(const BallLoops& ball_loops, const LoopFilling& filling, const Vec3& centre, const Vec3& velocity,
                double world_radius, Part& part) {
    constexpr std::uint32_t kUnplaced = ~std::uint32_t{0};
    const std::size_t in_loops = ball_loops.network_point.size(), given = ball_loops.loops.point.size();
    std::vector<std::uint32_t> place(given + filling.new_point.size() - in_loops, kUnplaced);
    for (Triangle t : filling.triangles) {
        for (std::uint32_t& v : t) {
            if (v < in_loops) {
                v = ball_loops.network_point[v];
                continue;
            }
            std::uint32_t& where = place[v - in_loops];
            if (where == kUnplaced) {
                const Vec3i& p = v < given ? ball_loops.loops.point[v] : filling.new_point[v - given];
                where = kNew + static_cast<std::uint32_t>(part.points.size());
                part.points.push_back({centre + toDouble(p).normalized() * world_radius, velocity});
            }
            v = where;
        }
        part.triangles.push_back(t);
    }
}

}  // namespace

BetaMesh completeTessellation(const SnappedParticles& particles, const BallBoundary& boundary,
                              const std::vector<Moving>& balls, const ArcNetwork& network, double point_angle) {
    const Icosphere directions = icosphere(static_cast<std::uint32_t>(std::ceil(kIcosahedronAngle / point_angle)));
    const std::vector<std::uint32_t> first_face = firstFaces(boundary);
    const LoopMaker maker(boundary, network);
    const double radius = static_cast<double>(boundary.radius), world_radius = boundary.worldRadius();

    const std::size_t tasks = (balls.size() + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<Part> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        NeighbourFinder finder(particles);
        std::vector<Neighbour> neighbours;
        BallLoops ball_loops;
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls.size(), (task + 1) * kBallsPerTask); ++b) {
            const auto ball = static_cast<std::uint32_t>(b);
            maker.makeLoops(ball, first_face[b], first_face[b + 1], ball_loops);
            const auto add = [&](const LoopFilling& filling) {
                addFilling(ball_loops, filling, balls[b].position, balls[b].velocity, world_radius, parts[task]);
            };
            if (ball_loops.loops.point.empty()) {  // a bare sphere
                LoopFilling whole{directions.triangles, {}};
                for (const Vec3& d : directions.position) whole.new_point.push_back(onGrid(d));
                add(whole);
                continue;
            }
            finder.find(boundary.snapped_row[b], neighbours);
            const std::size_t in_loops = ball_loops.loops.point.size();
            addFreePoints(directions, neighbours, radius, point_angle, ball_loops.loops);
            if (const auto filling = fillWithHull(ball_loops.loops)) {
                add(*filling);
                continue;
            }
            ball_loops.loops.point.resize(in_loops);
            for (const auto& face : ball_loops.face) add(fillWithFan(ball_loops.loops, face));
        }
    });

    BetaMesh mesh;
    mesh.vertex = network.point;
    for (const Part& part : parts) {
        const auto first = static_cast<std::uint32_t>(mesh.vertex.size());
        mesh.vertex.insert(mesh.vertex.end(), part.points.begin(), part.points.end());
        for (Triangle t : part.triangles) {
            for (std::uint32_t& v : t)
                if (v >= kNew) v = first + (v - kNew);
            mesh.triangles.push_back(t);
        }
    }
    return mesh;
}

}  // namespace betamesh
