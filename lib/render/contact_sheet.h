// Contact sheets: many pictures in one image.

#pragma once

#include "render/picture.h"

#include <span>
#include <string>

namespace betamesh {

struct CaptionedImage {
    Image image;
    std::string caption;
};

/// Arranges pictures row by row on white, each with its caption below.
///
/// in      images of one size; columns > 0
/// errors  the font of the captions is not installed
Image contactSheet(std::span<const CaptionedImage> images, int columns);

}  // namespace betamesh
