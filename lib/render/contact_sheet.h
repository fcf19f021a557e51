// Many pictures on one sheet.

#pragma once

#include "render/picture.h"

#include <span>
#include <string>

namespace betamesh {

struct CaptionedImage {
    Image image;
    std::string caption;
};

/// IndexRows of pictures with their captions below, on white; all pictures have one size.
///
/// in      columns > 0
/// errors  the font of captions is not installed
Image contactSheet(std::span<const CaptionedImage> images, int columns);

}  // namespace betamesh
