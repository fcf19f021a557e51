// The door of libpng.

#pragma once

#include "render/picture.h"

#include <string>
#include <string_view>

namespace betamesh {

/// A .png file: 8 bits a channel, sRGB.
std::string encodePng(const Image& image);

/// file    for messages
/// errors  what is no PNG
Image decodePng(std::string_view bytes, const std::string& file);

}  // namespace betamesh
