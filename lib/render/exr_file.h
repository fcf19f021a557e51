// The door of OpenEXR.

#pragma once

#include "render/picture.h"

#include <string>

namespace betamesh {

/// A .exr file: one part, scan lines, ZIP. R G B A shadow half; where the picture has them, N.X N.Y N.Z half, Z P.X P.Y
/// P.Z forward.u forward.v float, id unsigned.
///
/// same    bytes for any thread count
std::string encodeExr(const Picture& picture);

/// The planes of a file as encodeExr makes it; halves become floats. Planes that it has not stay empty.
///
/// file    for messages
/// errors  what is no EXR
Picture decodeExr(const std::string& bytes, const std::string& file);

}  // namespace betamesh
