// Text on images; wrapper of FreeType.

#pragma once

#include "render/picture.h"

#include <string>

namespace betamesh {

/// Draws ASCII text in DejaVu Sans. Its baseline starts at (x, y); capitals are about 0.73 `size` pixels high. Text
/// outside the image is clipped.
///
/// out     width of the text, pixels
/// errors  the font is not installed
int writeText(Image& image, int x, int y, int size, const std::string& text, const Colour& colour);

}  // namespace betamesh
