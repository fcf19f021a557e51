#include "skin/skin_smoothing.h"
#include "skin/tune.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

namespace {

using Normals = std::vector<Vec3f>;

enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kValue, kFields };
using Samples = std::span<const SampleFields<kFields>>;

struct Point {
    const Lanes (&place)[3];
    const Lanes (&normal)[3];
};

// Σ w A n over what faces the point's way.
struct SumNormals {
    Samples samples;
    float inverse_square_width;
    Point point;
    Lanes (&sums)[4];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3];
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        const Some zero{}, one = zero + 1.0F;
        Some sum[4] = {};
        for (const auto& f : samples) {
            const Some px = f[kX] - x[0], py = f[kY] - x[1], pz = f[kZ] - x[2];
            Some t = one - (px * px + py * py + pz * pz) * inverse_square_width;
            Some c = f[kNx] * n[0] + f[kNy] * n[1] + f[kNz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some w = t * t * c * c * f[kArea];
            sum[0] += w * f[kNx];
            sum[1] += w * f[kNy];
            sum[2] += w * f[kNz];
            sum[3] += w;
        }
        setLanes<kWidth>(sums, first, sum);
    }
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
        for (const auto& f : samples) {
            const Some px = f[kX] - x[0], py = f[kY] - x[1], pz = f[kZ] - x[2];
            Some t = one - (px * px + py * py + pz * pz) * inverse_square_width;
            Some c = f[kNx] * n[0] + f[kNy] * n[1] + f[kNz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some w = t * t * c * f[kArea];
            sum[1] += w;
            if constexpr (kHeight)
                sum[0] += w * (px * n[0] + py * n[1] + pz * n[2]);
            else
                sum[0] += w * f[kValue];
        }
        setLanes<kWidth>(sums, first, sum);
    }
};

// Calls take(row, lane sums) for every vertex, of sums by Kernel.
template <std::size_t kSums, typename Kernel, typename Take>
void sumUp(MovedSurface& surface, const Normals& normal, const std::vector<float>& value, double width,
           const Take& take) {
    const auto [groups, near] = surface.vicinity(width);
    const auto inverse = static_cast<float>(1 / (width * width));
    forGroups<kFields>(
        groups, surface.position(), near, surface.position(), surface.unit(),
        [&](std::uint32_t v, SampleFields<kFields>& f) {
            const Vec3f& n = normal[v];
            f[kArea] = surface.area(v), f[kNx] = n.x, f[kNy] = n.y, f[kNz] = n.z;
            f[kValue] = value.empty() ? 0.0F : value[v];
        },
        [&](const GroupLanes& group, Samples samples) {
            Lanes n[3], sums[kSums];
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (int k = 0; k < 3; ++k) n[k][lane] = normal[group.row[lane]][k];
            forLanes(Kernel{samples, inverse, {group.place, n}, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) take(group.row[lane], sums, lane);
        });
}

Normals robust(MovedSurface& surface, const Normals& from, double width) {
    std::vector<std::array<float, 3>> values(from.size());
    for (std::size_t v = 0; v < from.size(); ++v) values[v] = {from[v].x, from[v].y, from[v].z};
    values = meansOf<3>(surface, width, values);
    Normals mean(from.size());
    for (std::size_t v = 0; v < from.size(); ++v) mean[v] = Vec3f(values[v][0], values[v][1], values[v][2]).normalized();
    return mean;
}

Normals softNormals(MovedSurface& surface, const Normals& first, double width) {
    const Normals from = tune("robust", 0.3) > 0 ? robust(surface, first, tune("robust", 0.3)) : first;
    Normals soft(surface.size());
    sumUp<4, SumNormals>(surface, from, {}, width, [&](std::uint32_t v, const auto& sums, std::size_t lane) {
        const Vec3f sum(sums[0][lane], sums[1][lane], sums[2][lane]);
        const float length = sum.length();
        soft[v] = length > 0 ? sum / length : from[v];
    });
    return soft;
}

void moveBy(MovedSurface& surface, std::vector<Vec3f>& step, const std::vector<float>& width = {}) {
    if (const double reg = tune("reg", 0.3); reg > 0) {
        std::vector<std::array<float, 3>> values(step.size());
        for (std::size_t v = 0; v < step.size(); ++v) values[v] = {step[v].x, step[v].y, step[v].z};
        values = meansOf<3>(surface, reg, values);
        for (std::size_t v = 0; v < step.size(); ++v) {
            const float own = width.empty() ? 0 : static_cast<float>(smoothStep((width[v] - tune("raw0", 4)) / tune("raw1", 1.4)).value);
            step[v] = step[v] * own + Vec3f(values[v][0], values[v][1], values[v][2]) * (1 - own);
        }
    }
    surface.move(step);
}

void moveAlong(MovedSurface& surface, const Normals& normal, const std::vector<float>& height) {
    std::vector<Vec3f> step(surface.size());
    parallelFor(step.size(), 8192, [&](std::size_t v) { step[v] = normal[v] * height[v]; });
    moveBy(surface, step);
}

// Bi-Laplacian along the normal: zero on planes, spheres and cylinders, so nothing shrinks.
void smoothNarrowly(MovedSurface& surface, double width) {
    const double longest = 0.15;
    const Normals normal = softNormals(surface, surface.normals(), tune("nsmooth", 0.5));
    std::vector<float> height(surface.size()), rest(surface.size());
    const auto mean = [](const auto& sums, std::size_t lane) {
        return sums[1][lane] > 0 ? sums[0][lane] / sums[1][lane] : 0.0F;
    };
    sumUp<2, SumFacing<true>>(surface, normal, {}, width,
                              [&](std::uint32_t v, const auto& sums, std::size_t lane) { height[v] = mean(sums, lane); });
    sumUp<2, SumFacing<false>>(surface, normal, height, width,
                               [&](std::uint32_t v, const auto& sums, std::size_t lane) {
                                   rest[v] = std::clamp(height[v] - mean(sums, lane), static_cast<float>(-longest),
                                                        static_cast<float>(longest));
                               });
    moveAlong(surface, normal, rest);
}


// A piece of the surface: what is on one ball and faces about one way.
struct Piece {
    Vec3 position;
    Vec3f direction;     // mean normal, shorter than 1 where the piece is curved
    float area, spread;  // square units: its own, and the mean squared distance from the position
    float bulge;         // mean height along the normals, units
    float value;         // mean of a value of the vertices
};

enum PieceField { pX, pY, pZ, pDx, pDy, pDz, pArea, pSpread, pBulge, pValue, pFields };
using PieceSamples = std::span<const SampleFields<pFields>>;

constexpr std::size_t kCorners = 4;

// Sums over triangles, about an origin: exact integrals, which do not change when a plane polygon is cut otherwise.
struct Moments {
    double area = 0, square = 0, along = 0, value = 0;
    Vec3 first{0}, direction{0};

    void add(const Vec3& a, const Vec3& b, const Vec3& c, double value_sum, double share) {
        const Vec3 across = cross(b - a, c - a) / 2 * share;
        const double here = across.length();
        const Vec3 sum = a + b + c;
        area += here;
        first += sum * (here / 3);
        direction += across;
        square += here / 12 * (dot(a, a) + dot(b, b) + dot(c, c) + dot(sum, sum));
        along += dot(a, across);
        value += value_sum / 3 * here;
    }
    Piece piece(const Vec3& origin, double unit) const {
        const Vec3 middle = first / area;
        const Vec3 mean = direction / area;
        return {origin + middle * unit,
                Vec3f(mean),
                static_cast<float>(area),
                static_cast<float>(std::max(0.0, square / area - dot(middle, middle))),
                static_cast<float>(along / area - dot(middle, mean)),
                static_cast<float>(value / area)};
    }
};

std::vector<Piece> piecesOf(const MovedSurface& surface, const std::vector<float>& value) {
    const BetaMesh& mesh = surface.mesh();
    const double unit = surface.unit();
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
            Moments whole;
            std::array<Moments, kCorners> towards;
            for (std::uint32_t t = begin; t < end; ++t) {
                const auto& [i, j, k] = mesh.triangles[t];
                const Vec3 a = (surface.position()[i] - origin) / unit, c = (surface.position()[j] - origin) / unit,
                           d = (surface.position()[k] - origin) / unit;
                const double sum = value.empty() ? 0 : static_cast<double>(value[i]) + value[j] + value[k];
                whole.add(a, c, d, sum, 1);
                const Vec3 normal = cross(c - a, d - a).normalized();
                std::array<double, kCorners> share;
                double all = 0;
                for (std::size_t m = 0; m < kCorners; ++m) {
                    const double s = 1 + dot(normal, corner[m]) * 0.577, s2 = s * s, s4 = s2 * s2;
                    all += share[m] = s4 * s4;
                }
                for (std::size_t m = 0; m < kCorners; ++m) towards[m].add(a, c, d, sum, share[m] / all);
            }
            if (!(whole.area > 0)) continue;
            const double agreement = whole.direction.length() / whole.area;
            const double apart = 1 - smoothStep((agreement - 0.75) / 0.15).value;
            const auto add = [&](const Moments& m, double share) {
                if (!(m.area * share > 1e-9)) return;
                parts[task].push_back(m.piece(origin, unit));
                parts[task].back().area *= static_cast<float>(share);
            };
            add(whole, 1 - apart);
            for (const Moments& m : towards) add(m, apart);
        }
    });
    return joined(parts);
}

// Σ A u / (d² + spread)², u from 0 to 1 where a piece faces sideways, neither the point's way nor opposite: of a wall
// across the surface at distance D that is π / 2 D².
struct SumSideways {
    PieceSamples samples;
    float same, opposite;  // cosines from which it is neither
    float inverse_square_reach;
    Point point;
    Lanes (&sums)[1];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3], n[3];
        getLanes<kWidth>(point.place, first, x);
        getLanes<kWidth>(point.normal, first, n);
        const Some zero{}, one = zero + 1.0F;
        Some sum[1] = {};
        for (const auto& f : samples) {
            const Some px = f[pX] - x[0], py = f[pY] - x[1], pz = f[pZ] - x[2];
            const Some square = px * px + py * py + pz * pz + f[pSpread] + 0.02F;
            const Some t = f[pDx] * n[0] + f[pDy] * n[1] + f[pDz] * n[2];
            Some u = (same + 0.25F - t) * 4.0F, v = (t - opposite + 0.25F) * 4.0F;
            u = u < v ? u : v;
            u = u < one ? u : one;
            u = u > 0 ? u : zero;
            Some t2 = one - square * inverse_square_reach;
            t2 = t2 > 0 ? t2 : zero;
            sum[0] += f[pArea] * u * t2 * t2 / (square * square);
        }
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
        for (const auto& f : samples) {
            const Some px = f[pX] - x[0], py = f[pY] - x[1], pz = f[pZ] - x[2];
            const Some square = px * px + py * py + pz * pz + f[pSpread];
            Some t = one - square * inverse;
            Some c = f[pDx] * n[0] + f[pDy] * n[1] + f[pDz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some k = t * t * c * c * f[pArea];
            sum[0] += k;
            sum[1] += k * px;
            sum[2] += k * py;
            sum[3] += k * pz;
            sum[4] += k * f[pDx];
            sum[5] += k * f[pDy];
            sum[6] += k * f[pDz];
            sum[7] += k * (px * f[pDx] + py * f[pDy] + pz * f[pDz] + f[pBulge]);
            sum[8] += k * square;
        }
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
        for (const auto& f : samples) {
            const Some px = f[pX] - x[0], py = f[pY] - x[1], pz = f[pZ] - x[2];
            Some t = one - (px * px + py * py + pz * pz + f[pSpread]) * inverse;
            Some c = f[pDx] * n[0] + f[pDy] * n[1] + f[pDz] * n[2];
            t = t > 0 ? t : zero;
            c = c > 0 ? c : zero;
            const Some k = t * t * c * c * f[pArea];
            sum[0] += k * f[pValue];
            sum[1] += k;
        }
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
    const double quadratic = (c - dot(a, b)) / (2 * (e - dot(a, a) + 1e-3));
    const Vec3 linear = b - a * (2 * quadratic);
    const double constant = -(dot(linear, a) + quadratic * e), slope = dot(linear, linear);
    if (!(slope > 1e-9)) return Vec3(0);
    const double root = std::sqrt(std::max(0.0, slope * slope - 4 * quadratic * constant * slope));
    return linear * (-2 * constant / (slope + root));
}

// Calls visit(group, pieces within reach, normals of the group's lanes).
template <typename Visit>
void forVertices(MovedSurface& surface, const std::vector<Piece>& pieces, double reach, const Normals& normal,
                 const Visit& visit) {
    const double unit = surface.unit();
    std::vector<Vec3> at(pieces.size());
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = pieces[i].position;
    const CellOrder order(at.size(), reach / 3 * unit, [&](std::size_t i) -> const Vec3& { return at[i]; });
    const PointGroups& groups = surface.vicinity(0.8).groups;
    const Rows near = surface.near(order, at, reach);
    forGroups<pFields>(
        groups, surface.position(), near, at, unit,
        [&](std::uint32_t i, SampleFields<pFields>& f) {
            const Piece& p = pieces[i];
            f[pDx] = p.direction.x, f[pDy] = p.direction.y, f[pDz] = p.direction.z;
            f[pArea] = p.area, f[pSpread] = p.spread, f[pBulge] = p.bulge, f[pValue] = p.value;
        },
        [&](const GroupLanes& group, PieceSamples samples) {
            Lanes n[3];
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (int k = 0; k < 3; ++k) n[k][lane] = normal[group.row[lane]][k];
            visit(group, samples, Point{group.place, n});
        });
}

// How wide each vertex may be smoothed: as far as the surface does not turn sideways.
std::vector<float> widthsOf(MovedSurface& surface, const Normals& soft, double least, double largest) {
    const std::vector<Piece> pieces = piecesOf(surface, {});
    std::vector<float> result(surface.size());
    forVertices(surface, pieces, largest, soft, [&](const GroupLanes& group, PieceSamples near, const Point& point) {
        Lanes sums[1];
        forLanes(SumSideways{near, static_cast<float>(tune("cut", 0.5)), static_cast<float>(tune("low", -0.3)), static_cast<float>(1 / (largest * largest)), point, sums});
        for (std::size_t lane = 0; lane < group.size; ++lane) {
            const double inverse_square = 1 / (largest * largest) + tune("wc", 2 / 3.14159265) * static_cast<double>(sums[0][lane]);
            result[group.row[lane]] = static_cast<float>(std::max(least, 1 / std::sqrt(inverse_square)));
        }
    });
    surface.hold(result);
    return result;
}

}  // namespace

std::vector<float> wantedLengths(MovedSurface& surface) {
    std::vector<float> length(surface.size());
    const double longest = tune("long", 1), shortest = tune("short", 0.4), flat = tune("flat", 0.03),
                 curved = tune("curved", 0.1);
    sumUp<4, SumNormals>(surface, surface.normals(), {}, 0.8, [&](std::uint32_t v, const auto& sums, std::size_t lane) {
        const Vec3f sum(sums[0][lane], sums[1][lane], sums[2][lane]);
        const double bent = sums[3][lane] > 0 ? 1 - sum.length() / sums[3][lane] : 1;
        length[v] = static_cast<float>(longest + (shortest - longest) * smoothStep((bent - flat) / (curved - flat)).value - tune("rim", 0.12) * smoothStep((bent - curved) / tune("rim1", 0.1)).value);
    });
    return length;
}

void smoothSkin(MovedSurface& surface, double widest, int passes) {
    (void)widest;
    (void)passes;
    const double unit = surface.unit();
    std::vector<Vec3> begin(surface.size());
    parallelFor(begin.size(), 8192, [&](std::size_t v) { begin[v] = surface.position()[v]; });
    const int narrow = static_cast<int>(tune("narrow", 0));
    for (int i = 0; i < narrow; ++i) smoothNarrowly(surface, tune("nw", 0.8));
    const double largest = tune("wide", 5.8), least = 0.8;
    std::vector<float> width;
    for (int pass = 0; pass < tune("wides", 1); ++pass) {
        const Normals normal = softNormals(surface, surface.normals(), tune("nsmooth", 0.5));
        width = widthsOf(surface, softNormals(surface, normal, 1.2), least, largest);
        const std::vector<Piece> pieces = piecesOf(surface, {});
        std::vector<Vec3f> step(surface.size());
        forVertices(surface, pieces, largest, normal, [&](const GroupLanes& group, PieceSamples near, const Point& point) {
            Lanes inverse, sums[9];
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const float w = width[group.row[lane]];
                inverse[lane] = 1 / (w * w);
            }
            forLanes(SumFit{near, inverse, point, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                Vec3 s = stepOntoSphere(sums, lane);
                const double length = s.length();
                if (length > 0.3) s *= 0.3 / length;
                s *= smoothStep((width[group.row[lane]] - tune("fit0", 1)) / tune("fit1", 1)).value;
                step[group.row[lane]] = Vec3f(s);
            }
        });
        moveBy(surface, step, width);
    }
    const int post = static_cast<int>(tune("post", 4));
    for (int i = 0; i < post; ++i) smoothNarrowly(surface, tune("nw", 0.8));
    for (int twice = 0; twice < tune("backs", 3); ++twice)
    if (const double back = tune("back", 5.4); back > 0 && !width.empty()) {
        const Normals normal = softNormals(surface, surface.normals(), tune("nsmooth", 0.5));
        std::vector<float> lost(surface.size());
        parallelFor(lost.size(), 8192, [&](std::size_t v) {
            lost[v] = static_cast<float>(dot(begin[v] - surface.position()[v], Vec3(normal[v])) / unit);
        });
        const std::vector<Piece> pieces = piecesOf(surface, lost);
        std::vector<float> height(surface.size());
        forVertices(surface, pieces, back, normal, [&](const GroupLanes& group, PieceSamples near, const Point& point) {
            Lanes inverse, sums[2];
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const float w = std::min(width[group.row[lane]], static_cast<float>(back));
                inverse[lane] = 1 / (w * w);
            }
            forLanes(SumValues{near, inverse, point, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                height[group.row[lane]] = sums[1][lane] > 0 ? static_cast<float>(sums[0][lane] / sums[1][lane] * smoothStep((width[group.row[lane]] - tune("fit0", 1)) / tune("fit1", 1)).value) : 0;
        });
        moveAlong(surface, normal, height);
    }
    for (int i = 0; i < tune("unfold", 3); ++i) surface.unfold();
}

}  // namespace betamesh
