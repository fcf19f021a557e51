// Names by which attributes of particles and meshes are known to be accelerations or normals.

#pragma once

#include <string_view>

namespace betamesh {

/// Whether a name in lower case is one of accelerations.
constexpr bool isAccelerationName(std::string_view name) { return name == "accel" || name == "acceleration"; }

/// Whether a name in lower case is one of normals. Those of meshes are `N`, see normalsIn().
constexpr bool isNormalName(std::string_view name) { return name == "n" || name == "normal" || name == "normals"; }

}  // namespace betamesh
