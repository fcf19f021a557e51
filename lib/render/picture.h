// Pictures: planes of floats as they are rendered, and bytes as they are looked at.

#pragma once

#include "betamesh/vec3.h"

#include <array>
#include <cstdint>
#include <vector>

namespace betamesh {

using Plane = std::vector<float>;  ///< a number for each pixel, row after row from the top left

/// Light is linear, with the primaries of sRGB. The planes below `shadow` are those of the surface seen through the
/// middle of each pixel in the middle of the shutter, neither blurred nor averaged; they have rows only where asked
/// for.
struct Picture {
    int width = 0, height = 0;
    Plane red, green, blue;  ///< of what is seen, times alpha
    Plane alpha;             ///< how much of the pixel it covers
    Plane shadow;            ///< how much of the light on the ground behind is missing, 0 to 1

    Plane depth;                    ///< along the camera's axis, world units; kFarAway where nothing is seen
    std::array<Plane, 3> normal;    ///< unit length, in the world
    std::array<Plane, 3> position;  ///< in the world
    std::array<Plane, 2> motion;    ///< until the next frame, pixels to the right and upwards
    std::vector<std::uint32_t> id;  ///< kNothing, kMesh, kSphere

    static constexpr float kFarAway = 1e30f;  // beyond any scene
    static constexpr std::uint32_t kNothing = 0, kMesh = 1, kSphere = 2;

    std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

using Colour = std::array<std::uint8_t, 3>;

/// Red, green, blue of each pixel in sRGB.
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

/// Linear light of an sRGB value, and back; 0 to 1.
float linearOf(float srgb);
float srgbOf(float linear);

/// The picture on a light neutral background.
Image toneMapped(const Picture& picture);

/// Linear light averaged over the area of each pixel.
///
/// in      1 <= width <= image.width, 1 <= height <= image.height
Image shrunk(const Image& image, int width, int height);

/// Puts the whole of `from` on `to`, its top left corner at (x, y); what lies outside is lost.
void paste(const Image& from, int x, int y, Image& to);

}  // namespace betamesh
