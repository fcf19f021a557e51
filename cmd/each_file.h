// Commands that look at one file after the other.

#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace betamesh {

/// Looks at files in a process of its own, which one of them may end, as a system does that runs out of memory: that is
/// an error of this file, and another process goes on with the next. To be called before the process has a second
/// thread.
///
/// in      nameOf(i): what is looked at, for errors
///         good(i): says on stdout what it finds; false where that is a fault
///         failed(i, error): told of each error, which is logged
/// out     an exit code
int forEachFile(std::size_t files, const std::function<std::string(std::size_t)>& nameOf,
                const std::function<bool(std::size_t)>& good,
                const std::function<void(std::size_t, const std::string& error)>& failed);

}  // namespace betamesh
