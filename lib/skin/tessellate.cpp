#include "skin/tessellate.h"

#include "base/index.h"
#include "base/parallel.h"
#include "skin/ball_loops.h"
#include "skin/edge_flips.h"
#include "skin/face_point_placement.h"
#include "skin/facet_beneath.h"
#include "skin/hull.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

namespace betamesh {

namespace {

// The first face of each ball, as the faces of a ball follow one another.
std::vector<std::uint32_t> firstFaces(const BallBoundary& boundary) {
    std::vector<std::uint32_t> count(boundary.position.size(), 0);
    for (const std::uint32_t ball : boundary.face_ball) ++count[ball];
    return exclusiveScan(count);
}

// The triangles of all directions, each listed at its lowest corner.
class DirectionTriangles {
public:
    explicit DirectionTriangles(const Icosphere& sphere) : at_(sphere.position.size()) {
        for (const Triangle& t : sphere.triangles) at_[*std::min_element(t.begin(), t.end())].push_back(t);
    }
    // Calls visit(triangle) for every triangle with all corners among the given directions; corners are indices of
    // that list. index: a buffer that is kInvalidIndex throughout between calls.
    template <typename Visit>
    void among(const std::vector<std::uint32_t>& directions, std::vector<std::uint32_t>& index,
               const Visit& visit) const {
        index.resize(at_.size(), kInvalidIndex);
        for (std::uint32_t i = 0; i < directions.size(); ++i) index[directions[i]] = i;
        for (const std::uint32_t d : directions)
            for (const auto& [a, b, c] : at_[d])
                if (index[a] != kInvalidIndex && index[b] != kInvalidIndex && index[c] != kInvalidIndex)
                    visit(Triangle{index[a], index[b], index[c]});
        for (const std::uint32_t d : directions) index[d] = kInvalidIndex;
    }

private:
    std::vector<std::vector<Triangle>> at_;
};

constexpr std::uint32_t kNewPoint = std::uint32_t{1} << 31;

// What one task makes. Corners of triangles are network points or, from kNewPoint on, rows of `point`.
struct Part {
    struct Ball {
        std::uint32_t triangles, points;  // numbers of these before the ball
    };
    struct OtherPoint {  // a new point that is no face point
        DualVec3 vertex;
        Dual rim_distance;
    };
    std::vector<Ball> ball;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> point;  // rows of FacePoints or, from kNewPoint on, of `other`
    std::vector<OtherPoint> other;
    std::vector<FadingVertex> fading, flipping;
    std::uint32_t volume_offsets = 0;  // number of face points with one

    void add(const OtherPoint& o) {
        point.push_back(kNewPoint + static_cast<std::uint32_t>(other.size()));
        other.push_back(o);
    }
};

// What the mesh of one ball is made from. The points of its filling are those of the loops, then face points, then new
// ones.
struct Ball {
    const BallLoops& loops;
    const ArcNetwork& network;
    const std::vector<std::uint32_t>& face_point;  // rows of FacePoints, lowered ones last
    std::size_t first_lowered;                     // in face_point
    const std::vector<Vec3>& on_grid;              // all points on the hull's grid
    const FacePointPlacement& placement;
    DualVec3 centre;
    Dual radius;

    std::size_t inLoops() const { return loops.network_point.size(); }
    std::size_t given() const { return loops.loops.point.size(); }  // without new points
    // Position of a face point, world units.
    DualVec3 vertexAt(std::uint32_t face_point_row) const { return centre + placement.at(face_point_row) * radius; }
    // Position of any given point relative to the centre, in radii.
    DualVec3 at(std::uint32_t v) const {
        return v < inLoops() ? (network.point[loops.network_point[v]] - centre) / radius
                             : placement.at(face_point[v - inLoops()]);
    }
};

// Adds the filling of a ball's loops to a part: first its triangles, then what fades.
class FillingAdder {
public:
    // Memory reused from ball to ball.
    struct Buffers {
        std::vector<std::uint32_t> number, first, ring;
        std::vector<EdgeFlip> edges;
    };

    FillingAdder(const Ball& ball, const LoopFilling& filling, Part& part, Buffers& buffers)
        : ball_(ball),
          filling_(filling),
          part_(part),
          first_triangle_(part.triangles.size()),
          number_(buffers.number),
          first_(buffers.first),
          ring_(buffers.ring),
          edges_(buffers.edges) {
        number_ = ball.loops.network_point;
        number_.resize(ball.given() + filling.new_point.size(), kInvalidIndex);
        for (const auto& [a, b, c] : filling.triangles) part.triangles.push_back({number(a), number(b), number(c)});
    }

    // Lists the lowered points that are blended towards the facet beneath them.
    void addFadingPoints() {
        const std::size_t count = ball_.face_point.size();
        if (ball_.given() == ball_.inLoops() || ball_.first_lowered == count) return;
        first_.resize(ball_.given() + filling_.new_point.size());
        for (auto f = static_cast<std::uint32_t>(filling_.triangles.size()); f-- > 0;)  // slivers come last
            for (const std::uint32_t v : filling_.triangles[f]) first_[v] = f;
        for (std::size_t i = ball_.first_lowered; i < count; ++i) {
            const auto v = static_cast<std::uint32_t>(ball_.inLoops() + i);
            if (number_[v] == kInvalidIndex) continue;
            listRing(v);
            if (ring_.size() > kLongestRing) continue;
            const Vec3& here = ball_.on_grid[v];
            if (isFarAbove(here, ball_.placement.freeHeight(), ring_, ball_.on_grid)) continue;
            const auto facet = facetBeneath(here, ring_, ball_.on_grid);
            if (!facet) continue;
            const auto& [a, b, c] = *facet;
            const PointOverFacet beneath(ball_.at(v), {ball_.at(a), ball_.at(b), ball_.at(c)});
            const Dual weight = ball_.placement.fadeWeight(ball_.face_point[i], beneath.height);
            if (weight.value >= 1) continue;
            FadingVertex fading{number_[v],
                                {a, b, c, c},
                                {beneath.weight[0], beneath.weight[1], beneath.weight[2], 0},
                                weight,
                                ball_.vertexAt(ball_.face_point[i])};
            attachToFlippingEdge(ring_, fading);
            for (std::uint32_t& corner : fading.support) corner = number_[corner];
            part_.fading.push_back(fading);
        }
    }

    // Splits the edges of the hull whose flip is in progress.
    void addFlippingEdges() {
        const std::size_t fixed_from = ball_.inLoops(), fixed_to = fixed_from + ball_.first_lowered;
        const std::size_t given = ball_.given();
        const double farthest = ball_.placement.flipDistance();
        // Points that are not lowered are in fixed directions, and edges among them never flip.
        const auto isFixed = [&](const Triangle& t) {
            return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v >= fixed_from && v < fixed_to; });
        };
        const std::vector<Vec3>& at = ball_.on_grid;
        edges_.clear();
        for (std::uint32_t f = 0; f < filling_.triangles.size(); ++f) {
            const Triangle& t = filling_.triangles[f];
            if (isFixed(t)) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
                const std::uint32_t beyond = filling_.across[f][k];
                if (beyond == kInvalidIndex) continue;
                const Triangle& u = filling_.triangles[beyond];
                if (beyond < f && !isFixed(u)) continue;  // listed from that side
                const std::uint32_t d = u[0] != a && u[0] != b ? u[0] : u[1] != a && u[1] != b ? u[1] : u[2];
                if (std::max({a, b, c, d}) >= given || !passNear(at[a], at[b], at[c], at[d], farthest * kHullRadius))
                    continue;
                auto edge = edgeFlip({ball_.at(a), ball_.at(b), ball_.at(c), ball_.at(d)}, farthest);
                if (!edge) continue;
                edge->corner = {number_[a], number_[b], number_[c], number_[d]};
                edge->triangle = {f, beyond};
                edges_.push_back(*edge);
            }
        }
        keepNearestFlips(edges_);
        const auto first_vertex = kNewPoint + static_cast<std::uint32_t>(part_.point.size());
        splitFlippingEdges(edges_, first_triangle_, first_vertex, part_.triangles);
        for (const EdgeFlip& edge : edges_) {
            const DualVec3 vertex = ball_.centre + edge.on_edge * ball_.radius;
            const auto row = kNewPoint + static_cast<std::uint32_t>(part_.point.size());
            part_.flipping.push_back({row, edge.corner, edge.weight, 0, vertex});
            part_.add({vertex, kMaxRimDistance});  // its corners determine how it is smoothed
        }
    }

private:
    // Lists the given points next to a point, in the order of the triangles round it; if slivers interrupt these, in
    // both directions as far as the slivers.
    void listRing(std::uint32_t v) {
        ring_.clear();
        const auto add = [&](std::uint32_t other) {
            if (other < ball_.given()) ring_.push_back(other);
        };
        const auto cornerAt = [&](const Triangle& t) { return t[0] == v ? 0U : t[1] == v ? 1U : 2U; };
        std::uint32_t f = first_[v], last = f;
        while (f != kInvalidIndex) {
            const Triangle& t = filling_.triangles[last = f];
            const std::size_t k = cornerAt(t);
            add(t[(k + 1) % 3]);
            f = filling_.across[f][(k + 2) % 3];
            if (f == first_[v]) return;
        }
        add(filling_.triangles[last][(cornerAt(filling_.triangles[last]) + 2) % 3]);
        for (f = first_[v];;) {
            f = filling_.across[f][cornerAt(filling_.triangles[f])];
            if (f == kInvalidIndex) return;
            add(filling_.triangles[f][(cornerAt(filling_.triangles[f]) + 1) % 3]);
        }
    }

    // If a flip of an edge of the facet beneath a point is in progress, attaches the point to the vertex on that edge
    // as well: to the facet's three corners and the one beyond the edge.
    void attachToFlippingEdge(std::span<const std::uint32_t> ring, FadingVertex& fading) const {
        const std::vector<Vec3>& at = ball_.on_grid;
        const double farthest = ball_.placement.flipDistance();
        const auto [corner, weight] = std::pair(fading.support, fading.support_weight);
        double closest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const std::uint32_t a = corner[k], b = corner[l], c = corner[m], d = facetBeyond(a, b, c, ring, at);
            if (d == c || !passNear(at[a], at[b], at[c], at[d], farthest * kHullRadius)) continue;
            const auto edge = edgeFlip({ball_.at(a), ball_.at(b), ball_.at(c), ball_.at(d)}, farthest);
            if (!edge || edge->otherWeight() <= closest) continue;
            closest = edge->otherWeight();
            const Dual edge_weight = edge->weight[0] + edge->weight[1];
            const std::array<Dual, 2> on_edge{edge->weight[0] / edge_weight, edge->weight[1] / edge_weight};
            const Dual of_first = weight[k] / on_edge[0], of_second = weight[l] / on_edge[1];
            const Dual flip_weight = of_first.value < of_second.value ? of_first : of_second;
            fading.support = {a, b, c, d};
            fading.support_weight = {weight[k] + flip_weight * (edge->weight[0] - on_edge[0]),
                                     weight[l] + flip_weight * (edge->weight[1] - on_edge[1]),
                                     weight[m] + flip_weight * edge->weight[2], flip_weight * edge->weight[3]};
        }
    }

    // The vertex of a point: a network point or from kNewPoint on, added when it is used for the first time.
    std::uint32_t number(std::uint32_t v) {
        std::uint32_t& number = number_[v];
        if (number != kInvalidIndex) return number;
        number = kNewPoint + static_cast<std::uint32_t>(part_.point.size());
        if (v < ball_.given()) {
            const std::uint32_t p = ball_.face_point[v - ball_.inLoops()];
            part_.point.push_back(p);
            part_.volume_offsets += ball_.placement.hasVolumeOffset(p);
        } else {
            const Vec3 direction = toDouble(filling_.new_point[v - ball_.given()]).normalized();
            part_.add({{ball_.centre.position + direction * ball_.radius.value,
                        ball_.centre.velocity + direction * ball_.radius.rate},
                       Dual(0)});
        }
        return number;
    }

    const Ball& ball_;
    const LoopFilling& filling_;
    Part& part_;
    std::size_t first_triangle_;
    std::vector<std::uint32_t>& number_;  // vertex of each point
    std::vector<std::uint32_t>& first_;   // first triangle of each point
    std::vector<std::uint32_t>& ring_;
    std::vector<EdgeFlip>& edges_;
};

// What all balls are tessellated from.
struct TessellationInput {
    const BallBoundary& boundary;
    const std::vector<DualVec3>& balls;
    const ArcNetwork& network;
    const FacePoints& points;
    const ArcSubdivision& subdivision;
    std::vector<std::uint32_t> first_face = firstFaces(boundary);
    BallLoopMaker loop_maker{boundary, network};
    FacePointPlacement placement{points, subdivision};
    DirectionTriangles direction_triangles{points.directions};
};

// Tessellates balls one after the other, with memory that is reused from ball to ball.
class BallTessellator {
public:
    explicit BallTessellator(const TessellationInput& input) : in_(input) {}

    // Adds the mesh of ball b to a part.
    void add(std::size_t b, Part& part) {
        part.ball.push_back(
            {static_cast<std::uint32_t>(part.triangles.size()), static_cast<std::uint32_t>(part.point.size())});
        in_.loop_maker.makeLoops(static_cast<std::uint32_t>(b), in_.first_face[b], in_.first_face[b + 1], ball_loops_);
        LoopsOnSphere& loops = ball_loops_.loops;
        const std::size_t in_loops = loops.point.size();
        addFacePoints(b);
        on_grid_.resize(loops.point.size());
        std::transform(loops.point.begin(), loops.point.end(), on_grid_.begin(), toDouble);
        const Ball ball{ball_loops_, in_.network,   face_point_,  direction_.size(),
                        on_grid_,    in_.placement, in_.balls[b], in_.boundary.worldRadiusOf(b)};
        if (in_loops == 0 && loops.perhaps_above.empty()) {  // an isolated sphere
            FillingAdder(ball, {in_.points.directions.triangles, {}, {}}, part, buffers_);
            return;
        }
        addLikelyFacets(static_cast<std::uint32_t>(in_loops));
        if (hull_.fill(loops, filling_)) {
            FillingAdder adder(ball, filling_, part, buffers_);
            if (in_.subdivision.appearance != Appearance::gradual) return;
            adder.addFadingPoints();
            adder.addFlippingEdges();
        } else {
            loops.point.resize(in_loops);
            addFans(ball, part);
        }
    }

private:
    // Adds the face points of ball b that are used to its loops, lowered ones last.
    void addFacePoints(std::size_t b) {
        LoopsOnSphere& loops = ball_loops_.loops;
        face_point_.clear();
        direction_.clear();
        for (const bool lowered : {false, true})
            for (std::uint32_t p = in_.points.begin[b]; p < in_.points.begin[b + 1]; ++p) {
                if (!in_.placement.isUsed(p) || in_.placement.isLowered(p) != lowered) continue;
                face_point_.push_back(p);
                if (!lowered) direction_.push_back(in_.points.direction[p]);
                if (in_.points.contactOf(p))
                    loops.perhaps_above.push_back(static_cast<std::uint32_t>(loops.point.size()));
                loops.point.push_back(onHullGrid(in_.placement.at(p).position));
            }
    }
    // Triangles of neighbouring directions are facets of the hull as a rule.
    void addLikelyFacets(std::uint32_t in_loops) {
        in_.direction_triangles.among(direction_, direction_index_, [&](const Triangle& t) {
            ball_loops_.loops.likely_facet.push_back({in_loops + t[0], in_loops + t[1], in_loops + t[2]});
        });
    }
    // Without face points, if there is no hull.
    void addFans(const Ball& ball, Part& part) {
        const std::vector<std::uint32_t>& face = ball_loops_.face_begin;
        for (std::size_t f = 0; f + 1 < face.size(); ++f)
            FillingAdder(ball, fillWithFan(ball_loops_.loops, face[f], face[f + 1]), part, buffers_);
    }

    const TessellationInput& in_;
    HullFiller hull_;
    LoopFilling filling_;
    BallLoops ball_loops_;
    FillingAdder::Buffers buffers_;
    std::vector<std::uint32_t> face_point_, direction_, direction_index_;
    std::vector<Vec3> on_grid_;
};

// The rows of the mesh at which each part begins, and one entry past the last.
struct PartRows {
    std::vector<std::uint32_t> vertices, triangles, fading, flipping, volume_offsets;

    explicit PartRows(const std::vector<Part>& parts)
        : vertices(firstRows(parts, [](const Part& part) { return part.point.size(); })),
          triangles(firstRows(parts, [](const Part& part) { return part.triangles.size(); })),
          fading(firstRows(parts, [](const Part& part) { return part.fading.size(); })),
          flipping(firstRows(parts, [](const Part& part) { return part.flipping.size(); })),
          volume_offsets(firstRows(parts, [](const Part& part) { return part.volume_offsets; })) {}

private:
    template <typename SizeOf>
    static std::vector<std::uint32_t> firstRows(const std::vector<Part>& parts, const SizeOf& sizeOf) {
        std::vector<std::uint32_t> sizes;
        for (const Part& part : parts) sizes.push_back(static_cast<std::uint32_t>(sizeOf(part)));
        return exclusiveScan(sizes);
    }
};

// The points of the network, then room for the vertices, triangles and fading vertices of all parts. Takes points over.
void takePointsAndResize(const PartRows& rows, std::size_t balls, bool have_scales, ArcNetwork& network,
                         BetaMesh& mesh) {
    const std::size_t in_network = network.point.size();
    mesh.vertex = std::move(network.point);
    firstTouchResize(mesh.vertex, in_network + rows.vertices.back());
    firstTouchResize(mesh.rim_distance, mesh.vertex.size());
    if (have_scales) mesh.scale.resize(mesh.vertex.size());
    firstTouchResize(mesh.triangles, rows.triangles.back());
    mesh.fading[kOnEdges] = std::move(network.fading);
    firstTouchResize(mesh.fading[kOnFacets], rows.fading.back());
    firstTouchResize(mesh.fading[kInQuads], rows.flipping.back());
    firstTouchResize(mesh.volume_offsets, rows.volume_offsets.back());
    mesh.ball_begin.assign(balls + 1, rows.triangles.back());
}

// Copies the parts to their rows of the mesh.
class PartCopier {
public:
    // in_network: number of the network's points; near_tangent: of each ball
    PartCopier(const TessellationInput& input, const CompressedRows<NearTangentNeighbour>& near_tangent,
               const PartRows& rows, std::size_t in_network, BetaMesh& mesh)
        : in_(input), near_tangent_(near_tangent), rows_(rows), in_network_(in_network), mesh_(mesh) {}

    // Of part p.
    void copy(const Part& part, std::size_t p) const {
        const auto first = static_cast<std::uint32_t>(in_network_ + rows_.vertices[p]);
        copyVertices(part, p, first);
        std::transform(part.triangles.begin(), part.triangles.end(), mesh_.triangles.begin() + rows_.triangles[p],
                       [&](const Triangle& t) {
                           return Triangle{numbered(t[0], first), numbered(t[1], first), numbered(t[2], first)};
                       });
        copyFading(part.fading, first, mesh_.fading[kOnFacets].data() + rows_.fading[p]);
        copyFading(part.flipping, first, mesh_.fading[kInQuads].data() + rows_.flipping[p]);
    }

private:
    // The vertex of the mesh; first: that of the part's first new point.
    static std::uint32_t numbered(std::uint32_t v, std::uint32_t first) {
        return v >= kNewPoint ? first + (v - kNewPoint) : v;
    }
    void copyVertices(const Part& part, std::size_t p, std::uint32_t first) const {
        VolumeOffset* offset = mesh_.volume_offsets.data() + rows_.volume_offsets[p];
        for (std::size_t k = 0; k < part.ball.size(); ++k) {
            const std::size_t b = p * kBallsPerTask + k;
            mesh_.ball_begin[b] = rows_.triangles[p] + part.ball[k].triangles;
            const std::size_t end = k + 1 < part.ball.size() ? part.ball[k + 1].points : part.point.size();
            for (std::size_t i = part.ball[k].points; i < end; ++i)
                copyVertex(part, part.point[i], b, first + static_cast<std::uint32_t>(i), offset);
        }
    }
    // Sets vertex v of ball b from a row of Part::point, and the next volume offset if it has one.
    void copyVertex(const Part& part, std::uint32_t point, std::size_t b, std::uint32_t v,
                    VolumeOffset*& offset) const {
        const Dual radius = in_.boundary.worldRadiusOf(b);
        if (!mesh_.scale.empty()) mesh_.scale[v] = static_cast<float>(in_.boundary.scaleOf(b));
        if (point >= kNewPoint) {
            mesh_.vertex[v] = part.other[point - kNewPoint].vertex;
            mesh_.rim_distance[v] = part.other[point - kNewPoint].rim_distance;
            return;
        }
        mesh_.vertex[v] = in_.balls[b] + in_.placement.at(point) * radius;
        mesh_.rim_distance[v] = in_.placement.rimDistance(point);
        if (in_.placement.hasVolumeOffset(point))
            *offset++ = {v, in_.placement.volumeOffset(point, near_tangent_[b]) * radius};
    }
    static void copyFading(const std::vector<FadingVertex>& from, std::uint32_t first, FadingVertex* to) {
        for (const FadingVertex& vertex : from) {
            *to = vertex;
            to->vertex = numbered(vertex.vertex, first);
            for (std::uint32_t& v : to->support) v = numbered(v, first);
            ++to;
        }
    }

    const TessellationInput& in_;
    const CompressedRows<NearTangentNeighbour>& near_tangent_;
    const PartRows& rows_;
    std::size_t in_network_;
    BetaMesh& mesh_;
};

}  // namespace

BetaMesh completeTessellation(const BallBoundary& boundary, const std::vector<DualVec3>& balls, ArcNetwork network,
                              FacePoints points, const ArcSubdivision& subdivision) {
    const CompressedRows<NearTangentNeighbour> near_tangent = nearTangentNeighbours(boundary, balls, network, points);
    BetaMesh mesh;
    mesh.scale = network.pointScales(boundary);
    std::exchange(network.line, {}), std::exchange(network.at_ball, {});  // large and no longer needed
    const TessellationInput input{boundary, balls, network, points, subdivision};
    const auto parts =
        parallelParts<Part>(balls.size(), kBallsPerTask, [&](std::size_t begin, std::size_t end, Part& part) {
            BallTessellator tessellator(input);
            for (std::size_t b = begin; b < end; ++b) tessellator.add(b, part);
        });
    const PartRows rows(parts);
    const std::size_t in_network = network.point.size();
    takePointsAndResize(rows, balls.size(), !boundary.radius_of.empty(), network, mesh);
    const PartCopier copier(input, near_tangent, rows, in_network, mesh);
    parallelFor(parts.size(), 4, [&](std::size_t p) { copier.copy(parts[p], p); });
    return mesh;
}

}  // namespace betamesh
