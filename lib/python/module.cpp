// The module betamesh._betamesh. The package betamesh adds the functions whose arguments are settings.

#include "betamesh/error.h"
#include "betamesh/version.h"
#include "python/functions.h"
#include "python/objects.h"

#include <exception>

namespace betamesh {
namespace {

/// Raises OSError with its errno, and so FileNotFoundError and so on, or ValueError.
void raise(const std::exception_ptr& exception, void*) {
    try {
        std::rethrow_exception(exception);
    } catch (const FileError& error) {
        PyErr_SetObject(PyExc_OSError, nb::make_tuple(error.errorNumber(), error.what()).ptr());
    } catch (const Error& error) {
        PyErr_SetString(PyExc_ValueError, error.what());
    }
}

}  // namespace
}  // namespace betamesh

NB_MODULE(_betamesh, module) {
    using namespace betamesh;
    nb::register_exception_translator(raise);
    module.def("version", version, "The version of the library, such as 0.2.0.");
    addTypes(module);
    addSurfaceFunctions(module);
    addMeasureFunctions(module);
    addFileFunctions(module);
}
