
#include "render/png_file.h"

#include "betamesh/error.h"

#include <png.h>

#include <new>

namespace betamesh {

namespace {

png_image header() {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    return png;
}

}  // namespace

std::string encodePng(const Image& image) {
    png_image png = header();
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    png.flags = PNG_IMAGE_FLAG_FAST;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixel.data(), 0, nullptr) == 0)
        throw std::bad_alloc();  // the only thing that can go wrong in memory
    bytes.resize(size);
    return bytes;
}

Image decodePng(std::string_view bytes, const std::string& file) {
    png_image png = header();
    if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0)
        throw Error(file + ": cannot be read as a PNG picture: " + png.message);
    png.format = PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height), {});
    if (png_image_finish_read(&png, nullptr, image.pixel.data(), 0, nullptr) == 0)
        throw Error(file + ": the PNG picture is damaged: " + png.message);
    return image;
}

}  // namespace betamesh
