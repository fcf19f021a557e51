// The version of betamesh.

#pragma once

namespace betamesh {

/// "0.1.0"
const char* version();

}  // namespace betamesh
