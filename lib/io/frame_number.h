// The frame number in a file name.

#pragma once

#include <string_view>

namespace betamesh {

/// The number before the extension of a file name without folders: "0012" in "splash.0012.vdb", "-003" in
/// "drop_-003.ply". Empty, at the end of the name without extension, if there is none: in "drop.ply", and in
/// "drop_v002.ply", whose number is that of a version.
std::string_view frameNumberIn(std::string_view name);

}  // namespace betamesh
