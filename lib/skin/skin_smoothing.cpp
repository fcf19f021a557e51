
#include "skin/skin_smoothing.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

// All lengths are in particle spacings.
constexpr int kNarrowSteps = 3;         // of the bi-Laplacian in a pass
constexpr float kNarrowGain = 1.6F;     // of a step: as much as four steps of 1, and less than what would oscillate
constexpr double kNarrowWidth = 0.8;    // of its kernel
constexpr double kLongestNarrow = 0.15; // of a step
constexpr double kStepWidth = 0.3;      // of the mean over the last of them, so that slivers do not fold
constexpr double kNormalWidth = 0.5;    // of the normals along which vertices go

constexpr double kLeastWidth = 0.8;              // of a fit
constexpr double kFitBegins = 1, kFitFull = 2;   // widths between which fits fade in
constexpr double kOwnBegins = 4, kOwnFull = 5.4; // widths between which vertices go their own steps, not mean ones
constexpr double kLongestFit = 0.3;              // of a step onto a sphere
constexpr double kFlatSphere = 1e-3;             // added to the variance of what is fitted: a little of it is flat
// Cosines to a vertex' normal, as it is over kSidewaysWidth, between which a surface faces sideways: neither the same
// way nor the opposite one; and how far from there it fades in.
constexpr float kSame = 0.5F, kOpposite = -0.3F, kSidewaysFade = 0.25F;
constexpr double kSidewaysWidth = 1.2;
constexpr double kWall = 0.6366;         // 2 / π: D⁻² is this times the sum over a wall across the surface, D away
constexpr double kPieceCell = 4;         // edge of the cells in which pieces of the surface are grouped
constexpr std::size_t kMostPieces = 4096;
// Edges of what is thick are rounded: fits are so wide there whatever turns sideways. What faces the opposite way takes
// that back as far as it is near, on rims of sheets and on threads.
constexpr double kEdgeWidth = 2.5;
constexpr double kThin = 2;
constexpr float kLeastSquare = 0.02F;    // added to squared distances there

constexpr int kReturns = 3;              // how often what was lost of long waves returns
constexpr double kReturnWidth = 5.4;     // of the mean over it
constexpr int kUnfoldings = 2;           // once before, for fits go by how vertices face

using Normals = std::vector<Vec3f>;

enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kValue, kFields };
using Samples = SampleRuns<kFields>;

struct Point {
    const Lanes (&place)[3];
    const Lanes (&normal)[3];
};

// Σ w A v over what faces the point's way, and Σ w A; v the height over the tangent plane, or the sample's value.
template <bool kHeight>
struct SumFacing {
    Samples samples;
    float inverse_square_width;
    Point point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3];
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        const Some zero{}, one = zero + 1.0F;
        Some sum[2] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            Some t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) * inverse_square_width;
            Some c = f[kNx] * n[0] + f[kNy] * n[1] + f[kNz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some w = t * t * c * f[kArea];
            sum[1] += w;
            if constexpr (kHeight)
                sum[0] += w * (p[0] * n[0] + p[1] * n[1] + p[2] * n[2]);
            else
                sum[0] += w * f[kValue];
        });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Of each vertex the mean of heights over its tangent plane, or of values, over what is near and faces its way.
template <bool kHeight>
std::vector<float> meansAlong(DeformingMesh& surface, const Normals& normal, const std::vector<float>& value) {
    std::vector<float> mean(surface.size());
    constexpr auto inverse = static_cast<float>(1 / (kNarrowWidth * kNarrowWidth));
    surface.forVicinities<kFields>(
        kNarrowWidth,
        [&](std::uint32_t v, SampleFields<kFields>& f) {
            const Vec3f& n = normal[v];
            f[kArea] = surface.area(v), f[kNx] = n.x, f[kNy] = n.y, f[kNz] = n.z;
            f[kValue] = kHeight ? 0 : value[v];
        },
        [&](const GroupLanes& group, Samples samples) {
            const GroupLanes::Vectors n = group.of(normal);
            Lanes sums[2];
            forLanes(SumFacing<kHeight>{samples, inverse, {group.place, n.lanes}, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                mean[group.row[lane]] = sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0;
        });
    return mean;
}

Normals smoothNormals(const DeformingMesh& surface) {
    return surface.softNormals(kNormalWidth, surface.meanNormals()).normal;
}

// Moves vertices by the means of their steps, or, of `own` that share, by their own. own: none: 0.
void moveTogether(DeformingMesh& surface, std::vector<Vec3f>& step, const std::vector<float>& own = {}) {
    const std::vector<Vec3f> mean = surface.means(kStepWidth, step);
    parallelFor(step.size(), 8192, [&](std::size_t v) {
        const float share = own.empty() ? 0 : own[v];
        step[v] = step[v] * share + mean[v] * (1 - share);
    });
    surface.move(step);
}

std::vector<Vec3f> along(const Normals& normal, const std::vector<float>& height) {
    std::vector<Vec3f> step(height.size());
    parallelFor(step.size(), 8192, [&](std::size_t v) { step[v] = normal[v] * height[v]; });
    return step;
}

// One step of the bi-Laplacian.
void smoothNarrowly(DeformingMesh& surface, const Normals& normal, bool is_last) {
    std::vector<float> height = meansAlong<true>(surface, normal, {});
    const std::vector<float> mean = meansAlong<false>(surface, normal, height);
    constexpr auto longest = static_cast<float>(kLongestNarrow);
    parallelFor(height.size(), 8192,
                [&](std::size_t v) { height[v] = std::clamp(kNarrowGain * (height[v] - mean[v]), -longest, longest); });
    std::vector<Vec3f> step = along(normal, height);
    if (is_last)
        moveTogether(surface, step);
    else
        surface.move(step);
}

// A piece of the surface: what is on one ball and faces about one way.
struct Piece {
    Vec3 position;
    Vec3f direction;     // mean normal, shorter than 1 where the piece is curved
    float area, spread;  // square units: its own, and the mean squared distance from the position
    float bulge;         // mean height along the normals, units
    std::array<float, 2> value;  // means of values of the vertices
};

enum PieceField { kPx, kPy, kPz, kPdx, kPdy, kPdz, kPieceArea, kSpread, kBulge, kPieceValue, kPieceFields };
using PieceSamples = SampleRuns<kPieceFields>;

constexpr std::size_t kCorners = 4;

// Sums over triangles, about an origin: exact integrals, which do not change when a plane polygon is cut otherwise.
struct Moments {
    double area = 0, square = 0, along = 0;
    std::array<double, 2> value{};
    Vec3 first{0}, direction{0};

    void add(const Vec3& a, const Vec3& b, const Vec3& c, const std::array<double, 2>& value_sum, double share) {
        const Vec3 across = cross(b - a, c - a) / 2 * share;
        const double here = across.length();
        const Vec3 sum = a + b + c;
        area += here;
        first += sum * (here / 3);
        direction += across;
        square += here / 12 * (dot(a, a) + dot(b, b) + dot(c, c) + dot(sum, sum));
        along += dot(a, across);
        for (std::size_t k = 0; k < 2; ++k) value[k] += value_sum[k] / 3 * here;
    }
    Piece piece(const Vec3& origin, double unit) const {
        const Vec3 middle = first / area;
        const Vec3 mean = direction / area;
        return {origin + middle * unit,
                Vec3f(mean),
                static_cast<float>(area),
                static_cast<float>(std::max(0.0, square / area - dot(middle, middle))),
                static_cast<float>(along / area - dot(middle, mean)),
                {static_cast<float>(value[0] / area), static_cast<float>(value[1] / area)}};
    }
};

std::vector<Piece> componentsOf(const DeformingMesh& surface, const std::vector<std::array<float, 2>>& value) {
    const BetaMesh& mesh = surface.mesh();
    const double unit = surface.spacing(), scale = 1 / unit;
    const std::array<Vec3, kCorners> corner{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
    constexpr std::size_t kBallsPerTask = 256;
    // Without balls, where voids were left out: runs of triangles would do as well, but the balls are known.
    const std::size_t balls = mesh.ball_begin.empty() ? 0 : mesh.ball_begin.size() - 1;
    const std::size_t tasks = (balls + kBallsPerTask - 1) / kBallsPerTask;
    std::vector<std::vector<Piece>> parts(tasks);
    parallelFor(tasks, 1, [&](std::size_t task) {
        for (std::size_t b = task * kBallsPerTask; b < std::min(balls, (task + 1) * kBallsPerTask); ++b) {
            const std::uint32_t begin = mesh.ball_begin[b], end = mesh.ball_begin[b + 1];
            if (begin == end) continue;
            const Vec3 origin = surface.position()[mesh.triangles[begin][0]];
            const auto forTriangles = [&](const auto& visit) {
                const auto placeOf = [&](std::uint32_t v) { return (surface.position()[v] - origin) * scale; };
                for (std::uint32_t t = begin; t < end; ++t) {
                    const auto& [i, j, k] = mesh.triangles[t];
                    std::array<double, 2> sum{};
                    if (!value.empty())
                        for (std::size_t m = 0; m < 2; ++m)
                            sum[m] = static_cast<double>(value[i][m]) + value[j][m] + value[k][m];
                    visit(placeOf(i), placeOf(j), placeOf(k), sum);
                }
            };
            Moments whole;
            forTriangles([&](const Vec3& p, const Vec3& q, const Vec3& r, const auto& sum) {
                whole.add(p, q, r, sum, 1);
            });
            if (!(whole.area > 0)) continue;
            const double agreement = whole.direction.length() / whole.area;
            const double apart = 1 - smoothStep((agreement - 0.75) / 0.15).value;
            const auto add = [&](const Moments& m, double share) {
                if (!(m.area * share > 1e-9)) return;
                parts[task].push_back(m.piece(origin, unit));
                parts[task].back().area *= static_cast<float>(share);
            };
            add(whole, 1 - apart);
            if (!(apart > 0)) continue;
            std::array<Moments, kCorners> towards;
            forTriangles([&](const Vec3& p, const Vec3& q, const Vec3& r, const auto& sum) {
                const Vec3 normal = cross(q - p, r - p).normalized();
                std::array<double, kCorners> share;
                double all = 0;
                for (std::size_t m = 0; m < kCorners; ++m) {
                    const double s = 1 + dot(normal, corner[m]) * 0.577, s2 = s * s, s4 = s2 * s2;
                    all += share[m] = s4 * s4;
                }
                for (std::size_t m = 0; m < kCorners; ++m) towards[m].add(p, q, r, sum, share[m] / all);
            });
            for (const Moments& m : towards) add(m, apart);
        }
    });
    return concatenate(parts);
}

// Σ A u / (d² + spread)², fading out at the end of its reach, u from 0 to 1 where a piece faces sideways, neither the
// point's way nor the opposite one: of a wall across the surface at distance D that is π / 2 D². And the same of what
// faces the opposite way.
struct SumSideways {
    PieceSamples samples;
    float inverse_square_reach;
    Point point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3];
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        const Some zero{}, one = zero + 1.0F;
        Some sum[2] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            const Some square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kSpread] + kLeastSquare;
            const Some t = f[kPdx] * n[0] + f[kPdy] * n[1] + f[kPdz] * n[2];
            Some u = (kSame + kSidewaysFade - t) / kSidewaysFade, v = (t - kOpposite + kSidewaysFade) / kSidewaysFade;
            u = u < v ? u : v;
            u = u < one ? u : one;
            u = u > 0 ? u : zero;
            Some within = one - square * inverse_square_reach;
            within = within > 0 ? within : zero;
            Some opposite = (kOpposite - t) / kSidewaysFade;
            opposite = opposite < one ? opposite : one;
            opposite = opposite > 0 ? opposite : zero;
            const Some w = f[kPieceArea] * within * within / (square * square);
            sum[0] += w * u;
            sum[1] += w * opposite;
        });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Σk, Σk y, Σk d, Σk y·d, Σk |y|² for a sphere fit; each point has its own width.
struct SumFit {
    PieceSamples samples;
    const Lanes& inverse_square_width;
    Point point;
    Lanes (&sums)[9];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3], inverse;
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        std::memcpy(&inverse, reinterpret_cast<const float*>(&inverse_square_width) + first, sizeof inverse);
        const Some zero{}, one = zero + 1.0F;
        Some sum[9] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            const Some square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kSpread];
            Some t = one - square * inverse;
            Some c = f[kPdx] * n[0] + f[kPdy] * n[1] + f[kPdz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some k = t * t * c * c * f[kPieceArea];
            sum[0] += k;
            sum[1] += k * p[0];
            sum[2] += k * p[1];
            sum[3] += k * p[2];
            sum[4] += k * f[kPdx];
            sum[5] += k * f[kPdy];
            sum[6] += k * f[kPdz];
            sum[7] += k * (p[0] * f[kPdx] + p[1] * f[kPdy] + p[2] * f[kPdz] + f[kBulge]);
            sum[8] += k * square;
        });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Σ k value and Σ k; each point has its own width.
struct SumValues {
    PieceSamples samples;
    const Lanes& inverse_square_width;
    Point point;
    Lanes (&sums)[2];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3], inverse;
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        std::memcpy(&inverse, reinterpret_cast<const float*>(&inverse_square_width) + first, sizeof inverse);
        const Some zero{}, one = zero + 1.0F;
        Some sum[2] = {};
        samples.forEach(x, [&](const auto& f, const Some(&p)[3]) __attribute__((always_inline)) {
            Some t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kSpread]) * inverse;
            Some c = f[kPdx] * n[0] + f[kPdy] * n[1] + f[kPdz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some k = t * t * c * c * f[kPieceArea];
            sum[0] += k * f[kPieceValue];
            sum[1] += k;
        });
        setLanes<kWidth>(sums, first, sum);
    }
};

// From a point onto the sphere fitted to the sums.
Vec3 stepOntoSphere(const Lanes (&sums)[9], std::size_t lane) {
    const double weight = sums[0][lane];
    if (!(weight > 0)) return Vec3(0);
    const Vec3 a = Vec3(sums[1][lane], sums[2][lane], sums[3][lane]) / weight,
               b = Vec3(sums[4][lane], sums[5][lane], sums[6][lane]) / weight;
    const double c = sums[7][lane] / weight, e = sums[8][lane] / weight;
    const double quadratic = (c - dot(a, b)) / (2 * (e - dot(a, a) + kFlatSphere));
    const Vec3 linear = b - a * (2 * quadratic);
    const double constant = -(dot(linear, a) + quadratic * e), slope = dot(linear, linear);
    if (!(slope > 1e-9)) return Vec3(0);
    const double root = std::sqrt(std::max(0.0, slope * slope - 4 * quadratic * constant * slope));
    return linear * (-2 * constant / (slope + root));
}

// Components of a surface, in groups.
struct GroupedPieces {
    std::vector<Piece> piece;
    std::vector<Vec3> position;
    PointGroups groups;

    GroupedPieces(std::vector<Piece>&& pieces, double spacing) : piece(std::move(pieces)), position(piece.size()) {
        const auto setPositions = [&] {
            parallelFor(position.size(), 8192, [&](std::size_t i) { position[i] = piece[i].position; });
        };
        setPositions();
        std::vector<std::uint32_t> order;
        groups = PointGroups(position, kPieceCell * spacing, order);
        piece = inOrder(piece, order);
        setPositions();
        groups.fitBoxes(position);
    }
};

// Calls visit(group of points, pieces within reach, normals of the group's lanes).
template <typename Visit>
void forPieces(const PointGroups& points, const std::vector<Vec3>& point, const GroupedPieces& pieces, double unit,
               double reach, const Normals& normal, const Visit& visit) {
    forGroups<kPieceFields>(
        points, point, pieces.groups, pieces.position, unit, kMostPieces, [&](std::size_t) { return reach * unit; },
        [&](std::uint32_t i, SampleFields<kPieceFields>& f) {
            const Piece& p = pieces.piece[i];
            f[kPdx] = p.direction.x, f[kPdy] = p.direction.y, f[kPdz] = p.direction.z;
            f[kPieceArea] = p.area, f[kSpread] = p.spread, f[kBulge] = p.bulge, f[kPieceValue] = p.value[0];
        },
        [&](const GroupLanes& group, PieceSamples samples) {
            const GroupLanes::Vectors n = group.of(normal);
            visit(group, samples, Point{group.place, n.lanes});
        });
}

std::vector<float> inverseSquares(const std::vector<float>& width) {
    std::vector<float> inverse(width.size());
    parallelFor(inverse.size(), 8192, [&](std::size_t v) { inverse[v] = 1 / (width[v] * width[v]); });
    return inverse;
}

// How wide each vertex may be smoothed: as far as the surface does not turn sideways, or the liquid is thick.
std::vector<float> widthsOf(DeformingMesh& surface, const GroupedPieces& pieces, const Normals& wide, double widest) {
    std::vector<float> width(surface.size());
    const auto inverse = static_cast<float>(1 / (widest * widest));
    const auto visit = [&](const GroupLanes& group, PieceSamples near, const Point& point) {
        Lanes sums[2];
        forLanes(SumSideways{near, inverse, point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const double sideways = kWall * static_cast<double>(sums[0][lane]);
            const double most = 1 / (kEdgeWidth * kEdgeWidth) + kThin * kWall * static_cast<double>(sums[1][lane]);
            const double inverse_square = 1 / (widest * widest) + sideways * most / (sideways + most);
            width[group.row[lane]] = static_cast<float>(std::max(kLeastWidth, 1 / std::sqrt(inverse_square)));
        }
    };
    forPieces(surface.groups(), surface.position(), pieces, surface.spacing(), widest, wide, visit);
    surface.hold(width);
    return width;
}

double shareOfFit(float width) { return smoothStep((width - kFitBegins) / (kFitFull - kFitBegins)).value; }

// Moves vertices onto spheres; returns how wide those were fitted.
std::vector<float> fitSpheres(DeformingMesh& surface, double widest) {
    const Normals normal = smoothNormals(surface);
    const Normals wide = surface.softNormals(kSidewaysWidth, normal).normal;
    const GroupedPieces pieces(componentsOf(surface, {}), surface.spacing());
    std::vector<float> width = widthsOf(surface, pieces, wide, widest);
    const std::vector<float> inverse_square = inverseSquares(width);
    std::vector<Vec3f> step(surface.size(), Vec3f(0));
    const auto visit = [&](const GroupLanes& group, PieceSamples near, const Point& point) {
        Lanes inverse, sums[9];
        for (std::size_t lane = 0; lane < kLanes; ++lane) inverse[lane] = inverse_square[group.row[lane]];
        forLanes(SumFit{near, inverse, point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const std::uint32_t v = group.row[lane];
            Vec3 onto = stepOntoSphere(sums, lane) * shareOfFit(width[v]);
            if (const double length = onto.length(); length > kLongestFit) onto *= kLongestFit / length;
            step[v] = Vec3f(onto);
        }
    };
    forPieces(surface.groups(), surface.position(), pieces, surface.spacing(), widest, normal, visit);
    std::vector<float> own(width.size());
    parallelFor(own.size(), 8192, [&](std::size_t v) {
        own[v] = static_cast<float>(smoothStep((width[v] - kOwnBegins) / (kOwnFull - kOwnBegins)).value);
    });
    moveTogether(surface, step, own);
    surface.measure();
    return width;
}

// Means of the pieces' values over what faces the way of each of some points, which has its own width.
template <typename Visit>
void forMeans(const PointGroups& points, const std::vector<Vec3>& point, const GroupedPieces& pieces, double unit,
              const Normals& normal, const std::vector<float>& inverse_square, const Visit& visit) {
    forPieces(points, point, pieces, unit, kReturnWidth, normal,
              [&](const GroupLanes& group, PieceSamples near, const Point& at) {
                  Lanes inverse, sums[2];
                  for (std::size_t lane = 0; lane < kLanes; ++lane) inverse[lane] = inverse_square[group.row[lane]];
                  forLanes(SumValues{near, inverse, at, sums});
                  for (std::size_t lane = 0; lane < group.size; ++lane)
                      visit(group.row[lane], sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0);
              });
}

// Moves vertices along their normals by the mean of what was lost since `before`, then by that of what still misses,
// and so on: of pieces of the surface, and of vertices by the sum of it all.
void returnLongWaves(DeformingMesh& surface, const Normals& normal, const std::vector<Vec3>& before,
                     const std::vector<float>& width) {
    std::vector<float> lost(surface.size()), least(surface.size());
    parallelFor(least.size(), 8192, [&](std::size_t v) {
        const Vec3 back = before[v] - surface.position()[v];
        lost[v] = static_cast<float>(dot(back, Vec3(normal[v])) / surface.spacing());
        least[v] = std::min(width[v], static_cast<float>(kReturnWidth));
    });
    surface.hold(lost);
    std::vector<std::array<float, 2>> lost_and_width(surface.size());
    parallelFor(least.size(), 8192, [&](std::size_t v) { lost_and_width[v] = {lost[v], width[v]}; });
    GroupedPieces pieces(componentsOf(surface, lost_and_width), surface.spacing());
    const std::size_t n = pieces.piece.size();
    Normals facing(n);
    std::vector<float> missing(n), whole(n), least_of_piece(n), mean(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Piece& piece = pieces.piece[i];
        facing[i] = piece.direction.normalized();
        missing[i] = whole[i] = piece.value[0];
        least_of_piece[i] = std::min(piece.value[1], static_cast<float>(kReturnWidth));
    }
    const std::vector<float> inverse_square = inverseSquares(least_of_piece);
    for (int i = 1; i < kReturns; ++i) {
        forMeans(pieces.groups, pieces.position, pieces, surface.spacing(), facing, inverse_square,
                 [&](std::uint32_t p, float of_missing) { mean[p] = of_missing; });
        for (std::size_t p = 0; p < n; ++p) {
            missing[p] -= mean[p] * static_cast<float>(shareOfFit(pieces.piece[p].value[1]));
            whole[p] += missing[p];
            pieces.piece[p].value[0] = missing[p];
        }
    }
    for (std::size_t p = 0; p < n; ++p) pieces.piece[p].value[0] = whole[p];
    std::vector<float> height(surface.size());
    forMeans(surface.groups(), surface.position(), pieces, surface.spacing(), normal, inverseSquares(least),
             [&](std::uint32_t v, float returned) { height[v] = returned * static_cast<float>(shareOfFit(width[v])); });
    std::vector<Vec3f> step = along(normal, height);
    moveTogether(surface, step);
}

}  // namespace

void smoothSkin(DeformingMesh& surface, double widest, double farthest, int passes) {
    const std::vector<Vec3> retracted = surface.position();
    for (int pass = 0; pass < passes; ++pass) {
        surface.unfold();
        const std::vector<Vec3> before = surface.position();
        const std::vector<float> width = fitSpheres(surface, std::max(widest, kLeastWidth));
        const Normals normal = smoothNormals(surface);
        for (int i = 1; i <= kNarrowSteps; ++i) smoothNarrowly(surface, normal, i == kNarrowSteps);
        returnLongWaves(surface, normal, before, width);
        surface.measure();
        for (int i = 0; i < kUnfoldings; ++i) surface.unfold();
    }
    std::vector<Vec3f> back(surface.size());
    parallelFor(back.size(), 8192, [&](std::size_t v) {
        const Vec3 way = (surface.position()[v] - retracted[v]) / surface.spacing();
        const double s2 = way.length2() / (farthest * farthest), s4 = s2 * s2, s8 = s4 * s4;
        back[v] = Vec3f(way * (std::pow(1 + s8 * s8, -1.0 / 16) - 1));  // hardly anything below two thirds of it
    });
    surface.move(back);
}

}  // namespace betamesh
