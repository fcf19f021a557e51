// Processing one file after the other, for `info` and `check`.

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace betamesh {

/// A file as errors name it.
struct NamedFile {
    std::string name;
    std::optional<int> frame;  ///< of the time sample, if the file has several
};

/// Processes files in a worker process. If a file ends the worker, for example because memory runs out, that file fails
/// and another worker continues with the next one. Has to be called before the process has a second thread.
///
/// in      nameOf(i): the name of file i
///         process(i): prints what it finds on stdout; returns false if it finds a fault
///         failed(i, error): called for each error after it is logged
/// out     exit code
int forEachFile(std::size_t files, const std::function<NamedFile(std::size_t)>& nameOf,
                const std::function<bool(std::size_t)>& process,
                const std::function<void(std::size_t, const std::string& error)>& failed);

}  // namespace betamesh
