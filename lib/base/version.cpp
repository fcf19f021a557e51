#include "betamesh/version.h"

namespace betamesh {

const char* version() { return BETAMESH_VERSION; }

}  // namespace betamesh
