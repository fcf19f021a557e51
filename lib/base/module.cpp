
#include "base/module.h"

#include "betamesh/error.h"

#include <dlfcn.h>

namespace betamesh {

const void* loadModule(const std::string& name, const std::string& purpose) {
    const std::string file = name + ".so";
    void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* const object = library ? dlsym(library, name.c_str()) : nullptr;
    if (!object)
        throw Error(purpose + " cannot be loaded: " + dlerror() + "; expected " + file +
                    " where betamesh was built or installed, or in LD_LIBRARY_PATH");
    return object;
}

}  // namespace betamesh
