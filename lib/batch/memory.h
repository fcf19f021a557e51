// How much memory frames take, before they are read.

#pragma once

#include <cstdint>
#include <string>

namespace betamesh {

/// What a frame is likely to take at its peak, by the size and the format of its file; bytes. 0 where there is no file.
std::uint64_t workingMemory(const std::string& input);

}  // namespace betamesh
