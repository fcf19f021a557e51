// Denoises shadows: removes the noise that few samples per pixel leave in the lighting, and nothing else.

#pragma once

#include "render/camera.h"
#include "render/picture.h"

namespace betamesh {

/// Mean over the samples of a pixel that hit the same smooth surface.
struct SurfaceSample {
    float key = 0, sky = 0;   ///< fraction of each light that arrives, 0 to 1
    float share = 0;          ///< fraction of the pixel's samples that hit this surface
    Vec3f from_key{0, 0, 0};  ///< linear light if all of it arrived, times share
    Vec3f from_sky{0, 0, 0};
    Vec3f normal{0, 0, 0};  ///< unit length
    float depth = 0;        ///< along the camera's axis, any unit; 0: no surface
};

/// The surfaces that pixels see. Planes have one row per pixel, zeros where it sees nothing. Pixels at silhouettes may
/// see a second surface.
struct LitSurfaces {
    /// Two samples belong to different surfaces if the squared difference of their unit normals exceeds this,
    static constexpr float kMaxNormalDistance2 = 0.25f;
    /// or if one is farther than this from the other's tangent plane, in pixels.
    static constexpr float kMaxPlaneDistance = 2;

    Plane key, sky, share, depth;
    std::array<Plane, 3> from_key, from_sky, normal;
    struct Second {
        int x, y;
        SurfaceSample surface;
    };
    std::vector<std::vector<Second>> second;  ///< grouped in lists, one per tile of the picture

    LitSurfaces(std::size_t pixels, std::size_t lists);
    void set(std::size_t pixel, const SurfaceSample& surface);
};

/// Averages the fractions of light that arrive at each pixel over neighbouring pixels that see the same smooth surface
/// in similar light; likewise the shadow on the ground. "Similar" means within the error expected of this many samples,
/// so that more samples are averaged less and the result converges to the unfiltered picture.
///
/// in      samples: per pixel
/// same    pixels for any thread count
/// cost    O(pixels)
/// source  Tomasi & Manduchi 1998, bilateral filter; as a correction added to the unfiltered picture
void filterLight(const LitSurfaces& surfaces, const View& view, int samples, Picture& picture);

}  // namespace betamesh
