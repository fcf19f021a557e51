
#include "render/light_filter.h"

#include "base/parallel.h"
#include "base/simd.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr int kRadius = 3;               // of the neighbourhood that is averaged, pixels
constexpr float kOneSampleError = 1;     // largest error of a visibility estimated from one sample
constexpr float kErrorExponent = 0.75f;  // the error of n well distributed samples is proportional to n^-0.75

/// Filter kernel (1 - x^2)^2 of the squared distance x^2; zero beyond a distance of 1.
inline float kernel(float squared) {
    const float rest = 1 - squared;
    return rest > 0 ? rest * rest : 0.0f;
}

/// One line each of the visibilities to be averaged, and of their 3 × 3 means, by which pixels are compared.
struct Shares {
    const float *key, *sky, *shadow;
    const float *rough_key, *rough_sky, *rough_shadow;
};

/// Pointers to one line of the picture.
struct Line {
    const float *alpha, *share_of_pixel, *depth, *normal[3];
    Shares share;
    Vec3f first;  // viewing direction of its first pixel
};

/// Sums over the neighbours of each pixel of a line.
struct LineSums {
    explicit LineSums(std::size_t width) {
        for (auto* plane : {&key, &sky, &shadow, &keys, &skies, &shadows}) plane->resize(width);
    }
    Plane key, sky, shadow;      // weighted visibilities
    Plane keys, skies, shadows;  // weights
};

struct Sharpness {
    float plane;  // 1 / square of the largest distance from the tangent plane, at unit depth
    float share;  // 1 / square of the largest difference of visibilities; 0: they are not compared
};

/// For each pixel i in [begin, end) of a line, adds pixel i + shift_x of another line to the sums.
BETAMESH_EVERY_CPU
void addNeighbours(const Line& line, const Line& other, int shift_x, int begin, int end, const Vec3f& across,
                   const Sharpness& sharpness, LineSums& sums) {
    const float x0 = line.first.x, y0 = line.first.y, z0 = line.first.z, dx = across.x, dy = across.y, dz = across.z;
    const Vec3f shift = other.first + across * static_cast<float>(shift_x) - line.first;
    const float sx = shift.x, sy = shift.y, sz = shift.z, per_plane = sharpness.plane, per_share = sharpness.share;
    const float *nx = line.normal[0], *ny = line.normal[1], *nz = line.normal[2], *depth = line.depth;
    const float *rough_key = line.share.rough_key, *rough_sky = line.share.rough_sky,
                *rough_shadow = line.share.rough_shadow;
    const float *mx = other.normal[0] + shift_x, *my = other.normal[1] + shift_x, *mz = other.normal[2] + shift_x,
                *far = other.depth + shift_x, *alpha = other.alpha + shift_x, *part = other.share_of_pixel + shift_x,
                *other_key = other.share.key + shift_x, *other_sky = other.share.sky + shift_x,
                *other_shadow = other.share.shadow + shift_x, *other_rough_key = other.share.rough_key + shift_x,
                *other_rough_sky = other.share.rough_sky + shift_x,
                *other_rough_shadow = other.share.rough_shadow + shift_x;
    float *key = sums.key.data(), *sky = sums.sky.data(), *shadow = sums.shadow.data();
    float *keys = sums.keys.data(), *skies = sums.skies.data(), *shadows = sums.shadows.data();
#pragma GCC ivdep
    for (int i = begin; i < end; ++i) {
        const float tx = mx[i] - nx[i], ty = my[i] - ny[i], tz = mz[i] - nz[i];
        const float turned = tx * tx + ty * ty + tz * tz;
        // Distance of the other pixel's surface from this one's tangent plane, relative to the depth.
        const auto at = static_cast<float>(i);
        const float x = x0 + dx * at, y = y0 + dy * at, z = z0 + dz * at;
        const float ratio = far[i] / (depth[i] > 0 ? depth[i] : 1.0f);
        const float off =
            ((x + sx) * ratio - x) * nx[i] + ((y + sy) * ratio - y) * ny[i] + ((z + sz) * ratio - z) * nz[i];
        const float both = ((depth[i] > 0) & (far[i] > 0)) ? part[i] : 0.0f;
        const float same =
            both * kernel(turned * (1 / LitSurfaces::kMaxNormalDistance2)) * kernel(off * off * per_plane);
        const float more_key = other_rough_key[i] - rough_key[i], more_sky = other_rough_sky[i] - rough_sky[i],
                    more_shadow = other_rough_shadow[i] - rough_shadow[i];
        const float as_key = same * kernel(more_key * more_key * per_share),
                    as_sky = same * kernel(more_sky * more_sky * per_share),
                    as_ground = (1 - alpha[i]) * kernel(more_shadow * more_shadow * per_share);
        key[i] += as_key * other_key[i], keys[i] += as_key;
        sky[i] += as_sky * other_sky[i], skies[i] += as_sky;
        shadow[i] += as_ground * other_shadow[i], shadows[i] += as_ground;
    }
}

/// Averages each pixel with similar pixels around it.
class LineFilter {
public:
    LineFilter(const LitSurfaces& surface, const Plane& shadow, const Picture& picture, const View& view)
        : surface_(surface),
          shadow_(shadow),
          alpha_(picture.alpha),
          width_(picture.width),
          height_(picture.height),
          corner_(view.direction(0.5, 0.5)),
          across_(view.direction(1.5, 0.5) - view.direction(0.5, 0.5)),
          down_(view.direction(0.5, 1.5) - view.direction(0.5, 0.5)),
          plane_(static_cast<float>(1 / std::pow(LitSurfaces::kMaxPlaneDistance * view.pixel(), 2))) {}

    /// Calls each(pixel, mean key, mean sky, mean shadow) for every pixel. The means are taken over pixels up to
    /// `radius` away, weighted by how similar their rough_* are (Sharpness::share); NaN if all weights are zero.
    template <typename Each>
    void average(int radius, float sharpness, const Plane& rough_key, const Plane& rough_sky, const Plane& rough_shadow,
                 const Each& each) const {
        parallelFor(static_cast<std::size_t>(height_), 4, [&](std::size_t row) {
            const int y = static_cast<int>(row);
            LineSums sums(static_cast<std::size_t>(width_));
            const auto line = [&](int v) {
                const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
                return Line{&alpha_[at],
                            &surface_.share[at],
                            &surface_.depth[at],
                            {&surface_.normal[0][at], &surface_.normal[1][at], &surface_.normal[2][at]},
                            {&surface_.key[at], &surface_.sky[at], &shadow_[at], &rough_key[at], &rough_sky[at],
                             &rough_shadow[at]},
                            corner_ + down_ * static_cast<float>(v)};
            };
            for (int v = std::max(0, y - radius); v <= std::min(height_ - 1, y + radius); ++v)
                for (int shift_x = -radius; shift_x <= radius; ++shift_x)
                    addNeighbours(line(y), line(v), shift_x, std::max(0, -shift_x), std::min(width_, width_ - shift_x),
                                  across_, {plane_, sharpness}, sums);
            const std::size_t first = row * static_cast<std::size_t>(width_);
            for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x)
                each(first + x, sums.key[x] / sums.keys[x], sums.sky[x] / sums.skies[x],
                     sums.shadow[x] / sums.shadows[x]);
        });
    }

    /// Averages the visibilities of a second surface over the neighbouring pixels that see it as their first surface.
    SurfaceSample averaged(const LitSurfaces::Second& second, int radius, float sharpness, const Plane& rough_key,
                           const Plane& rough_sky, float key, float sky) const {
        SurfaceSample sum = second.surface;
        float keys = sum.share, skies = sum.share;
        sum.key *= sum.share, sum.sky *= sum.share;
        const Vec3f& n = second.surface.normal;
        const Vec3f middle = direction(second.x, second.y);
        for (int v = std::max(0, second.y - radius); v <= std::min(height_ - 1, second.y + radius); ++v)
            for (int u = std::max(0, second.x - radius); u <= std::min(width_ - 1, second.x + radius); ++u) {
                const std::size_t k =
                    static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
                if (!(surface_.depth[k] > 0)) continue;
                const Vec3f turn = Vec3f(surface_.normal[0][k], surface_.normal[1][k], surface_.normal[2][k]) - n;
                const float off = (direction(u, v) * (surface_.depth[k] / second.surface.depth) - middle).dot(n);
                const float same = surface_.share[k] * kernel(turn.length2() / LitSurfaces::kMaxNormalDistance2) *
                                   kernel(off * off * plane_);
                const float more_key = rough_key[k] - key, more_sky = rough_sky[k] - sky;
                const float as_key = same * kernel(more_key * more_key * sharpness),
                            as_sky = same * kernel(more_sky * more_sky * sharpness);
                sum.key += as_key * surface_.key[k], keys += as_key;
                sum.sky += as_sky * surface_.sky[k], skies += as_sky;
            }
        sum.key /= keys, sum.sky /= skies;
        return sum;
    }

private:
    Vec3f direction(int x, int y) const {
        return corner_ + across_ * static_cast<float>(x) + down_ * static_cast<float>(y);
    }

    const LitSurfaces& surface_;
    const Plane &shadow_, &alpha_;
    int width_, height_;
    Vec3f corner_, across_, down_;
    float plane_;
};

}  // namespace

LitSurfaces::LitSurfaces(std::size_t pixels, std::size_t lists) : second(lists) {
    for (Plane* plane : {&key, &sky, &share, &depth}) plane->resize(pixels);
    for (auto* planes : {&from_key, &from_sky, &normal})
        for (Plane& plane : *planes) plane.resize(pixels);
}

void LitSurfaces::set(std::size_t pixel, const SurfaceSample& surface) {
    key[pixel] = surface.key, sky[pixel] = surface.sky, share[pixel] = surface.share, depth[pixel] = surface.depth;
    for (std::size_t c = 0; c < 3; ++c) {
        const int axis = static_cast<int>(c);
        from_key[c][pixel] = surface.from_key[axis];
        from_sky[c][pixel] = surface.from_sky[axis];
        normal[c][pixel] = surface.normal[axis];
    }
}

// Visibilities estimated from few samples are too noisy to be compared; their means over 3 × 3 pixels are compared.
void filterLight(const LitSurfaces& surfaces, const View& view, int samples, Picture& picture) {
    const Plane shadow = picture.shadow;
    const LineFilter filter(surfaces, shadow, picture, view);
    Plane rough_key(picture.size()), rough_sky(picture.size()), rough_shadow(picture.size());
    filter.average(1, 0, surfaces.key, surfaces.sky, shadow, [&](std::size_t i, float key, float sky, float ground) {
        rough_key[i] = surfaces.depth[i] > 0 ? key : 0;
        rough_sky[i] = surfaces.depth[i] > 0 ? sky : 0;
        rough_shadow[i] = picture.alpha[i] < 1 ? ground : 0;
    });
    const float error = kOneSampleError / std::pow(static_cast<float>(samples), kErrorExponent);
    const float sharpness = 1 / (error * error);
    Plane* const channels[] = {&picture.red, &picture.green, &picture.blue};
    filter.average(kRadius, sharpness, rough_key, rough_sky, rough_shadow,
                   [&](std::size_t i, float key, float sky, float ground) {
                       if (picture.alpha[i] < 1) picture.shadow[i] = ground;
                       if (!(surfaces.depth[i] > 0)) return;
                       const float more_key = key - surfaces.key[i], more_sky = sky - surfaces.sky[i];
                       for (std::size_t c = 0; c < 3; ++c)
                           (*channels[c])[i] += surfaces.from_key[c][i] * more_key + surfaces.from_sky[c][i] * more_sky;
                   });
    parallelFor(surfaces.second.size(), 1, [&](std::size_t list) {
        for (const LitSurfaces::Second& second : surfaces.second[list]) {
            const SurfaceSample rough = filter.averaged(second, 1, 0, rough_key, rough_sky, 0, 0);
            const SurfaceSample smooth =
                filter.averaged(second, kRadius, sharpness, rough_key, rough_sky, rough.key, rough.sky);
            const Vec3f more = second.surface.from_key * (smooth.key - second.surface.key) +
                               second.surface.from_sky * (smooth.sky - second.surface.sky);
            const std::size_t i = static_cast<std::size_t>(second.y) * static_cast<std::size_t>(picture.width) +
                                  static_cast<std::size_t>(second.x);
            for (std::size_t c = 0; c < 3; ++c) (*channels[c])[i] += more[static_cast<int>(c)];
        }
    });
}

}  // namespace betamesh
