// What the module that makes pictures offers to the rest.

#pragma once

#include "render/camera.h"
#include "render/picture.h"
#include "render/render_settings.h"

#include <string>
#include <string_view>

namespace betamesh {

/// Embree, OpenEXR, libpng and FreeType take a third of the program's start, and most jobs make no picture: so they
/// stand in a module of their own, betamesh_pictures. The functions of these names in the library call the module's.
struct PictureModule {
    Picture (*renderFrame)(const Mesh& mesh, const Spheres& spheres, const Camera& camera,
                           const RenderSettings& settings);
    std::string (*encodeExr)(const Picture& picture);
    Picture (*decodeExr)(const std::string& bytes, const std::string& file);
    std::string (*encodePng)(const Image& image);
    Image (*decodePng)(std::string_view bytes, const std::string& file);
    int (*writeText)(Image& image, int x, int y, int size, const std::string& text, const Colour& colour);
};

}  // namespace betamesh
