// Takes the grain of few samples out of shadows, and only that.

#pragma once

#include "render/camera.h"
#include "render/picture.h"

namespace betamesh {

/// One smooth surface as some samples of a pixel see it.
struct SurfaceSample {
    float key = 0, sky = 0;   ///< share of each light that arrives, mean over those samples
    float share = 0;          ///< of the pixel's samples
    Vec3f from_key{0, 0, 0};  ///< linear light where all of it arrives, times share
    Vec3f from_sky{0, 0, 0};
    Vec3f normal{0, 0, 0};  ///< unit length
    float depth = 0;        ///< along the camera's axis, in any unit; 0: none
};

/// What pixels see; a row for each pixel, zeros where it sees nothing. At edges a pixel sees a second surface.
struct LitSurfaces {
    static constexpr float kNormalsApart = 0.25f;  ///< squared distance of unit normals of different surfaces
    static constexpr float kOffPlane = 2;          ///< distance of one from the other's tangent plane, pixels

    Plane key, sky, share, depth;
    std::array<Plane, 3> from_key, from_sky, normal;
    struct Second {
        int x, y;
        SurfaceSample surface;
    };
    std::vector<std::vector<Second>> second;  ///< in lists of any length

    LitSurfaces(std::size_t pixels, std::size_t lists);
    void set(std::size_t pixel, const SurfaceSample& surface);
};

/// Replaces the shares of light in a picture by means over the pixels around that see the same smooth surface in much
/// the same light, and does so with the ground's shadow. How much the same is measured by the error to be expected of
/// so many samples: with more of them less is averaged, and the picture is the same as an unfiltered one in the limit.
///
/// same    pixels for any thread count
/// cost    O(pixels)
/// source  Tomasi & Manduchi 1998, bilateral filter; as a correction added to the unfiltered picture
void filterLight(const LitSurfaces& surfaces, const View& view, int samples, Picture& picture);

}  // namespace betamesh
