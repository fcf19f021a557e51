// The door of FreeType: words on pictures.

#pragma once

#include "render/picture.h"

#include <string>

namespace betamesh {

/// Writes ASCII text in DejaVu Sans, its base line beginning at (x, y), capitals about 0.73 `size` pixels high. What
/// lies outside the picture is lost.
///
/// out     how many pixels wide it is
/// errors  the font is not installed
int writeText(Image& image, int x, int y, int size, const std::string& text, const Colour& colour);

}  // namespace betamesh
