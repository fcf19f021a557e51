
#include "skin/exposed_region.h"

#include "base/icosphere.h"
#include "base/index.h"
#include "base/simd.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace betamesh {

namespace {

constexpr double kSlack = 1e-5;      // radii: far above the rounding of anything here
constexpr double kRounding = 1e-13;  // likewise of how far a corner is beyond a plane, where both are rounded once
constexpr std::size_t kMostInDoubt = 24;
constexpr float kOutOfReach = 1e30F;

// The place where three walls meet, exactly: twice the place, times a scale. Offsets are at most 2^21 long and levels
// at most 2^42, so that whatever is asked of it is within 2^112.
class Meeting {
public:
    template <typename Bisector>
    Meeting(const Bisector& a, const Bisector& b, const Bisector& c) {
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
    // +1 where it is beyond the plane half way to another place.
    int sideOf(const Neighbour& other) const {
        const Vec3i u(other.offset);
        const Int beyond =
            u.x * twice_[0] + u.y * twice_[1] + u.z * twice_[2] - static_cast<Int>(other.squared) * scale_;
        return ((beyond > 0) - (beyond < 0)) * (scale_ > 0 ? 1 : -1);
    }

private:
    using Int = __int128;
    std::array<Int, 3> twice_;
    Int scale_;
};

// Offsets become unit normals, squares of their lengths distances of planes half way.
BETAMESH_EVERY_CPU
void normalise(std::size_t n, float half, float* x, float* y, float* z, float* squared) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
        const float length = std::sqrt(squared[i]), inverse = 1 / length;
        x[i] *= inverse;
        y[i] *= inverse;
        z[i] *= inverse;
        squared[i] = length * half;
    }
}

// The planes that places lie farthest beyond, the first of these, and how far.
template <std::size_t kPlaces>
struct FarthestBeyond {
    const ExposedRegion::Planes& planes;
    const std::vector<float>& distances;
    const std::array<Vec3f, kPlaces>& place;
    std::array<float, kPlaces>&beyond, &plane;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        Some most[kPlaces], most_at[kPlaces] = {}, at;
        for (Some& m : most) m = Some{} - kOutOfReach;
        setNumbers<kWidth>(at);
        for (std::size_t i = 0; i < planes.x.size(); i += kWidth, at += static_cast<float>(kWidth)) {
            Some x, y, z, distance;
            std::memcpy(&x, &planes.x[i], sizeof x);
            std::memcpy(&y, &planes.y[i], sizeof y);
            std::memcpy(&z, &planes.z[i], sizeof z);
            std::memcpy(&distance, &distances[i], sizeof distance);
            for (std::size_t p = 0; p < kPlaces; ++p) {
                const Some far = x * place[p].x + y * place[p].y + z * place[p].z - distance;
                most_at[p] = far > most[p] ? at : most_at[p];
                most[p] = far > most[p] ? far : most[p];
            }
        }
        for (std::size_t p = 0; p < kPlaces; ++p) {
            takeLargest<kWidth>(most[p], beyond[p]);
            if (beyond[p] > -static_cast<float>(kSlack)) takeFirst<kWidth>(most[p], beyond[p], most_at[p], plane[p]);
        }
    }
};

// Directions of which one is near every other: no farther than the angle given here.
struct Directions {
    DirectionColumns column;
    double cosine = 1, sine;

    Directions() : Directions(icosphere(2)) {}
    explicit Directions(const Icosphere& sphere) : column(inOrder(sphere.position)) {
        for (const auto& [a, b, c] : sphere.triangles) {
            const Vec3 &at = sphere.position[a], &left = sphere.position[b], &right = sphere.position[c];
            cosine = std::min(cosine, dot(cross(left - at, right - at).normalized(), at) - kSlack);
        }
        sine = std::sqrt(1 - cosine * cosine);
    }

private:
    static std::vector<Vec3> inOrder(std::vector<Vec3> directions) {  // those of a register near each other
        std::sort(directions.begin(), directions.end(), [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
        return directions;
    }
};

// Where planes are as seen from a direction that is to be beyond them with all that is near it.
BETAMESH_EVERY_CPU
void setRims(std::size_t n, const float* distance, float cosine, float sine, float* rim) {
    for (std::size_t i = 0; i < n; ++i) {
        const float h = distance[i], apart = 1 - h * h;
        const float seen = h * cosine + std::sqrt(apart > 0 ? apart : 0) * sine + static_cast<float>(kSlack);
        rim[i] = h < cosine ? seen : kOutOfReach;
    }
}

// Is every direction beyond a plane, with all that is near it?
struct CoverAll {
    const DirectionColumns& directions;
    const ExposedRegion::Planes& planes;
    const std::vector<float>& rim;
    bool& all;

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()() const {
        using Some = Floats<kWidth>;
        constexpr std::size_t kAtOnce = 8;
        const std::size_t n = rim.size();
        all = false;
        for (std::size_t d = 0; d < directions.size(); d += kWidth) {
            Some x, y, z, short_of = Some{} + kOutOfReach;
            std::memcpy(&x, &directions.x[d], sizeof x);
            std::memcpy(&y, &directions.y[d], sizeof y);
            std::memcpy(&z, &directions.z[d], sizeof z);
            float farthest = kOutOfReach;
            for (std::size_t i = 0; i < n && farthest > 0;) {
                for (const std::size_t end = std::min(n, i + kAtOnce); i < end; ++i) {
                    const Some left = rim[i] - (x * planes.x[i] + y * planes.y[i] + z * planes.z[i]);
                    short_of = left < short_of ? left : short_of;
                }
                takeLargest<kWidth>(short_of, farthest);
            }
            if (farthest > 0) return;
        }
        all = true;
    }
};

// Where the way from a place inside the ball to one that is not leaves it, in radii.
Vec3 leavesBallAt(const Vec3& inner, const Vec3& outer) {
    const Vec3 way = outer - inner;
    const double a = dot(way, way), b = dot(inner, way), c = inner.length2() - 1;
    return inner + way * std::min(1.0, (std::sqrt(std::max(0.0, b * b - a * c)) - b) / a);
}

}  // namespace

void ExposedRegion::setPlanes(const std::vector<Neighbour>& neighbours) {
    const std::size_t n = neighbours.size(), whole = (n + kLanes - 1) / kLanes * kLanes;
    auto& [x, y, z, distance] = planes_;
    for (std::vector<float>* axis : {&x, &y, &z, &distance}) axis->resize(whole);
    for (std::size_t i = 0; i < n; ++i) {
        const Neighbour& neighbour = neighbours[i];
        x[i] = static_cast<float>(neighbour.offset.x);
        y[i] = static_cast<float>(neighbour.offset.y);
        z[i] = static_cast<float>(neighbour.offset.z);
        distance[i] = static_cast<float>(neighbour.squared);
    }
    normalise(n, static_cast<float>(0.5 / radius_), x.data(), y.data(), z.data(), distance.data());
    for (std::size_t i = n; i < whole; ++i) {
        x[i] = y[i] = z[i] = 0;
        distance[i] = kOutOfReach;
    }
}

void ExposedRegion::put(const Corner& corner, const Vec3& at, std::size_t place) {
    corner_[place] = corner;
    x_[place] = at.x, y_[place] = at.y, z_[place] = at.z;
    const auto& [a, b, c] = corner.wall;
    corner_at_[a][b] = corner_at_[b][c] = corner_at_[c][a] = static_cast<std::uint16_t>(place);
}

void ExposedRegion::beginWithTetrahedron() {
    constexpr double kInner = 1 + 4 * kSlack;
    const std::array<Vec3, 4> towards{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kWalls{{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
    walls_ = 0b1111;
    corners_ = 4;
    for (std::size_t k = 0; k < 4; ++k) {  // each corner is opposite the wall of the same number
        const Vec3 normal = towards[k].normalized();
        const double level = std::ceil(2 * std::sqrt(3.0) * kInner * radius_);
        wall_[k] = {normal, level / (2 * std::sqrt(3.0) * radius_), towards[k], level, kInvalidIndex};
        put({kWalls[k], true, false, {}, kInvalidIndex}, normal * (-3 * wall_[k].distance), k);
    }
    outer_ = 4;
}

// Lists the corners that a wall makes where it cuts others off: on every edge from one of these to one that stays.
// False where rounding leaves them without order.
bool ExposedRegion::listNewCorners(std::uint8_t wall) {
    constexpr double kInside = 1 - 2 * kSlack;
    struct Edge {  // between walls a and b
        std::uint16_t cut, stays;
        std::uint8_t a, b;
    };
    std::array<Edge, 3 * kMostCorners> edge;
    std::size_t edges = 0;
    std::size_t outer = outer_;
    for (std::size_t i = 0; i < cut_count_; ++i) {
        outer -= corner_[cut_[i]].outer;
        const auto& [a, b, c] = corner_[cut_[i]].wall;
        const auto list = [&](std::uint8_t from, std::uint8_t to) {
            const std::uint16_t other = corner_at_[to][from];
            edge[edges] = {cut_[i], other, from, to};
            edges += !(beyond_[other] > 0);
        };
        list(a, b), list(b, c), list(c, a);
    }
    if (edges < 3 || edges > kMostBisectors) return false;
    std::uint64_t begun = 0;
    std::array<std::uint8_t, kMostBisectors> next;
    for (std::size_t i = 0; i < edges; ++i) {
        const auto& [cut, stays, a, b] = edge[i];
        begun |= std::uint64_t{1} << a;
        next[a] = b;
        const double share = beyond_[cut] / (beyond_[cut] - beyond_[stays]);
        const Vec3 from = placeOf(cut);
        const Vec3 place = exactly_ ? Meeting(wall_[a], wall_[b], wall_[wall]).rounded() / radius_
                                    : from + (placeOf(stays) - from) * share;
        const bool is_outer = place.length2() >= kInside * kInside;
        outer += is_outer;
        new_place_[i] = place;
        new_corner_[i] = {{a, b, wall}, is_outer, false, {}, kInvalidIndex};
    }
    const std::uint8_t first = edge[0].a;  // are they one ring?
    std::size_t round = 1;
    for (std::uint8_t a = next[first]; a != first; a = next[a], ++round)
        if (!(begun >> a & 1) || round > edges) return false;
    new_corners_ = edges;
    if (round != edges) return false;
    outer_ = outer;
    return true;
}

// A bit for each wall that has a corner, or one that is not inside the ball.
std::uint64_t ExposedRegion::wallsOf(bool outer_only) const {
    std::uint64_t walls = 0;
    for (const Corner& corner : std::span(corner_).first(corners_))
        for (const std::uint8_t w : corner.wall) walls |= std::uint64_t{!outer_only || corner.outer} << w;
    return walls;
}

// Cuts off what lies beyond a neighbour's plane. False where that is nothing, or in doubt.
bool ExposedRegion::clip(std::uint32_t neighbour) {
    if (~walls_ == 0) walls_ = wallsOf(false);
    const auto free = static_cast<std::size_t>(std::countr_one(walls_));
    if (free == kMostBisectors) return false;
    const Neighbour& n = (*all_)[neighbour];
    const double length = std::sqrt(n.squared);
    const double distance = length / (2 * radius_);
    const Bisector& wall =
        wall_[free] = {n.offset / length, exactly_ ? distance : distance + kSlack, n.offset, n.squared, neighbour};

    for (std::size_t c = 0; c < corners_; c += 4)  // and some more, of which nothing is asked
        for (std::size_t k = c; k < c + 4; ++k)
            beyond_[k] = x_[k] * wall.normal.x + y_[k] * wall.normal.y + z_[k] * wall.normal.z - wall.distance;
    if (exactly_)
        for (std::size_t c = 0; c < corners_; ++c)
            if (std::abs(beyond_[c]) < kRounding) beyond_[c] = sideOf(corner_[c], n);
    cut_count_ = 0;
    for (std::size_t c = 0; c < corners_; ++c) {
        cut_[cut_count_] = static_cast<std::uint16_t>(c);
        cut_count_ += beyond_[c] > 0;
    }
    if (cut_count_ == 0 || !listNewCorners(static_cast<std::uint8_t>(free))) return false;
    walls_ |= std::uint64_t{1} << free;
    for (std::size_t i = 0; i < new_corners_; ++i)
        put(new_corner_[i], new_place_[i], i < cut_count_ ? cut_[i] : corners_ + i - cut_count_);
    const std::size_t all = corners_ - cut_count_ + new_corners_;
    for (std::size_t hole = cut_count_; hole-- > new_corners_;)  // the last ones move there
        if (const std::size_t last = --corners_; cut_[hole] < last) put(corner_[last], placeOf(last), cut_[hole]);
    corners_ = all;
    return true;
}

void ExposedRegion::take(std::uint32_t neighbour) {
    left_[neighbour] = kOutOfReach;
    if (clip(neighbour)) return;
    part_.push_back({neighbour, false});
    ++in_doubt_;
}

// The neighbours whose planes places lie farthest beyond, but for rounding, and how far; kInvalidIndex where one is beyond
// nobody's.
template <std::size_t kPlaces>
std::array<ExposedRegion::Farthest, kPlaces> ExposedRegion::farthestBeyond(
    const std::array<Vec3f, kPlaces>& place) const {
    std::array<float, kPlaces> beyond, plane;
    onThisCpu(FarthestBeyond<kPlaces>{planes_, left_, place, beyond, plane});
    std::array<Farthest, kPlaces> farthest;
    for (std::size_t p = 0; p < kPlaces; ++p) {
        const bool any = beyond[p] > -static_cast<float>(kSlack);
        farthest[p] = {any ? static_cast<std::uint32_t>(plane[p]) : kInvalidIndex, beyond[p]};
    }
    return farthest;
}

// Takes the neighbour nearest to a place into account, if it may be nearer than this ball; true where none may.
bool ExposedRegion::settle(const Vec3& place) {
    const auto [farthest] = farthestBeyond<1>({Vec3f(place)});
    if (farthest.neighbour == kInvalidIndex) return true;
    take(farthest.neighbour);
    return false;
}

// The first corner from there on that is to be settled, or how many there are.
std::size_t ExposedRegion::nextToVerify(std::size_t corner) const {
    while (corner < corners_ && (corner_[corner].seen || !(corner_[corner].outer || exactly_))) ++corner;
    return corner;
}

// As settle() of a corner. Asks for the one after it, too, as two take little longer than one: its answer holds until
// that plane is taken.
bool ExposedRegion::verifyVertex(std::size_t corner) {
    std::uint32_t farthest = corner_[corner].farthest;
    if (farthest == kInvalidIndex || left_[farthest] == kOutOfReach) {
        const std::size_t next = nextToVerify(corner + 1), other = next < corners_ ? next : corner;
        const auto [here, there] = farthestBeyond<2>({Vec3f(placeOf(corner)), Vec3f(placeOf(other))});
        corner_[other].farthest = there.neighbour;
        corner_[other].seen = there.neighbour == kInvalidIndex;
        farthest = here.neighbour;
    }
    if (farthest == kInvalidIndex) return true;
    take(farthest);
    return false;
}

// +1 where a corner is beyond the plane of a neighbour.
int ExposedRegion::sideOf(const Corner& corner, const Neighbour& neighbour) const {
    const auto& [a, b, c] = corner.wall;
    return Meeting(wall_[a], wall_[b], wall_[c]).sideOf(neighbour);
}

// As settle() of a corner, where the cell is exact. Whoever touches it there bounds it, too.
bool ExposedRegion::verifyExactly(std::size_t corner) {
    const Vec3 place = placeOf(corner);
    const Vec3f at(place);
    const auto [about] = farthestBeyond<1>({at});
    if (about.neighbour == kInvalidIndex) return true;
    const std::vector<float>&x = planes_.x, &y = planes_.y, &z = planes_.z;
    const float least = about.beyond - 2 * static_cast<float>(kSlack);
    std::uint32_t farthest = kInvalidIndex;
    double most = 0;
    for (std::uint32_t n = 0; n < all_->size(); ++n) {
        if (x[n] * at.x + y[n] * at.y + z[n] * at.z - left_[n] < least) continue;
        const Neighbour& neighbour = (*all_)[n];
        const double length = std::sqrt(neighbour.squared);
        double far = dot(place, neighbour.offset / length) - length / (2 * radius_);
        if (far < -kRounding) continue;
        if (far < kRounding) {
            const int side = sideOf(corner_[corner], neighbour);
            if (side == 0) part_.push_back({n, false});
            if (side <= 0) continue;
            far = std::abs(far);
        }
        if (farthest == kInvalidIndex || far > most) farthest = n, most = far;
    }
    if (farthest == kInvalidIndex) return true;
    take(farthest);
    return false;
}

void ExposedRegion::settleCorners() {
    for (std::size_t c = nextToVerify(0); c < corners_ && !empty() && (exactly_ || in_doubt_ <= kMostInDoubt);
         c = nextToVerify(c))
        if (exactly_ ? verifyExactly(c) : verifyVertex(c))
            corner_[c].seen = true;
        else
            c = std::min<std::size_t>(c, cut_[0]);  // from there on they may be others now
}

// False as soon as something may have changed.
bool ExposedRegion::settleEdges() {
    for (std::size_t c = 0; c < corners_; ++c) {
        Corner& corner = corner_[c];
        for (std::size_t k = 0; k < 3 && !corner.outer; ++k) {
            const std::size_t beyond = corner_at_[corner.wall[(k + 1) % 3]][corner.wall[k]];
            if (corner.edge_seen[k] || !corner_[beyond].outer) continue;
            if (!settle(leavesBallAt(placeOf(c), placeOf(beyond)))) return false;
            corner.edge_seen[k] = true;
        }
    }
    return true;
}

bool ExposedRegion::isHiddenBy(const std::vector<Neighbour>& neighbours) {
    static const Directions directions;
    setPlanes(neighbours);
    rim_.resize(neighbours.size());
    setRims(rim_.size(), planes_.distance.data(), static_cast<float>(directions.cosine),
            static_cast<float>(directions.sine), rim_.data());
    bool all;
    onThisCpu(CoverAll{directions.column, planes_, rim_, all});
    if (all) return true;
    all_ = &neighbours;
    enclose();
    return empty();
}

void ExposedRegion::enclose(const std::vector<Neighbour>& neighbours) {
    setPlanes(neighbours);
    all_ = &neighbours;
    enclose();
}

void ExposedRegion::enclose() {
    exactly_ = false;
    makeCell();
    if (in_doubt_ > kMostInDoubt) {
        exactly_ = true;
        makeCell();
    }
    // What is beyond no true plane of a wall is beyond none that walls made superfluous, as all are the same way off;
    // and on the sphere it is beyond no other, as corners would be. A wall without corners outside the ball bounds
    // nothing on the sphere, but may cover what lies between its true plane and its own.
    const std::uint64_t outer = wallsOf(true);
    for (std::uint64_t walls = wallsOf(false); walls != 0; walls &= walls - 1) {
        const int w = std::countr_zero(walls);
        const std::uint32_t n = wall_[static_cast<std::size_t>(w)].neighbour;
        if (n != kInvalidIndex) part_.push_back({n, (outer >> w & 1) == 0});
    }
    std::sort(part_.begin(), part_.end());
    neighbours_.clear();
    bounding_.clear();
    std::uint32_t last = kInvalidIndex;
    for (const auto& [n, covers_only] : part_) {
        if (n == last) continue;
        last = n;
        neighbours_.push_back((*all_)[n]);
        if (!covers_only) bounding_.push_back(n);
    }
}

void ExposedRegion::makeCell() {
    part_.clear();
    left_ = planes_.distance;
    in_doubt_ = 0;
    beginWithTetrahedron();
    do settleCorners();
    while (!exactly_ && in_doubt_ <= kMostInDoubt && !empty() && !settleEdges());
}

}  // namespace betamesh
