#include "skin/surface_attributes.h"

#include "base/parallel.h"
#include "betamesh/error.h"
#include "mesh/mesh_edges.h"
#include "skin/constants.h"
#include "skin/deforming_mesh.h"
#include "skin/surface_elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace betamesh {

namespace {

// Lengths are in particle spacings of the frame, but for widths and limits, which are in those at the vertex.
enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kFields };
using Samples = SampleRuns<kFields>;

// The sums of a linear fit of normals n to offsets y: Σk, Σk y, Σk n, Σk y yᵀ, Σk n yᵀ (row by row) with
// k = area · (1 - d²/width²)²₊ · (n · own normal)²₊.
enum FitSum {
    kWeights,
    kOffset,
    kNormal = kOffset + 3,
    kSquares = kNormal + 3,
    kProducts = kSquares + 6,
    kFitSums = kProducts + 9
};
struct FitSums {
    Samples samples;
    const Lanes& inverse_square_width;
    OrientedPoints point;
    Lanes (&sums)[kFitSums];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        Pack sum[kFitSums] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t, c;
                setFacing(p, n, &f[kNx], inverse, t, c);
                const Pack k = t * t * c * c * f[kArea];
                const Pack q[3] = {k * p[0], k * p[1], k * p[2]};
                sum[kWeights] += k;
                for (std::size_t i = 0; i < 3; ++i) {
                    sum[kOffset + i] += q[i];
                    sum[kNormal + i] += k * f[kNx + i];
                    for (std::size_t j = 0; j < 3; ++j) sum[kProducts + 3 * i + j] += q[j] * f[kNx + i];
                }
                sum[kSquares] += q[0] * p[0];
                sum[kSquares + 1] += q[0] * p[1];
                sum[kSquares + 2] += q[0] * p[2];
                sum[kSquares + 3] += q[1] * p[1];
                sum[kSquares + 4] += q[1] * p[2];
                sum[kSquares + 5] += q[2] * p[2];
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// The normal at a point and the rates at which it turns along the surface.
struct FittedNormal {
    Vec3 normal;
    double mean_curvature, smaller_curvature, larger_curvature;
};

// The fitted normal at offset 0; nothing if the sums are too small. Offsets and changes of the normal are restricted to
// the plane across the mean normal. scale: particle spacing there, in spacings of the frame.
std::optional<FittedNormal> fittedNormal(const Lanes (&sums)[kFitSums], std::size_t lane, double scale) {
    const double weight = sums[kWeights][lane];
    if (!(weight > 0)) return std::nullopt;
    const auto mean = [&](int sum) { return static_cast<double>(sums[sum][lane]) / weight; };
    const auto meanVector = [&](int sum) { return Vec3(mean(sum), mean(sum + 1), mean(sum + 2)); };
    const Vec3 offset = meanVector(kOffset), normal = meanVector(kNormal);
    const double length = normal.length();
    if (!(length > kMinMeanNormal)) return std::nullopt;
    const Vec3 up = normal / length;
    const Vec3 side = std::abs(up.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const std::array<Vec3, 2> along{cross(up, side).normalized(), cross(up, cross(up, side)).normalized()};
    const double xx = mean(kSquares), xy = mean(kSquares + 1), xz = mean(kSquares + 2), yy = mean(kSquares + 3),
                 yz = mean(kSquares + 4), zz = mean(kSquares + 5);
    const auto times = [&](const Vec3& v) {
        return Vec3(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z);
    };
    double square[2][2], product[2][2];  // covariances of offsets, and of normals with offsets
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t j = 0; j < 2; ++j) {
            square[i][j] = dot(along[i], times(along[j])) - dot(along[i], offset) * dot(along[j], offset);
            const Vec3 of_normal(dot(meanVector(kProducts), along[j]), dot(meanVector(kProducts + 3), along[j]),
                                 dot(meanVector(kProducts + 6), along[j]));
            product[i][j] = dot(along[i], of_normal) - dot(along[i], normal) * dot(along[j], offset);
        }
    for (std::size_t i = 0; i < 2; ++i) square[i][i] += kSkinFitVariance * (scale * scale);
    const double determinant = square[0][0] * square[1][1] - square[0][1] * square[1][0];
    double turn[2][2];  // of the normal, per length
    for (std::size_t i = 0; i < 2; ++i) {
        turn[i][0] = (product[i][0] * square[1][1] - product[i][1] * square[1][0]) / determinant;
        turn[i][1] = (product[i][1] * square[0][0] - product[i][0] * square[0][1]) / determinant;
    }
    Vec3 at_point = normal;
    for (std::size_t i = 0; i < 2; ++i)
        at_point -= along[i] * (turn[i][0] * dot(along[0], offset) + turn[i][1] * dot(along[1], offset));
    const double half = (turn[0][0] + turn[1][1]) / 2, difference = (turn[0][0] - turn[1][1]) / 2,
                 twist = (turn[0][1] + turn[1][0]) / 2;
    const double spread = std::sqrt(difference * difference + twist * twist);
    return FittedNormal{at_point.normalized(), half, half - spread, half + spread};
}

// Σ A u v (1 - d²/reach²)² / d⁴ over the opposite side of the liquid: u fades in with the elevation of the other vertex
// below the tangent plane, v with how far it faces the opposite way. d² is raised by the spread of the area A of the
// vertex, so the sum stays finite where the sides nearly touch.
struct OppositeSum {
    Samples samples;
    const Lanes &inverse_square_reach, &min_square;  // min_square: of vertices without area
    OrientedPoints point;
    Lanes (&sums)[1];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse, least;
        getLanes<kWidth>(point.position, first, x);
        getLanes<kWidth>(point.normal, first, n);
        getLanes<kWidth>(inverse_square_reach, first, inverse);
        getLanes<kWidth>(min_square, first, least);
        const Pack zero{}, one = zero + 1.0F;
        constexpr float kSpread = 0.15915494F;  // 1 / 2π: mean squared radius of a disc over its area
        constexpr float kInverseElevation = 1 / (kOppositeElevation * kOppositeElevation);
        Pack sum[1] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                const Pack square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + f[kArea] * kSpread + least;
                Pack below = -(p[0] * n[0] + p[1] * n[1] + p[2] * n[2]);
                Pack v = (kOppositeFade - (f[kNx] * n[0] + f[kNy] * n[1] + f[kNz] * n[2])) / (2 * kOppositeFade);
                Pack within = one - square * inverse;
                below = below > 0 ? below : zero;
                v = v > 0 ? v : zero;
                v = v < one ? v : one;
                within = within > 0 ? within : zero;
                Pack u = below * below * kInverseElevation / square;
                u = u < one ? u : one;
                sum[0] += f[kArea] * u * v * within * within / (square * square);
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// (reach / thickness)² of a plane sheet whose opposite side has the sum π / reach² · s, s > 0: v - 1/v - 2 ln v = s.
double inverseSquareThickness(double s) {
    double v = s + 3 + 2 * std::log(s + 3);  // right of the solution, where Newton's method descends to it
    for (int i = 0; i < 16; ++i) {
        const double slope = (1 - 1 / v) * (1 - 1 / v);
        v -= (v - 1 / v - 2 * std::log(v) - s) / slope;
    }
    return v;
}

struct Shape {
    double drop, thread, sheet;  // the rest is bulk
};
// scale: particle spacing there, in spacings of the frame.
Shape shapeOf(double thickness, double smaller_curvature, double larger_curvature, double scale) {
    const auto rounded = [&](double curvature) {
        return smoothStep((thickness * curvature - kRoundBegins) / (kRoundFull - kRoundBegins)).value;
    };
    const double thin = 1 - smoothStep((thickness / scale - kBulkBegins) / (kBulkFull - kBulkBegins)).value;
    const double drop = rounded(smaller_curvature), not_sheet = rounded(larger_curvature);
    return {thin * drop, thin * (not_sheet - drop), thin * (1 - not_sheet)};
}

class Measurement {
public:
    Measurement(BetaMesh& mesh, double spacing, std::vector<std::uint32_t>& former_row)
        : surface_(mesh, spacing, former_row) {}

    std::vector<Vec3f> normal;
    std::vector<Vec3f> curvature;  // mean, smaller, larger; per particle spacing of the frame
    std::vector<float> thickness;  // particle spacings of the frame
    std::vector<Vec3f> shape;      // weights of drop, thread, sheet

    void fit() {
        const Normals facing = surface_.kernelNormals(kNormalKernel, facingNormals()).normal;
        normal = facing;
        curvature.assign(surface_.size(), Vec3f(0));
        visitSamples(kAttributeFit, facing, [&](const PointGroup& group, Samples samples, const OrientedPoints& point) {
            Lanes inverse, sums[kFitSums];
            surface_.setInverseSquares(group, kAttributeFit, inverse);
            forLanes(FitSums{samples, inverse, point, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const auto fitted = fittedNormal(sums, lane, scaleOf(group.row[lane]));
                if (!fitted) continue;
                normal[group.row[lane]] = Vec3f(fitted->normal);
                curvature[group.row[lane]] =
                    Vec3f(Vec3(fitted->mean_curvature, fitted->smaller_curvature, fitted->larger_curvature));
            }
        });
    }
    void measureThickness() {
        thickness.assign(surface_.size(), 0);
        const double reach = kMaxThickness * std::sqrt(inverseSquareThickness(kThicknessSmoothing));
        visitSamples(reach, normal, [&](const PointGroup& group, Samples samples, const OrientedPoints& point) {
            Lanes inverse, least, sums[1];
            surface_.setInverseSquares(group, reach, inverse);
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const float scale = surface_.scale(group.row[lane]);
                least[lane] = kMinSquare * (scale * scale);
            }
            forLanes(OppositeSum{samples, inverse, least, point, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const double own_reach = reach * scaleOf(group.row[lane]),
                             factor = own_reach * own_reach / std::numbers::pi * stepOf(samples);
                const double sum = factor * static_cast<double>(sums[0][lane]) + kThicknessSmoothing;
                thickness[group.row[lane]] = static_cast<float>(own_reach / std::sqrt(inverseSquareThickness(sum)));
            }
        });
    }
    void tellShapes() {
        shape.resize(surface_.size());
        parallelFor(shape.size(), 8192, [&](std::size_t v) {
            const Vec3 of_normal(curvature[v]);
            const Shape of_vertex = shapeOf(static_cast<double>(thickness[v]), of_normal.y, of_normal.z, scaleOf(v));
            shape[v] = Vec3f(Vec3(of_vertex.drop, of_vertex.thread, of_vertex.sheet));
        });
    }
    void constrainFading() {
        surface_.constrainFading(normal);
        surface_.constrainFading(curvature);
        if (!thickness.empty()) surface_.constrainFading(thickness);
        if (!shape.empty()) surface_.constrainFading(shape);
    }

private:
    // Mean normals, whatever those near are, as a sliver's own may be arbitrary; where they cancel, as round a pinhole,
    // the vertex' own.
    Normals facingNormals() const {
        Normals mean = surface_.kernelMeans(kMeanNormalKernel, surface_.normals());
        parallelFor(mean.size(), 8192, [&](std::size_t v) {
            const double agreement = smoothStep((mean[v].length() - kCancelling) / kCancellingFade).value;
            mean[v] += surface_.normals()[v] * static_cast<float>(1 - agreement);
            mean[v].normalize();
        });
        return mean;
    }

    static constexpr std::size_t kMaxSamples = 16384;
    static constexpr float kMinSquare = 1e-6F;

    double scaleOf(std::size_t v) const { return static_cast<double>(surface_.scale(v)); }
    // By how much a sum over samples must be multiplied because only every so many of them were visited. With one size
    // of particles that happens nowhere but where surfaces are degenerate.
    double stepOf(const Samples& samples) const {
        return surface_.mesh().scale.empty() ? 1 : static_cast<double>(samples.step());
    }
    template <typename Visit>
    void visitSamples(double reach, const Normals& point_normal, const Visit& visit) const {
        const SampleTable<kFields> table(surface_.groups(), surface_.position(), surface_.spacing(),
                                         [&](std::uint32_t v, SampleFields<kFields>& f) {
                                             const Vec3f& n = surface_.normals()[v];
                                             f[kArea] = surface_.area(v), f[kNx] = n.x, f[kNy] = n.y, f[kNz] = n.z;
                                         });
        forGroups(
            surface_.groups(), surface_.position(), table, kMaxSamples,
            [&](std::size_t group) { return surface_.reach(reach, group); },
            [&](const PointGroup& group, Samples samples) {
                const PointGroup::Vectors n = group.gather(point_normal);
                visit(group, samples, OrientedPoints{group.position, n.lanes});
            });
    }

    DeformingMesh surface_;
};

}  // namespace

std::vector<Attribute> emptyColumns(const SurfaceAttributes& wanted) {
    std::vector<Attribute> columns;
    const auto add = [&](const char* name, std::uint32_t components) { columns.push_back({name, components, {}, {}}); };
    if (wanted.normals) add("N", 3);
    if (wanted.thickness) add("thickness", 1);
    if (wanted.curvature) add("curvature", 1);
    if (wanted.shape)
        for (const char* name : {"drop", "thread", "sheet", "bulk"}) add(name, 1);
    return columns;
}

void requireDistinctNames(const SkinParams& params) {
    for (const Attribute& column : emptyColumns(params.surface_attributes))
        if (std::find(params.attributes.begin(), params.attributes.end(), column.name) != params.attributes.end())
            throw Error("'" + column.name +
                        "' is an attribute of the particles to be interpolated and one to be measured on the surface. "
                        "Leave out one of them");
}

std::vector<Attribute> surfaceAttributes(BetaMesh mesh, double spacing, const SurfaceAttributes& wanted) {
    std::vector<Attribute> columns = emptyColumns(wanted);
    if (columns.empty() || mesh.triangles.empty()) return columns;
    const std::vector<std::uint32_t> used = verticesOf(mesh.triangles, mesh.vertex.size());
    std::vector<std::uint32_t> former_row;
    Measurement measured(mesh, spacing, former_row);
    measured.fit();
    if (wanted.thickness || wanted.shape) measured.measureThickness();
    if (wanted.shape) measured.tellShapes();
    measured.constrainFading();

    std::vector<std::uint32_t> row(former_row.size());
    parallelFor(row.size(), 8192, [&](std::size_t v) { row[former_row[v]] = static_cast<std::uint32_t>(v); });
    for (Attribute& column : columns) column.real.resize(used.size() * column.components);
    parallelFor(used.size(), 4096, [&](std::size_t i) {
        const std::uint32_t v = row[used[i]];
        auto column = columns.begin();
        const auto set = [&](double value) { (column++)->real[i] = static_cast<float>(value); };
        if (wanted.normals) {
            const Vec3 blended(measured.normal[v]);
            const double length = blended.length();
            const Vec3 n = length > 0 ? blended / length : Vec3(0, 0, 1);  // a vertex of triangles without area
            for (int k = 0; k < 3; ++k) column->real[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(n[k]);
            ++column;
        }
        if (wanted.thickness) set(static_cast<double>(measured.thickness[v]) * spacing);
        if (wanted.curvature) set(static_cast<double>(measured.curvature[v].x) / spacing);
        if (!wanted.shape) return;
        const Vec3 shape(measured.shape[v]);
        for (int k = 0; k < 3; ++k) set(shape[k]);
        set(std::max(0.0, 1 - shape.x - shape.y - shape.z));
    });
    return columns;
}

}  // namespace betamesh
