// What betamesh_pictures offers, outside it.

#include "base/module.h"
#include "render/exr_file.h"
#include "render/picture_module.h"
#include "render/png_file.h"
#include "render/render_frame.h"
#include "render/text.h"

namespace betamesh {

namespace {

const PictureModule& pictureModule() {
    static const void* const module = loadModule("betamesh_pictures", "support for pictures");
    return *static_cast<const PictureModule*>(module);
}

}  // namespace

Picture renderFrame(const Mesh& mesh, const Spheres& spheres, const Camera& camera, const RenderSettings& settings) {
    return pictureModule().renderFrame(mesh, spheres, camera, settings);
}

std::string encodeExr(const Picture& picture) { return pictureModule().encodeExr(picture); }

Picture decodeExr(const std::string& bytes, const std::string& file) { return pictureModule().decodeExr(bytes, file); }

std::string encodePng(const Image& image) { return pictureModule().encodePng(image); }

Image decodePng(std::string_view bytes, const std::string& file) { return pictureModule().decodePng(bytes, file); }

int writeText(Image& image, int x, int y, int size, const std::string& text, const Colour& colour) {
    return pictureModule().writeText(image, x, y, size, text, colour);
}

}  // namespace betamesh
