// Pictures: planes of floats as rendered, and 8-bit images for display.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <cstdint>
#include <vector>

namespace betamesh {

using Plane = std::vector<float>;  ///< one number per pixel, row after row from the top left

/// A rendered picture. Light is linear, with the primaries of sRGB. depth, normal, position, motion and id describe the
/// surface point seen through each pixel's centre at the middle of the exposure; they are neither motion blurred nor
/// averaged, and empty unless RenderSettings::layers is set.
struct Picture {
    int width = 0, height = 0;
    Plane red, green, blue;  ///< premultiplied by alpha
    Plane alpha;             ///< fraction of the pixel that the surface covers
    Plane shadow;            ///< fraction of the light that is missing on the ground behind, 0 to 1

    Plane depth;                    ///< along the camera's axis, world units; kFarAway where no surface is seen
    std::array<Plane, 3> normal;    ///< unit vector, world axes
    std::array<Plane, 3> position;  ///< world units
    std::array<Plane, 2> motion;    ///< to the next frame, pixels to the right and upwards
    std::vector<std::uint32_t> id;  ///< kNothing, kMesh or kSphere

    static constexpr float kFarAway = 1e30f;  ///< larger than any depth
    static constexpr std::uint32_t kNothing = 0, kMesh = 1, kSphere = 2;

    std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

using Colour = std::array<std::uint8_t, 3>;

/// An 8-bit image: red, green, blue of each pixel in sRGB.
struct Image {
    int width = 0, height = 0;
    std::vector<Colour> pixel;

    Image() = default;
    Image(int wide, int high, Colour colour)
        : width(wide), height(high), pixel(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high), colour) {}
    Colour& at(int x, int y) {
        return pixel[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
    const Colour& at(int x, int y) const { return const_cast<Image&>(*this).at(x, y); }
};

/// Converts between sRGB values and linear light, both 0 to 1.
float linearOf(float srgb);
float srgbOf(float linear);

/// The picture over a light grey background, converted to sRGB. Values above 1 are clamped.
Image toneMapped(const Picture& picture);

/// Scales an image down; averages linear light over the area of each new pixel.
///
/// in      1 <= width <= image.width, 1 <= height <= image.height
Image shrunk(const Image& image, int width, int height);

/// Copies `from` into `to` with its top left corner at (x, y); clips what is outside.
void paste(const Image& from, int x, int y, Image& to);

}  // namespace betamesh
