#include "skin/features.h"

#include "core/angles.h"
#include "core/graph.h"
#include "core/parallel.h"
#include "core/pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

namespace betamesh {

namespace {

// A component that faces outwards holds at least one whole ball, whose tessellation has more than half of its volume.
// What has less than this part of it is a bubble, even where rounding gives a tiny one a positive sign.
constexpr double kLeastBody = 0.25;

// Of each piece of a mesh, world units cubed.
template <typename PositionOf>
std::vector<double> volumesOf(const Pieces& pieces, const std::vector<Triangle>& triangles,
                              const PositionOf& positionOf) {
    std::vector<double> volume(pieces.count, 0);
    std::vector<std::uint32_t> origin(pieces.count, kNoPiece);
    for (const Triangle& t : triangles) {
        const std::uint32_t piece = pieces.of_vertex[t[0]];
        if (origin[piece] == kNoPiece) origin[piece] = t[0];
        const Vec3 o = positionOf(origin[piece]);
        volume[piece] += volumeBelow(positionOf(t[0]) - o, positionOf(t[1]) - o, positionOf(t[2]) - o);
    }
    return volume;
}

// How often closed triangles enclose a point, from solid angles; no whole number for a point on them.
// source  Van Oosterom & Strackee 1983, The solid angle of a plane triangle
double windingNumber(const BetaMesh& mesh, std::span<const std::uint32_t> triangles, const Vec3& point) {
    double angle = 0;
    for (const std::uint32_t row : triangles) {
        const Triangle& t = mesh.triangles[row];
        const Vec3 a = mesh.vertex[t[0]].position - point, b = mesh.vertex[t[1]].position - point,
                   c = mesh.vertex[t[2]].position - point;
        const double la = a.length(), lb = b.length(), lc = c.length();
        angle += 2 * angleOf(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return angle / (4 * std::numbers::pi);
}

// Numbers 0 … n - 1 sorted into so many rows.
template <typename RowOf>
Rows sortedInto(std::size_t rows, std::size_t n, const RowOf& rowOf) {
    return sortedIntoRows<std::uint32_t>(rows, n, [&](std::size_t i, const auto& visit) {
        const auto number = static_cast<std::uint32_t>(i);
        if (rowOf(number) != kNoPiece) visit(rowOf(number), number);
    });
}

// What is inside closed pieces.
class PiecesInside {
public:
    PiecesInside(const BetaMesh& mesh, const Pieces& pieces)
        : mesh_(mesh),
          vertices_(sortedInto(pieces.count, mesh.vertex.size(), [&](std::uint32_t v) { return pieces.of_vertex[v]; })),
          triangles_(sortedInto(pieces.count, mesh.triangles.size(),
                                [&](std::uint32_t t) { return pieces.of_vertex[mesh.triangles[t][0]]; })),
          along_x_(pieces.count) {
        for (std::uint32_t piece = 0; piece < pieces.count; ++piece)
            along_x_[piece] = {position(vertices_[piece][0]).x, piece};
        std::sort(along_x_.begin(), along_x_.end());
    }

    // Calls visit(piece) for every piece inside another one.
    template <typename Visit>
    void forEach(std::uint32_t outer, const Visit& visit) const {
        Vec3 low = position(vertices_[outer][0]), high = low;
        for (const std::uint32_t v : vertices_[outer])
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], position(v)[axis]);
                high[axis] = std::max(high[axis], position(v)[axis]);
            }
        const auto first = std::lower_bound(along_x_.begin(), along_x_.end(), std::pair(low.x, std::uint32_t{0}));
        for (auto at = first; at != along_x_.end() && at->first <= high.x; ++at) {
            const Vec3& p = position(vertices_[at->second][0]);
            const bool in_box = p.y >= low.y && p.z >= low.z && p.y <= high.y && p.z <= high.z;
            if (at->second != outer && in_box && encloses(outer, at->second)) visit(at->second);
        }
    }

private:
    const Vec3& position(std::uint32_t v) const { return mesh_.vertex[v].position; }
    // Pieces may touch in a point, but do not cross: the first vertex that is off the other piece decides.
    bool encloses(std::uint32_t outer, std::uint32_t piece) const {
        constexpr double kClear = 0.1;
        for (const std::uint32_t v : vertices_[piece]) {
            const double winding = std::abs(windingNumber(mesh_, triangles_[outer], position(v)));
            if (winding < kClear) return false;
            if (winding > 1 - kClear) return true;
        }
        return false;
    }

    const BetaMesh& mesh_;
    Rows vertices_, triangles_;                              // of each piece
    std::vector<std::pair<double, std::uint32_t>> along_x_;  // the first vertex of each piece
};

void removePieces(BetaMesh& mesh, const Pieces& pieces, const std::vector<bool>& leaves) {
    std::size_t stay = 0, ball = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (; ball < mesh.ball_begin.size() && mesh.ball_begin[ball] == t; ++ball)
            mesh.ball_begin[ball] = static_cast<std::uint32_t>(stay);
        if (!leaves[pieces.of_vertex[mesh.triangles[t][0]]]) mesh.triangles[stay++] = mesh.triangles[t];
    }
    for (; ball < mesh.ball_begin.size(); ++ball) mesh.ball_begin[ball] = static_cast<std::uint32_t>(stay);
    mesh.triangles.resize(stay);
    std::vector<std::uint32_t> place(mesh.vertex.size());
    std::uint32_t left = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (pieces.of_vertex[v] == kNoPiece || leaves[pieces.of_vertex[v]]) continue;
        mesh.vertex[left] = mesh.vertex[v];
        if (!mesh.clearance.empty()) mesh.clearance[left] = mesh.clearance[v];
        place[v] = left++;
    }
    mesh.vertex.resize(left);
    if (!mesh.clearance.empty()) mesh.clearance.resize(left);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t) v = place[v];
    const auto has_left = [&](const auto& listed) {
        const std::uint32_t piece = pieces.of_vertex[listed.vertex];
        return piece == kNoPiece || leaves[piece];
    };
    for (auto& group : mesh.rising) {
        std::erase_if(group, has_left);
        for (RisingVertex& rising : group) {
            rising.vertex = place[rising.vertex];
            for (std::uint32_t& v : rising.from) v = place[v];
        }
    }
    std::erase_if(mesh.swelling, has_left);
    for (SwellingVertex& swelling : mesh.swelling) swelling.vertex = place[swelling.vertex];
}

}  // namespace

std::vector<std::uint32_t> tendrilParticles(const BallBoundary& boundary) {
    std::vector<bool> in_triangle(boundary.position.size(), false), in_circle = in_triangle;
    for (const Triangle& t : boundary.triangle)
        for (const std::uint32_t ball : t) in_triangle[ball] = true;
    for (const auto& circle : boundary.circle)
        for (const std::uint32_t ball : circle) in_circle[ball] = true;
    std::vector<std::uint32_t> rows;
    for (std::size_t ball = 0; ball < in_circle.size(); ++ball)
        if (in_circle[ball] && !in_triangle[ball]) rows.push_back(boundary.snapped_row[ball]);
    return rows;
}

std::size_t fillBubbles(BetaMesh& mesh, double radius, double volume) {
    const Pieces pieces = piecesOf(mesh.vertex.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; };
    const std::vector<double> enclosed = volumesOf(pieces, mesh.triangles, positionOf);
    const double least_body = kLeastBody * 4 / 3 * std::numbers::pi * radius * radius * radius;
    std::vector<bool> leaves(pieces.count);
    std::vector<std::uint32_t> roomy;  // bubbles that could hold a drop
    std::size_t filled = 0;
    for (std::uint32_t piece = 0; piece < pieces.count; ++piece) {
        leaves[piece] = enclosed[piece] < least_body && enclosed[piece] > -volume;
        filled += leaves[piece];
        if (leaves[piece] && enclosed[piece] < -least_body) roomy.push_back(piece);
    }
    if (!roomy.empty()) {
        const PiecesInside inside(mesh, pieces);
        for (const std::uint32_t bubble : roomy)
            inside.forEach(bubble, [&](std::uint32_t piece) { leaves[piece] = true; });
    }
    if (filled > 0) removePieces(mesh, pieces, leaves);
    return filled;
}

void labelComponents(Mesh& mesh) {
    const Pieces pieces = piecesOf(mesh.position.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; };
    const std::vector<double> volume = volumesOf(pieces, mesh.triangles, positionOf);
    const auto place = [&](std::uint32_t v) {
        const Vec3& p = mesh.position[v];
        return std::tuple(p.x, p.y, p.z, v);
    };
    std::vector<std::uint32_t> first(pieces.count, kNoPiece);
    for (std::uint32_t v = 0; v < pieces.of_vertex.size(); ++v) {
        if (pieces.of_vertex[v] == kNoPiece) continue;
        std::uint32_t& best = first[pieces.of_vertex[v]];
        if (best == kNoPiece || place(v) < place(best)) best = v;
    }
    std::vector<std::uint32_t> order(pieces.count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return volume[a] != volume[b] ? volume[a] > volume[b] : place(first[a]) < place(first[b]);
    });
    std::vector<std::int32_t> number(pieces.count);
    for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<std::int32_t>(i);
    std::vector<std::int32_t>& component = mesh.component.emplace();
    component.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) component.push_back(number[pieces.of_vertex[t[0]]]);
}

}  // namespace betamesh
