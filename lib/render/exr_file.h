// EXR files; wrapper of OpenEXR.
//
// Written: one part, scan lines, ZIP compression. Channels R G B A shadow N.X N.Y N.Z are half floats, Z P.X P.Y P.Z
// forward.u forward.v floats, id an unsigned integer. Read: the same channels, of any EXR file that OpenEXR reads.
// Format: "Technical Introduction to OpenEXR", openexr.com.

#pragma once

#include "render/picture.h"

#include <string>

namespace betamesh {

/// The bytes of an .exr file. Planes that the picture lacks are left out.
///
/// same    bytes for any thread count
std::string encodeExr(const Picture& picture);

/// Reads the channels that encodeExr() writes. Planes whose channels are missing stay empty.
///
/// in      file: its name, for error messages
/// errors  not an EXR file, or a damaged one
Picture decodeExr(const std::string& bytes, const std::string& file);

}  // namespace betamesh
