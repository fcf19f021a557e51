// Long calls from Python: other threads of Python go on meanwhile, and Ctrl-C or a callback ends them.

#pragma once

#include "python/binding.h"

#include <functional>
#include <string_view>

namespace betamesh {

/// How a call runs.
struct CallOptions {
    int threads = 0;                   ///< at most; 0: as many as there are processors
    nb::object progress = nb::none();  ///< None, or a function progress(stage: str, seconds: float)
};

/// The options from Python's arguments.
///
/// in      threads: None, or a whole number from 1
/// errors  other values
CallOptions callOptions(nb::handle threads, nb::handle progress);

/// Told the name of each stage as it begins.
using StageBegins = std::function<void(std::string_view)>;

/// Calls work(begins) without the lock of the interpreter, in another thread. Meanwhile this one handles signals and
/// calls options.progress about ten times per second and when a stage begins. If a signal handler (as Ctrl-C) or
/// progress raises an exception, cancels the work at its next parallel loop and raises that exception.
///
/// errors  what work throws
void callInterruptibly(const CallOptions& options, const std::function<void(const StageBegins&)>& work);

}  // namespace betamesh
