// A mesh on its way to the skin: where its vertices are, what they stand for, and means over what is near them.

#pragma once

#include "core/beta_mesh.h"
#include "core/graph.h"
#include "skin/vicinity.h"

#include <functional>
#include <vector>

namespace betamesh {

/// A mesh whose vertices are moved step by step, with the area and the normal that each vertex stands for.
///
/// A vertex stands for a third of the triangles round it. One that fades in hands as much of that to the vertices it
/// rises from as its share is short of 1, and goes as far as they do by as much: area, normals and steps then change
/// continuously as vertices appear and vanish and as edges flip, because neither changes how a plane polygon is
/// shared out.
class MovedSurface {
public:
    /// unit: the length in which areas and steps are told, world units.
    MovedSurface(BetaMesh& mesh, double unit);

    std::size_t size() const { return position_.size(); }
    double unit() const { return unit_; }
    const std::vector<Vec3>& position() const { return position_; }
    float area(std::size_t v) const { return area_[v]; }             ///< square units
    const Vec3f& normal(std::size_t v) const { return normal_[v]; }  ///< unit vector, or zero
    const std::vector<Vec3f>& normals() const { return normal_; }
    const BetaMesh& mesh() const { return mesh_; }

    /// Makes values of vertices that fade in those of their supports, by what their share is short of 1.
    template <typename Value>
    void hold(std::vector<Value>& values) const {
        for (const auto& group : mesh_.rising) {
            std::vector<Value> held(group.size());
            parallelFor(group.size(), 1024, [&](std::size_t i) {
                const RisingVertex& rising = group[i];
                Value from(0);
                for (std::size_t k = 0; k < 4; ++k)
                    from += values[rising.from[k]] * static_cast<float>(rising.weight[k].value);
                const auto share = static_cast<float>(rising.share.value);
                held[i] = values[rising.vertex] * share + from * (1 - share);
            });
            for (std::size_t i = 0; i < group.size(); ++i) values[group[i].vertex] = held[i];
        }
    }
    /// Moves every vertex by its step, in units, held; works areas and normals out anew.
    void move(std::vector<Vec3f>& step);
    /// Splits edges at vertices that fade in as their need grows from 1 to 2. Rounds 0 and 1.
    void refine(std::size_t round, const std::function<double(std::uint32_t, std::uint32_t)>& need);
    /// Draws vertices at folded edges towards the middle of those round them.
    void unfold();
    /// Sets the velocities of the mesh, held.
    void setVelocities(std::vector<Vec3f>& velocity);
    /// Writes the positions to the mesh.
    void finish();

    /// Groups of vertices where they are now, and the vertices within reach of each, in units. Kept until vertices
    /// have moved too far.
    struct Vicinity {
        const PointGroups& groups;
        const Rows& near;
    };
    Vicinity vicinity(double reach);
    /// Samples of something else within reach of each of those groups.
    Rows near(const CellOrder& samples, const std::vector<Vec3>& sample, double reach) const {
        return nearGroups(groups_, samples, sample, (reach + moved_) * unit_);
    }

private:
    void measure();
    void listTriangles();

    BetaMesh& mesh_;
    double unit_;
    std::vector<Vec3> position_;
    Rows triangles_of_;  // of each vertex
    std::vector<float> area_;
    std::vector<Vec3f> normal_;
    std::vector<float> agreement_;  // of the triangles' normals round each vertex: 1 where they are one

    std::vector<Vec3> grouped_at_;  // where vertices were as they were grouped
    double moved_ = 0, reach_ = 0;  // at most since then, units; of the lists, with a margin
    PointGroups groups_;
    Rows near_;
};

template <std::size_t kValues>
struct SumMean {
    std::span<const SampleFields<4 + kValues>> samples;  // position, area, values
    float inverse_square_width;
    const Lanes (&point)[3];
    Lanes (&mean)[kValues];

    template <std::size_t kWidth>
    __attribute__((always_inline)) void operator()(std::size_t first) const {
        using Some = Floats<kWidth>;
        Some x[3];
        getLanes<kWidth>(point, first, x);
        const Some zero{}, one = zero + 1.0F;
        Some sum[kValues] = {}, weight = zero + 1e-12F;
        for (const auto& f : samples) {
            const Some px = f[0] - x[0], py = f[1] - x[1], pz = f[2] - x[2];
            Some t = one - (px * px + py * py + pz * pz) * inverse_square_width;
            t = t > 0 ? t : zero;
            const Some w = t * t * f[3];
            weight += w;
            for (std::size_t k = 0; k < kValues; ++k) sum[k] += w * f[4 + k];
        }
        for (std::size_t k = 0; k < kValues; ++k) sum[k] = sum[k] / weight;
        setLanes<kWidth>(mean, first, sum);
    }
};

/// Kernel means in space of values of the vertices, (1 - d²/width²)² times area their weight.
template <std::size_t kValues>
std::vector<std::array<float, kValues>> meansOf(MovedSurface& surface, double width,
                                                const std::vector<std::array<float, kValues>>& values) {
    const auto [groups, near] = surface.vicinity(width);
    std::vector<std::array<float, kValues>> means(values.size());
    const auto inverse = static_cast<float>(1 / (width * width));
    forGroups<4 + kValues>(
        groups, surface.position(), near, surface.position(), surface.unit(),
        [&](std::uint32_t v, SampleFields<4 + kValues>& f) {
            f[3] = surface.area(v) + 1e-9F;
            for (std::size_t k = 0; k < kValues; ++k) f[4 + k] = values[v][k];
        },
        [&](const GroupLanes& group, std::span<const SampleFields<4 + kValues>> samples) {
            Lanes mean[kValues];
            forLanes(SumMean<kValues>{samples, inverse, group.place, mean});
            for (std::size_t lane = 0; lane < group.size; ++lane)
                for (std::size_t k = 0; k < kValues; ++k) means[group.row[lane]][k] = mean[k][lane];
        });
    return means;
}

}  // namespace betamesh
