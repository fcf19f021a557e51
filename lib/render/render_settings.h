// Settings of the renderer: size, sampling, shading, colours and the cutaway plane.

#pragma once

#include <optional>
#include <string>

namespace betamesh {

enum class Shading {
    studio,  ///< soft key light, rim light and the reflection of a bright room
    zebra    ///< reflection of black and white stripes, which shows how smooth the surface is
};

enum class ColourBy {
    nothing,
    velocity,   ///< speed
    kind,       ///< one colour each for the outer surface, bubbles, two-sided triangles and spheres
    curvature,  ///< mean of the principal curvatures, 1 / world units, positive where the surface is convex
    component,  ///< connected component
    attribute   ///< a vertex attribute of the mesh
};

/// A plane perpendicular to an axis; the renderer hides everything on one side of it.
struct CutawayPlane {
    int axis = 0;       ///< 0 x, 1 y, 2 z
    bool below = true;  ///< true: what is below the plane stays visible; false: what is above it
    double at = 0;      ///< coordinate of the plane along the axis, world units
};

struct Colouring {
    ColourBy by = ColourBy::nothing;
    std::string attribute;     ///< name of the attribute, for ColourBy::attribute
    double low = 0, high = 0;  ///< values at the ends of the colour scale; equal: the range of the frame
};

struct RenderSettings {
    int width = 1920, height = 1080;  ///< pixels, > 0
    int samples = 8;                  ///< per pixel, > 0
    Shading shading = Shading::studio;
    bool flat = false;  ///< true: shade with the normals of the triangles; false: interpolate vertex normals
    Colouring colouring;
    std::optional<CutawayPlane> cutaway;  ///< the section through the liquid has a plain colour
    double wireframe = 0;                 ///< line width of the triangle edges, pixels; 0: no wireframe
    double shutter = 0;                   ///< exposure time centred on the frame, frames; 0: no motion blur
    double fps = 24;                      ///< frames per second, > 0
    std::optional<double> ground;         ///< height of the shadow-catching ground along the camera's up, world units
    bool layers = false;                  ///< also fill depth, normal, position, motion and id of the picture
};

}  // namespace betamesh
