// The door of the dynamic loader. Libraries whose symbols take long to bind, or that few jobs need, stand in modules:
// NAME.so, beside the program or where it was installed, with an object of that name that holds what the module offers.

#pragma once

#include <string>

namespace betamesh {

/// The object of the module's name. It is loaded where that was not done before, and stays: libraries register things
/// with themselves.
///
/// purpose  for messages, as in "support for .vdb"
/// errors   where it cannot be found
const void* loadModule(const std::string& name, const std::string& purpose);

}  // namespace betamesh
