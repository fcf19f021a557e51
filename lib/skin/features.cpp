
#include "skin/features.h"

#include "base/index.h"
#include "mesh/components.h"
#include "skin/voids.h"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <tuple>

namespace betamesh {

namespace {

// A component that faces outwards holds at least one whole ball, whose tessellation has more than half of its volume.
// What has less than this part of it is a bubble, even where rounding gives a tiny one a positive sign.
constexpr double kLeastBody = 0.25;

constexpr double kRounding = 0.999;  // of volumes that may be a little more for it

double ballVolume(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }

// Of each piece of a mesh, world units cubed.
template <typename PositionOf>
std::vector<double> volumesOf(const Components& pieces, const std::vector<Triangle>& triangles,
                              const PositionOf& positionOf) {
    std::vector<double> volume(pieces.count, 0);
    std::vector<std::uint32_t> origin(pieces.count, kInvalidIndex);
    for (const Triangle& t : triangles) {
        const std::uint32_t piece = pieces.of_vertex[t[0]];
        if (origin[piece] == kInvalidIndex) origin[piece] = t[0];
        const Vec3 o = positionOf(origin[piece]);
        volume[piece] += volumeBelow(positionOf(t[0]) - o, positionOf(t[1]) - o, positionOf(t[2]) - o);
    }
    return volume;
}

void removePieces(BetaMesh& mesh, const Components& pieces, const std::vector<bool>& leaves) {
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
        if (pieces.of_vertex[v] == kInvalidIndex || leaves[pieces.of_vertex[v]]) continue;
        mesh.vertex[left] = mesh.vertex[v];
        if (!mesh.rim_distance.empty()) mesh.rim_distance[left] = mesh.rim_distance[v];
        place[v] = left++;
    }
    mesh.vertex.resize(left);
    if (!mesh.rim_distance.empty()) mesh.rim_distance.resize(left);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t) v = place[v];
    const auto has_left = [&](const auto& listed) {
        const std::uint32_t piece = pieces.of_vertex[listed.vertex];
        return piece == kInvalidIndex || leaves[piece];
    };
    for (auto& group : mesh.fading) {
        std::erase_if(group, has_left);
        for (FadingVertex& fading : group) {
            fading.vertex = place[fading.vertex];
            for (std::uint32_t& v : fading.from) v = place[v];
        }
    }
    std::erase_if(mesh.volume_offsets, has_left);
    for (VolumeOffset& swelling : mesh.volume_offsets) swelling.vertex = place[swelling.vertex];
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

std::size_t fillBubbles(BetaMesh& mesh, const BallBoundary& boundary, const Features& features) {
    const double radius = boundary.worldRadius(), empty = features.bubble_gap / 2;
    const bool by_gap = features.bubble_gap > 0;
    if (by_gap && empty <= radius) return 0;
    const Components pieces = componentsOf(mesh.vertex.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.vertex[v].position; };
    const std::vector<double> enclosed = volumesOf(pieces, mesh.triangles, positionOf);
    const double least_body = kLeastBody * ballVolume(radius);
    // Round the centre of an empty ball the void has room for all but the particles' own radius.
    const double least_void = by_gap ? kRounding * ballVolume(empty - radius) : features.bubble_volume;
    std::vector<bool> leaves(pieces.count), is_body(pieces.count);
    std::vector<std::uint32_t> roomy;  // voids that could hold a drop
    std::vector<std::uint32_t> void_of(pieces.count, kInvalidIndex);
    bool in_question = false;
    for (std::uint32_t piece = 0; piece < pieces.count; ++piece) {
        is_body[piece] = enclosed[piece] >= least_body;
        if (is_body[piece]) continue;
        leaves[piece] = enclosed[piece] > -least_void;
        if (enclosed[piece] < -least_body) roomy.push_back(piece);
        if (by_gap && !leaves[piece]) in_question = true, void_of[piece] = piece;
    }
    std::sort(roomy.begin(), roomy.end(), [&](std::uint32_t a, std::uint32_t b) {
        return enclosed[a] != enclosed[b] ? enclosed[a] < enclosed[b] : a < b;
    });
    const std::vector<std::uint32_t> round = voidsRoundBodies(mesh, boundary, pieces, roomy, is_body);
    if (in_question) {
        for (std::uint32_t piece = 0; piece < pieces.count; ++piece)
            if (round[piece] != kInvalidIndex) void_of[piece] = void_of[round[piece]];
        const std::vector<bool> has_room = voidsWithRoom(mesh, boundary, pieces, void_of, empty);
        for (std::uint32_t piece = 0; piece < pieces.count; ++piece)
            if (void_of[piece] == piece) leaves[piece] = !has_room[piece];
    }
    const auto filled = static_cast<std::size_t>(std::count(leaves.begin(), leaves.end(), true));
    for (std::uint32_t piece = 0; piece < pieces.count; ++piece)
        if (round[piece] != kInvalidIndex) leaves[piece] = leaves[round[piece]];
    if (filled > 0) removePieces(mesh, pieces, leaves);
    return filled;
}

void labelComponents(Mesh& mesh) {
    const Components pieces = componentsOf(mesh.position.size(), mesh.triangles);
    const auto positionOf = [&](std::uint32_t v) -> const Vec3& { return mesh.position[v]; };
    const std::vector<double> volume = volumesOf(pieces, mesh.triangles, positionOf);
    const auto place = [&](std::uint32_t v) {
        const Vec3& p = mesh.position[v];
        return std::tuple(p.x, p.y, p.z, v);
    };
    std::vector<std::uint32_t> first(pieces.count, kInvalidIndex);
    for (std::uint32_t v = 0; v < pieces.of_vertex.size(); ++v) {
        if (pieces.of_vertex[v] == kInvalidIndex) continue;
        std::uint32_t& best = first[pieces.of_vertex[v]];
        if (best == kInvalidIndex || place(v) < place(best)) best = v;
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
