#include "skin/exposed_region.h"

#include "base/icosphere.h"
#include "base/index.h"
#include "base/intersection_circle.h"
#include "base/simd.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kSlack = 1e-5;            // radii, far above the rounding of any single-precision result here
constexpr double kRounding = 1e-13;        // radii, above the rounding of a vertex's distance from a plane in doubles
constexpr std::size_t kMostDoubtful = 24;  // bisectors not usable for clipping; with more the cell is made exactly
constexpr float kOutOfReach = 1e30F;       // distance of a plane that no point lies beyond

// The point where three bisector planes meet, exactly, in homogeneous coordinates: twice the point times a scale.
// Offsets are at most 2^21 long and levels at most 2^42, so everything here stays within 2^112.
class BisectorIntersection {
public:
    template <typename Bisector>
    BisectorIntersection(const Bisector& a, const Bisector& b, const Bisector& c) {
        const Vec3i u(a.offset), v(b.offset), w(c.offset), vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
        const auto along = [&](int k) {
            return static_cast<Int>(a.level) * vw[k] + static_cast<Int>(b.level) * wu[k] +
                   static_cast<Int>(c.level) * uv[k];
        };
        for (int k = 0; k < 3; ++k) twice_[static_cast<std::size_t>(k)] = along(k);
        scale_ = Int{u.x} * vw.x + Int{u.y} * vw.y + Int{u.z} * vw.z;
    }
    Vec3 rounded() const {
        const auto along = [&](Int x) { return static_cast<double>(x) / (2 * static_cast<double>(scale_)); };
        return {along(twice_[0]), along(twice_[1]), along(twice_[2])};
    }
    // +1 if it lies beyond the bisector of another neighbour, 0 if on it, -1 otherwise.
    int sideOf(const Neighbour& other) const {
        const Vec3i u(other.offset);
        const Int beyond = u.x * twice_[0] + u.y * twice_[1] + u.z * twice_[2] - static_cast<Int>(other.power) * scale_;
        return ((beyond > 0) - (beyond < 0)) * (scale_ > 0 ? 1 : -1);
    }

private:
    using Int = __int128;
    std::array<Int, 3> twice_;
    Int scale_;
};

// Turns offsets into unit normals, and their squared lengths into distances of bisector planes.
BETAMESH_EVERY_CPU
void toPlanes(std::size_t n, float half, float* x, float* y, float* z, float* squared) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float length = std::sqrt(squared[i]), inverse = 1 / length;
        x[i] *= inverse;
        y[i] *= inverse;
        z[i] *= inverse;
        squared[i] = length * half;
    }
}

// The same for balls of different radii, with the powers of their centres in the place of squared lengths.
BETAMESH_EVERY_CPU
void toPlanesOfUnequal(std::size_t n, float half, float* x, float* y, float* z, float* power) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float inverse = 1 / std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        x[i] *= inverse;
        y[i] *= inverse;
        z[i] *= inverse;
        power[i] *= inverse * half;
    }
}

// For each point the first of the planes that it lies farthest beyond, and by how much.
template <std::size_t kPoints>
struct FarthestBeyond {
    const ExposedRegion::Planes& planes;
    const std::vector<float>& distances;
    const std::array<Vec3f, kPoints>& point;
    std::array<float, kPoints>&beyond, &plane;  // plane: an index, set only where beyond exceeds -kSlack

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Pack = Floats<kWidth>;
        Pack most[kPoints], most_at[kPoints] = {}, at;
        for (Pack& m : most) m = Pack{} - kOutOfReach;
        setLaneNumbers<kWidth>(at);
        for (std::size_t i = 0; i < planes.x.size(); i += kWidth, at += static_cast<float>(kWidth)) {
            Pack x, y, z, distance;
            std::memcpy(&x, &planes.x[i], sizeof x);
            std::memcpy(&y, &planes.y[i], sizeof y);
            std::memcpy(&z, &planes.z[i], sizeof z);
            std::memcpy(&distance, &distances[i], sizeof distance);
            for (std::size_t p = 0; p < kPoints; ++p) {
                const Pack far = x * point[p].x + y * point[p].y + z * point[p].z - distance;
                most_at[p] = far > most[p] ? at : most_at[p];
                most[p] = far > most[p] ? far : most[p];
            }
        }
        for (std::size_t p = 0; p < kPoints; ++p) {
            largestLane<kWidth>(most[p], beyond[p]);
            if (beyond[p] > -static_cast<float>(kSlack))
                firstLaneEqual<kWidth>(most[p], beyond[p], most_at[p], plane[p]);
        }
    }
};

// Fixed directions, and the largest angle from any direction to the nearest of them.
struct CoveringDirections {
    DirectionColumns column;
    double cosine = 1, sine;

    CoveringDirections() : CoveringDirections(icosphere(2)) {}
    explicit CoveringDirections(const Icosphere& sphere) : column(sortedByHeight(sphere.position)) {
        for (const auto& [a, b, c] : sphere.triangles) {
            const Vec3 &at = sphere.position[a], &left = sphere.position[b], &right = sphere.position[c];
            cosine = std::min(cosine, dot(cross(left - at, right - at).normalized(), at) - kSlack);
        }
        sine = std::sqrt(1 - cosine * cosine);
    }

private:
    // Sorted, so that the directions in one register are near each other.
    static std::vector<Vec3> sortedByHeight(std::vector<Vec3> directions) {
        std::sort(directions.begin(), directions.end(), [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
        return directions;
    }
};

// For each plane the least component along its normal with which a direction lies beyond it together with everything
// within the angle of CoveringDirections.
BETAMESH_EVERY_CPU
void setRims(std::size_t n, const float* distance, float cosine, float sine, float* rim) {
    for (std::size_t i = 0; i < n; ++i) {
        const float h = distance[i], apart = 1 - h * h;
        const float seen = h * cosine + std::sqrt(apart > 0 ? apart : 0) * sine + static_cast<float>(kSlack);
        rim[i] = h < cosine ? seen : kOutOfReach;
    }
}

// Does every direction, with all that is near it, lie beyond some plane?
struct CoverAllDirections {
    const DirectionColumns& directions;
    const ExposedRegion::Planes& planes;
    const std::vector<float>& rim;
    bool& all;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Pack = Floats<kWidth>;
        constexpr std::size_t kAtOnce = 8;
        const std::size_t n = rim.size();
        all = false;
        for (std::size_t d = 0; d < directions.size(); d += kWidth) {
            Pack x, y, z, least_excess = Pack{} + kOutOfReach;
            std::memcpy(&x, &directions.x[d], sizeof x);
            std::memcpy(&y, &directions.y[d], sizeof y);
            std::memcpy(&z, &directions.z[d], sizeof z);
            float worst = kOutOfReach;
            for (std::size_t i = 0; i < n && worst > 0;) {
                for (const std::size_t end = std::min(n, i + kAtOnce); i < end; ++i) {
                    const Pack excess = rim[i] - (x * planes.x[i] + y * planes.y[i] + z * planes.z[i]);
                    least_excess = excess < least_excess ? excess : least_excess;
                }
                largestLane<kWidth>(least_excess, worst);
            }
            if (worst > 0) return;
        }
        all = true;
    }
};

// Where the segment from a point inside the ball to one outside leaves it, in radii.
Vec3 exitFromBall(const Vec3& inner, const Vec3& outer) {
    const Vec3 segment = outer - inner;
    const double a = dot(segment, segment), b = dot(inner, segment), c = inner.length2() - 1;
    return inner + segment * std::min(1.0, (std::sqrt(std::max(0.0, b * b - a * c)) - b) / a);
}

}  // namespace

// The distance of a bisector from the centre of the ball, in radii. length: of the neighbour's offset.
double ExposedRegion::distanceOf(const Neighbour& neighbour, double length) const {
    return heightOfIntersection<double>(length, radius_, neighbour.radius);
}

void ExposedRegion::setPlanes(const std::vector<Neighbour>& neighbours, std::int64_t radius) {
    radius_ = static_cast<double>(radius);
    const std::size_t n = neighbours.size(), whole = (n + kLanes - 1) / kLanes * kLanes;
    auto& [x, y, z, distance] = planes_;
    for (std::vector<float>* axis : {&x, &y, &z, &distance}) axis->resize(whole);
    bool all_equal = true;
    for (std::size_t i = 0; i < n; ++i) {
        const Neighbour& neighbour = neighbours[i];
        x[i] = static_cast<float>(neighbour.offset.x);
        y[i] = static_cast<float>(neighbour.offset.y);
        z[i] = static_cast<float>(neighbour.offset.z);
        distance[i] = static_cast<float>(neighbour.power);
        all_equal &= neighbour.radius == radius;
    }
    const auto half = static_cast<float>(0.5 / radius_);
    (all_equal ? toPlanes : toPlanesOfUnequal)(n, half, x.data(), y.data(), z.data(), distance.data());
    for (std::size_t i = n; i < whole; ++i) {
        x[i] = y[i] = z[i] = 0;
        distance[i] = kOutOfReach;
    }
}

void ExposedRegion::setVertex(const CellVertex& vertex, const Vec3& position, std::size_t row) {
    vertex_[row] = vertex;
    x_[row] = position.x, y_[row] = position.y, z_[row] = position.z;
    const auto& [a, b, c] = vertex.bisector;
    vertex_at_[a][b] = vertex_at_[b][c] = vertex_at_[c][a] = static_cast<std::uint16_t>(row);
}

void ExposedRegion::startWithTetrahedron() {
    constexpr double kInner = 1 + 4 * kSlack;
    const std::array<Vec3, 4> towards{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kBisectors{{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
    bisectors_ = 0b1111;
    vertices_ = 4;
    for (std::size_t k = 0; k < 4; ++k) {  // vertex k is opposite bisector k
        const Vec3 normal = towards[k].normalized();
        const double level = std::ceil(2 * std::sqrt(3.0) * kInner * radius_);
        bisector_[k] = {normal, level / (2 * std::sqrt(3.0) * radius_), towards[k], level, kInvalidIndex};
        setVertex({kBisectors[k], true, false, {}, kInvalidIndex}, normal * (-3 * bisector_[k].distance), k);
    }
    outer_ = 4;
}

// Lists the vertices that a bisector creates where it cuts others off: one on every edge from a vertex cut off to one
// kept. False if rounding leaves them without a consistent order.
bool ExposedRegion::listNewVertices(std::uint8_t bisector) {
    constexpr double kInside = 1 - 2 * kSlack;
    struct Edge {  // between bisectors a and b, from a vertex cut off to one kept
        std::uint16_t cut_off, kept;
        std::uint8_t a, b;
    };
    std::array<Edge, 3 * kMostVertices> edge;
    std::size_t edges = 0;
    std::size_t outer = outer_;
    for (std::size_t i = 0; i < cut_off_count_; ++i) {
        outer -= vertex_[cut_off_[i]].outer;
        const auto& [a, b, c] = vertex_[cut_off_[i]].bisector;
        const auto list = [&](std::uint8_t from, std::uint8_t to) {
            const std::uint16_t other = vertex_at_[to][from];
            edge[edges] = {cut_off_[i], other, from, to};
            edges += !(beyond_[other] > 0);
        };
        list(a, b), list(b, c), list(c, a);
    }
    if (edges < 3 || edges > kMostBisectors) return false;
    std::uint64_t begun = 0;
    std::array<std::uint8_t, kMostBisectors> next;
    for (std::size_t i = 0; i < edges; ++i) {
        const auto& [cut_off, kept, a, b] = edge[i];
        begun |= std::uint64_t{1} << a;
        next[a] = b;
        const double fraction = beyond_[cut_off] / (beyond_[cut_off] - beyond_[kept]);
        const Vec3 from = positionOf(cut_off);
        const Vec3 position =
            exact_ ? BisectorIntersection(bisector_[a], bisector_[b], bisector_[bisector]).rounded() / radius_
                   : from + (positionOf(kept) - from) * fraction;
        const bool is_outer = position.length2() >= kInside * kInside;
        outer += is_outer;
        new_position_[i] = position;
        new_vertex_[i] = {{a, b, bisector}, is_outer, false, {}, kInvalidIndex};
    }
    const std::uint8_t first = edge[0].a;  // do the new vertices form one ring?
    std::size_t round = 1;
    for (std::uint8_t a = next[first]; a != first; a = next[a], ++round)
        if (!(begun >> a & 1) || round > edges) return false;
    new_vertices_ = edges;
    if (round != edges) return false;
    outer_ = outer;
    return true;
}

// A bit for each bisector that has a vertex; with outer_only, one outside the ball.
std::uint64_t ExposedRegion::bisectorsOf(bool outer_only) const {
    std::uint64_t bisectors = 0;
    for (const CellVertex& vertex : std::span(vertex_).first(vertices_))
        for (const std::uint8_t w : vertex.bisector) bisectors |= std::uint64_t{!outer_only || vertex.outer} << w;
    return bisectors;
}

// Clips the cell by the bisector of a neighbour. False if that cuts off nothing or rounding makes the result uncertain.
bool ExposedRegion::clip(std::uint32_t neighbour) {
    if (~bisectors_ == 0) bisectors_ = bisectorsOf(false);
    const auto free = static_cast<std::size_t>(std::countr_one(bisectors_));
    if (free == kMostBisectors) return false;
    const Neighbour& n = (*all_)[neighbour];
    const double length = std::sqrt(n.squaredDistance());
    const double distance = distanceOf(n, length);
    const Bisector& bisector =
        bisector_[free] = {n.offset / length, exact_ ? distance : distance + kSlack, n.offset, n.power, neighbour};

    for (std::size_t c = 0; c < vertices_; c += 4)  // up to three more are computed, and ignored
        for (std::size_t k = c; k < c + 4; ++k)
            beyond_[k] =
                x_[k] * bisector.normal.x + y_[k] * bisector.normal.y + z_[k] * bisector.normal.z - bisector.distance;
    if (exact_)
        for (std::size_t c = 0; c < vertices_; ++c)
            if (std::abs(beyond_[c]) < kRounding) beyond_[c] = sideOf(vertex_[c], n);
    cut_off_count_ = 0;
    for (std::size_t c = 0; c < vertices_; ++c) {
        cut_off_[cut_off_count_] = static_cast<std::uint16_t>(c);
        cut_off_count_ += beyond_[c] > 0;
    }
    if (cut_off_count_ == 0 || !listNewVertices(static_cast<std::uint8_t>(free))) return false;
    bisectors_ |= std::uint64_t{1} << free;
    for (std::size_t i = 0; i < new_vertices_; ++i)
        setVertex(new_vertex_[i], new_position_[i], i < cut_off_count_ ? cut_off_[i] : vertices_ + i - cut_off_count_);
    const std::size_t all = vertices_ - cut_off_count_ + new_vertices_;
    for (std::size_t hole = cut_off_count_; hole-- > new_vertices_;)  // holes are filled with the last vertices
        if (const std::size_t last = --vertices_; cut_off_[hole] < last)
            setVertex(vertex_[last], positionOf(last), cut_off_[hole]);
    vertices_ = all;
    return true;
}

// Clips by a bisector that may matter; one that cannot be used for clipping is kept in the list of those that matter.
void ExposedRegion::addBisector(std::uint32_t neighbour) {
    unused_distance_[neighbour] = kOutOfReach;
    if (clip(neighbour)) return;
    relevant_.push_back({neighbour, false});
    ++doubtful_;
}

// For each point the neighbour whose bisector it lies farthest beyond, but for rounding, and by how much; kInvalidIndex
// if it lies beyond none.
template <std::size_t kPoints>
std::array<ExposedRegion::Farthest, kPoints> ExposedRegion::farthestBeyond(
    const std::array<Vec3f, kPoints>& point) const {
    std::array<float, kPoints> beyond, plane;
    onThisCpu(FarthestBeyond<kPoints>{planes_, unused_distance_, point, beyond, plane});
    std::array<Farthest, kPoints> farthest;
    for (std::size_t p = 0; p < kPoints; ++p) {
        const bool any = beyond[p] > -static_cast<float>(kSlack);
        farthest[p] = {any ? static_cast<std::uint32_t>(plane[p]) : kInvalidIndex, beyond[p]};
    }
    return farthest;
}

// True if a point lies beyond no bisector. Otherwise adds the one that it lies farthest beyond.
bool ExposedRegion::verifyPoint(const Vec3& point) {
    const auto [farthest] = farthestBeyond<1>({Vec3f(point)});
    if (farthest.neighbour == kInvalidIndex) return true;
    addBisector(farthest.neighbour);
    return false;
}

// The first vertex from this one on that is still to be verified, or the number of vertices.
std::size_t ExposedRegion::nextToVerify(std::size_t vertex) const {
    while (vertex < vertices_ && (vertex_[vertex].verified || !(vertex_[vertex].outer || exact_))) ++vertex;
    return vertex;
}

// As verifyPoint(), of a vertex. Tests the next vertex in the same pass, as two take little longer than one; that
// answer stays valid until its bisector is added.
bool ExposedRegion::verifyVertex(std::size_t vertex) {
    std::uint32_t farthest = vertex_[vertex].farthest;
    if (farthest == kInvalidIndex || unused_distance_[farthest] == kOutOfReach) {
        const std::size_t next = nextToVerify(vertex + 1), other = next < vertices_ ? next : vertex;
        const auto [here, there] = farthestBeyond<2>({Vec3f(positionOf(vertex)), Vec3f(positionOf(other))});
        vertex_[other].farthest = there.neighbour;
        vertex_[other].verified = there.neighbour == kInvalidIndex;
        farthest = here.neighbour;
    }
    if (farthest == kInvalidIndex) return true;
    addBisector(farthest);
    return false;
}

// Exact: +1 if a vertex lies beyond the bisector of a neighbour, 0 if on it, -1 otherwise.
int ExposedRegion::sideOf(const CellVertex& vertex, const Neighbour& neighbour) const {
    const auto& [a, b, c] = vertex.bisector;
    return BisectorIntersection(bisector_[a], bisector_[b], bisector_[c]).sideOf(neighbour);
}

// As verifyVertex(), with exact signs. A neighbour whose bisector passes through the vertex matters, too.
bool ExposedRegion::verifyExactly(std::size_t vertex) {
    const Vec3 position = positionOf(vertex);
    const Vec3f rounded(position);
    const auto [about] = farthestBeyond<1>({rounded});
    if (about.neighbour == kInvalidIndex) return true;
    const std::vector<float>&x = planes_.x, &y = planes_.y, &z = planes_.z;
    const float least = about.beyond - 2 * static_cast<float>(kSlack);
    std::uint32_t farthest = kInvalidIndex;
    double most = 0;
    for (std::uint32_t n = 0; n < all_->size(); ++n) {
        if (x[n] * rounded.x + y[n] * rounded.y + z[n] * rounded.z - unused_distance_[n] < least) continue;
        const Neighbour& neighbour = (*all_)[n];
        const double length = std::sqrt(neighbour.squaredDistance());
        double far = dot(position, neighbour.offset / length) - distanceOf(neighbour, length);
        if (far < -kRounding) continue;
        if (far < kRounding) {
            const int side = sideOf(vertex_[vertex], neighbour);
            if (side == 0) relevant_.push_back({n, false});
            if (side <= 0) continue;
            far = std::abs(far);
        }
        if (farthest == kInvalidIndex || far > most) farthest = n, most = far;
    }
    if (farthest == kInvalidIndex) return true;
    addBisector(farthest);
    return false;
}

void ExposedRegion::verifyVertices() {
    for (std::size_t c = nextToVerify(0); c < vertices_ && !empty() && (exact_ || doubtful_ <= kMostDoubtful);
         c = nextToVerify(c))
        if (exact_ ? verifyExactly(c) : verifyVertex(c))
            vertex_[c].verified = true;
        else
            c = std::min<std::size_t>(c, cut_off_[0]);  // vertices from there on may have been replaced
}

// False as soon as a bisector was added.
bool ExposedRegion::verifyEdges() {
    for (std::size_t c = 0; c < vertices_; ++c) {
        CellVertex& vertex = vertex_[c];
        for (std::size_t k = 0; k < 3 && !vertex.outer; ++k) {
            const std::size_t beyond = vertex_at_[vertex.bisector[(k + 1) % 3]][vertex.bisector[k]];
            if (vertex.edge_verified[k] || !vertex_[beyond].outer) continue;
            if (!verifyPoint(exitFromBall(positionOf(c), positionOf(beyond)))) return false;
            vertex.edge_verified[k] = true;
        }
    }
    return true;
}

bool ExposedRegion::isCoveredBy(const std::vector<Neighbour>& neighbours, std::int64_t radius) {
    static const CoveringDirections directions;
    setPlanes(neighbours, radius);
    rim_.resize(neighbours.size());
    setRims(rim_.size(), planes_.distance.data(), static_cast<float>(directions.cosine),
            static_cast<float>(directions.sine), rim_.data());
    bool all;
    onThisCpu(CoverAllDirections{directions.column, planes_, rim_, all});
    if (all) return true;
    all_ = &neighbours;
    construct();
    return empty();
}

void ExposedRegion::construct(const std::vector<Neighbour>& neighbours, std::int64_t radius) {
    setPlanes(neighbours, radius);
    all_ = &neighbours;
    construct();
}

void ExposedRegion::construct() {
    exact_ = false;
    constructCell();
    if (doubtful_ > kMostDoubtful) {
        exact_ = true;
        constructCell();
    }
    // Clipping planes lie kSlack outside the true bisectors. Neighbours whose clipping planes became redundant do not
    // matter: all planes are shifted alike, so beyond their true bisectors lies nothing that is not beyond another's.
    // A bisector without vertices outside the ball bounds nothing on the sphere, but may still cover what lies between
    // its true plane and its clipping plane.
    const std::uint64_t outer = bisectorsOf(true);
    for (std::uint64_t bisectors = bisectorsOf(false); bisectors != 0; bisectors &= bisectors - 1) {
        const int w = std::countr_zero(bisectors);
        const std::uint32_t n = bisector_[static_cast<std::size_t>(w)].neighbour;
        if (n != kInvalidIndex) relevant_.push_back({n, (outer >> w & 1) == 0});
    }
    std::sort(relevant_.begin(), relevant_.end());
    neighbours_.clear();
    bounding_.clear();
    std::uint32_t last = kInvalidIndex;
    for (const auto& [n, covers_only] : relevant_) {
        if (n == last) continue;
        last = n;
        neighbours_.push_back((*all_)[n]);
        if (!covers_only) bounding_.push_back(n);
    }
}

void ExposedRegion::constructCell() {
    relevant_.clear();
    unused_distance_ = planes_.distance;
    doubtful_ = 0;
    startWithTetrahedron();
    do verifyVertices();
    while (!exact_ && doubtful_ <= kMostDoubtful && !empty() && !verifyEdges());
}

}  // namespace betamesh
