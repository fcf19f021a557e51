// PNG files; wrapper of libpng.
//
// Written: 8 bits per channel, RGB, sRGB. Read: any PNG file, converted to that.
// Format: "Portable Network Graphics (PNG) Specification", W3C.

#pragma once

#include "render/picture.h"

#include <string>
#include <string_view>

namespace betamesh {

/// The bytes of a .png file.
std::string encodePng(const Image& image);

/// in      file: its name, for error messages
/// errors  not a PNG file, or a damaged one
Image decodePng(std::string_view bytes, const std::string& file);

}  // namespace betamesh
