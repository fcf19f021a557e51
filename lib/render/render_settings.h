// What a picture looks like.

#pragma once

#include <optional>
#include <string>

namespace betamesh {

enum class Shading {
    studio,  ///< a soft key light and a rim light, a bright room to reflect
    zebra    ///< black and white stripes reflected: straight where the surface is flat
};

enum class ColourBy {
    nothing,
    velocity,   ///< speed
    kind,       ///< the surface itself, bubbles, triangles that both sides share, spheres
    curvature,  ///< the mean of the principal curvatures, 1 / world units, positive where the surface bulges outwards
    component,  ///< connected pieces
    attribute   ///< of the mesh's vertices
};

/// Leaves away what lies on one side of a place along an axis.
struct Cut {
    int axis = 0;       ///< 0 x, 1 y, 2 z
    bool below = true;  ///< what stays
    double at = 0;      ///< world units
};

struct Colouring {
    ColourBy by = ColourBy::nothing;
    std::string attribute;     ///< its name
    double low = 0, high = 0;  ///< values of the ends of the scale; equal: those of the frame itself
};

struct Look {
    int width = 1920, height = 1080;  ///< pixels, > 0
    int samples = 8;                  ///< of each pixel, > 0
    Shading shading = Shading::studio;
    bool flat = false;  ///< triangles as they are, rather than as if the surface were round
    Colouring colouring;
    std::optional<Cut> cut;        ///< the inside of what is cut open is plain
    double wireframe = 0;          ///< width of the triangles' edges, pixels; 0: not drawn
    double shutter = 0;            ///< how long it is open round the moment of the frame, frames
    double fps = 24;               ///< frames per second, > 0
    std::optional<double> ground;  ///< the height, along the camera's up, of the ground that takes shadows
    bool layers = false;           ///< fill all planes of the picture
};

}  // namespace betamesh
