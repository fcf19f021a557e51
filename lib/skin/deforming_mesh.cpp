
#include "skin/deforming_mesh.h"

#include "base/chosen_rows.h"
#include "base/parallel.h"
#include "skin/constants.h"

#include <algorithm>
#include <utility>

namespace betamesh {

namespace {

constexpr double kGroupCell = 4;  // edge of the cells in which vertices are grouped, particle spacings

enum Field { kX, kY, kZ, kArea, kNx, kNy, kNz, kFields };

// Σ w n and Σ w, w = area · (1 - d²/width²)²₊ · (n · own normal)²₊.
struct NormalSums {
    SampleRuns<kFields> samples;
    const Lanes& inverse_square_width;
    const Lanes (&point)[3], (&normal)[3];
    Lanes (&sums)[4];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], n[3], inverse;
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(normal, first, n);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        Pack sum[4] = {};
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t, c;
                setFacing(p, n, &f[kNx], inverse, t, c);
                const Pack w = t * t * c * c * f[kArea];
                sum[0] += w * f[kNx];
                sum[1] += w * f[kNy];
                sum[2] += w * f[kNz];
                sum[3] += w;
            });
        setLanes<kWidth>(sums, first, sum);
    }
};

// Σ w value / Σ w.
enum ValueField { kVx = 3, kVy, kVz, kWeight, kValueFields };
struct ValueMeans {
    SampleRuns<kValueFields> samples;
    const Lanes& inverse_square_width;
    const Lanes (&point)[3];
    Lanes (&mean)[3];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Pack = Floats<kWidth>;
        Pack x[3], inverse;
        getLanes<kWidth>(point, first, x);
        getLanes<kWidth>(inverse_square_width, first, inverse);
        const Pack zero{}, one = zero + 1.0F;
        Pack sum[3] = {}, weight = zero + 1e-12F;
        samples.forEach(
            x, [&](const auto& f, const Pack(&p)[3]) __attribute__((always_inline)) {
                Pack t = one - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) * inverse;
                t = t > 0 ? t : zero;
                const Pack w = t * t * f[kWeight];
                weight += w;
                sum[0] += w * f[kVx];
                sum[1] += w * f[kVy];
                sum[2] += w * f[kVz];
            });
        for (Pack& along : sum) along = along / weight;
        setLanes<kWidth>(mean, first, sum);
    }
};

}  // namespace

DeformingMesh::DeformingMesh(BetaMesh& mesh, double spacing)
    : mesh_(mesh), spacing_(spacing), position_(mesh.vertex.size()) {
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] = mesh_.vertex[v].position; });
    weighDiagonals(fadeWeights());
    arrange();
}

DeformingMesh::DeformingMesh(BetaMesh& finished, double spacing, std::vector<std::uint32_t>& former_row)
    : mesh_(finished), spacing_(spacing), position_(finished.vertex.size()) {
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] = mesh_.vertex[v].position; });
    former_row = arrange();
}

void DeformingMesh::listConstraints() {
    std::vector<std::uint8_t> in_group(size(), 0), is_support(size(), 0);
    constraint_of_.assign(size(), nullptr);
    for (std::size_t g = 0; g < constraints_.size(); ++g) {
        const std::vector<FadingVertex>& group = mesh_.fading[g];
        ConstraintGroup& constraints = constraints_[g] = {};
        std::vector<Constraint>& all = constraints.all;
        all.resize(group.size());
        parallelFor(group.size(), 4096, [&](std::size_t i) {
            const FadingVertex& fading = group[i];
            all[i] = {fading.vertex,
                      static_cast<std::uint32_t>(i),
                      fading.support,
                      {},
                      static_cast<float>(fading.fade.value),
                      static_cast<std::uint32_t>(g)};
            constraint_of_[fading.vertex] = &all[i];
            for (std::size_t k = 0; k < 4; ++k) all[i].weight[k] = static_cast<float>(fading.support_weight[k].value);
        });
        for (const Constraint& v : all) in_group[v.vertex] = 1;
        const auto isDependent = [&](const Constraint& v) {
            return std::any_of(v.support.begin(), v.support.end(), [&](std::uint32_t u) { return in_group[u] != 0; });
        };
        std::copy_if(all.begin(), all.end(), std::back_inserter(constraints.dependent), isDependent);
        for (const Constraint& v : constraints.dependent)
            for (const std::uint32_t u : v.support) is_support[u] = in_group[u];
        std::copy_if(all.begin(), all.end(), std::back_inserter(constraints.supporting),
                     [&](const Constraint& v) { return is_support[v.vertex] != 0; });
        for (const Constraint& v : all) in_group[v.vertex] = is_support[v.vertex] = 0;
    }
}

// Sorts the vertices into groups. Those with fade weight 0 come last and are in no group: they only follow the vertices
// they fade in from. Returns the former row of each vertex.
std::vector<std::uint32_t> DeformingMesh::arrange() {
    const std::vector<float> fade = fadeWeights();
    const auto rows = static_cast<std::uint32_t>(size());
    const std::vector<std::uint32_t> present = indicesWhere(rows, [&](std::uint32_t v) { return fade[v] > 0; });
    std::vector<std::uint32_t> order;
    groups_ =
        PointGroups(chosenRows(position_, present), kGroupCell * spacing_, chosenRows(mesh_.scale, present), order);
    order = chosenRows(present, order);
    order.reserve(rows);
    for (std::uint32_t v = 0; v < rows; ++v)
        if (!(fade[v] > 0)) order.push_back(v);
    reorderVertices(mesh_, order);
    position_ = chosenRows(position_, order);
    groups_.fitBoxes(position_);
    listConnections();
    return order;
}

void DeformingMesh::listConnections() {
    const auto forCorners = [&](std::size_t t, const auto& visit) {
        for (const std::uint32_t v : mesh_.triangles[t]) visit(v, static_cast<std::uint32_t>(t));
    };
    triangles_of_ = sortedIntoRows<std::uint32_t>(size(), mesh_.triangles.size(), forCorners);
    listConstraints();
    measure();
}

float DeformingMesh::largestScale(std::size_t group) const {
    if (mesh_.scale.empty()) return 1;
    return *std::max_element(mesh_.scale.begin() + groups_.begin(group),
                             mesh_.scale.begin() + groups_.begin(group + 1));
}

void DeformingMesh::setInverseSquares(const PointGroup& group, double width, Lanes& inverse) const {
    inverse = Lanes{} + static_cast<float>(1 / (width * width));
    if (mesh_.scale.empty()) return;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float s = mesh_.scale[group.row[lane]];
        inverse[lane] /= s * s;
    }
}

void DeformingMesh::measure() {
    const std::size_t n = size(), triangles = mesh_.triangles.size();
    third_.resize(triangles);
    const double sixth = 1 / (6 * spacing_ * spacing_);
    parallelFor(triangles, 4096, [&](std::size_t t) {
        const auto& [a, b, c] = mesh_.triangles[t];
        const Vec3 ab = position_[b] - position_[a], ac = position_[c] - position_[a];
        const Vec3f third(cross(ab, ac) * sixth);
        const double shortest = std::min({ab.length2(), ac.length2(), (ac - ab).length2()});
        const double limit = static_cast<double>(kFoldCluster * std::max({scale(a), scale(b), scale(c)})) * spacing_;
        third_[t] = {third, third.length(), shortest < limit * limit};
    });
    area_.resize(n);
    has_short_edges_.resize(n);
    std::vector<Vec3f> sum(n);
    parallelFor(n, 2048, [&](std::size_t v) {
        TriangleThird all{};
        for (const std::uint32_t t : triangles_of_[v]) {
            all.vector_area += third_[t].vector_area;
            all.area += third_[t].area;
            all.has_short_edge |= third_[t].has_short_edge;
        }
        area_[v] = all.area;
        has_short_edges_[v] = all.has_short_edge;
        sum[v] = all.vector_area;
    });
    passOnAreas(sum);
    // A vertex without an area of its own has the mean normal of its one-ring.
    normal_.resize(n);
    flatness_.resize(n);
    parallelFor(n, 4096, [&](std::size_t v) {
        Vec3f normal = sum[v];
        flatness_[v] = area_[v] > 0 ? normal.length() / area_[v] : 1;
        if (!(area_[v] > 0)) {
            normal = Vec3f(0);
            for (const std::uint32_t t : triangles_of_[v]) normal += third_[t].vector_area;
        }
        normal_[v] = normal.normalized();
        area_[v] = std::max(area_[v], 0.0F);
    });
}

// Vertices that fade in pass on the share 1 - fade of their areas and vector areas. Later groups fade in from earlier
// ones; those on facets from each other.
void DeformingMesh::passOnAreas(std::vector<Vec3f>& sum) {
    std::vector<std::pair<float, Vec3f>> kept, passed;
    for (auto group = constraints_.rbegin(); group != constraints_.rend(); ++group) {
        kept.assign(group->all.size(), {0.0F, Vec3f(0)});  // later rounds pass on only what has arrived since
        passed.resize(group->all.size());
        for (int round = 0; round < group->rounds(); ++round) {
            const std::vector<Constraint>& some = round == 0 ? group->all : group->supporting;
            for (std::size_t i = 0; i < some.size(); ++i) {
                const Constraint& v = some[i];
                auto& [area, vector_sum] = kept[v.row];
                passed[i] = {(area_[v.vertex] - area) * (1 - v.fade), (sum[v.vertex] - vector_sum) * (1 - v.fade)};
                area = area_[v.vertex] -= passed[i].first;
                vector_sum = sum[v.vertex] -= passed[i].second;
            }
            for (std::size_t i = 0; i < some.size(); ++i)
                for (std::size_t k = 0; k < 4; ++k) {
                    area_[some[i].support[k]] += passed[i].first * some[i].weight[k];
                    sum[some[i].support[k]] += passed[i].second * some[i].weight[k];
                }
        }
    }
}

void DeformingMesh::move(std::vector<Vec3f>& step) {
    constrainFading(step);
    parallelFor(size(), 8192, [&](std::size_t v) { position_[v] += Vec3(step[v]) * spacing_; });
    groups_.fitBoxes(position_);
}

void DeformingMesh::moveAveraged(std::vector<Vec3f>& step, const std::vector<float>& own) {
    const std::vector<Vec3f> mean = kernelMeans(kStepKernel, step);
    parallelFor(step.size(), 8192, [&](std::size_t v) {
        const float share = own.empty() ? 0 : own[v];
        step[v] = step[v] * share + mean[v] * (1 - share);
    });
    move(step);
}

// The groups of vertices with values other than 0 within reach.
std::vector<std::uint8_t> DeformingMesh::groupsNear(double width, const std::vector<Vec3f>& values) const {
    std::vector<std::uint8_t> is_near(groups_.size(), 0);
    for (std::uint32_t group = 0; group < groups_.size(); ++group) {
        const auto begin = values.begin() + groups_.begin(group), end = values.begin() + groups_.begin(group + 1);
        if (std::all_of(begin, end, [](const Vec3f& value) { return value == Vec3f(0); })) continue;
        groups_.forGroupsNear(
            groups_.box(group), [&](double largest_scale) { return width * spacing_ * largest_scale; },
            [&](std::uint32_t near, std::uint32_t) { is_near[near] = 1; });
    }
    return is_near;
}

// reachOf: world units; groups for which it is negative get 0
template <typename ReachOf>
std::vector<Vec3f> DeformingMesh::kernelMeansWithin(double width, const std::vector<Vec3f>& values,
                                                    const ReachOf& reachOf) const {
    constexpr float kMinArea = 1e-9F;  // equal weights where no vertex has an area
    std::vector<Vec3f> means(values.size(), Vec3f(0));
    forNeighbourhoods<kValueFields>(
        reachOf,
        [&](std::uint32_t v, SampleFields<kValueFields>& f) {
            const Vec3f& value = values[v];
            f[kVx] = value.x, f[kVy] = value.y, f[kVz] = value.z, f[kWeight] = area_[v] + kMinArea;
        },
        [&](const PointGroup& group, SampleRuns<kValueFields> samples) {
            Lanes inverse, mean[3];
            setInverseSquares(group, width, inverse);
            forLanes(ValueMeans{samples, inverse, group.position, mean});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                means[group.row[lane]] = Vec3f(mean[0][lane], mean[1][lane], mean[2][lane]);
        });
    return means;
}

std::vector<Vec3f> DeformingMesh::kernelMeans(double width, const std::vector<Vec3f>& values) const {
    return kernelMeansWithin(width, values, [&](std::size_t group) { return reach(width, group); });
}

std::vector<Vec3f> DeformingMesh::kernelMeansOfFew(double width, const std::vector<Vec3f>& values) const {
    const std::vector<std::uint8_t> is_near = groupsNear(width, values);
    return kernelMeansWithin(width, values,
                             [&](std::size_t group) { return is_near[group] != 0 ? reach(width, group) : -1; });
}

void DeformingMesh::smoothScales() {
    if (mesh_.scale.empty()) return;
    for (int round = 0; round < kScaleMeans; ++round) {
        std::vector<Vec3f> value(size());
        parallelFor(size(), 8192, [&](std::size_t v) { value[v] = Vec3f(mesh_.scale[v], 0, 0); });
        const std::vector<Vec3f> mean = kernelMeans(kScaleKernel, value);
        parallelFor(size(), 8192, [&](std::size_t v) {
            if (mean[v].x > 0) mesh_.scale[v] = mean[v].x;  // a vertex in no group follows others
        });
        constrainFading(mesh_.scale);
    }
}

std::vector<Vec3f> DeformingMesh::meanNormals() const {
    std::vector<Vec3f> normal = kernelMeans(kMeanNormalKernel, normal_);
    parallelFor(size(), 8192, [&](std::size_t v) { normal[v].normalize(); });
    return normal;
}

std::vector<Vec3f> DeformingMesh::smoothNormals() const { return kernelNormals(kNormalKernel, meanNormals()).normal; }

DeformingMesh::KernelNormals DeformingMesh::kernelNormals(double width, const std::vector<Vec3f>& normals) const {
    KernelNormals means{std::vector<Vec3f>(size(), Vec3f(0)), std::vector<float>(size())};
    forNeighbourhoods<kFields>(
        width,
        [&](std::uint32_t v, SampleFields<kFields>& f) {
            f[kArea] = area_[v], f[kNx] = normals[v].x, f[kNy] = normals[v].y, f[kNz] = normals[v].z;
        },
        [&](const PointGroup& group, SampleRuns<kFields> samples) {
            const PointGroup::Vectors own = group.gather(normals);
            Lanes inverse, sums[4];
            setInverseSquares(group, width, inverse);
            forLanes(NormalSums{samples, inverse, group.position, own.lanes, sums});
            for (std::size_t lane = 0; lane < group.size; ++lane) {
                const std::uint32_t v = group.row[lane];
                const Vec3f sum(sums[0][lane], sums[1][lane], sums[2][lane]);
                const float length = sum.length();
                means.normal[v] = length > 0 ? sum / length : normals[v];
                means.variation[v] = sums[3][lane] > 0 ? 1 - length / sums[3][lane] : 1;
            }
        });
    return means;
}

void DeformingMesh::setVelocities(std::vector<Vec3f>& velocity) {
    constrainFading(velocity);
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].velocity = Vec3(velocity[v]); });
}

void DeformingMesh::writePositions() {
    parallelFor(size(), 8192, [&](std::size_t v) { mesh_.vertex[v].position = position_[v]; });
}

}  // namespace betamesh
