// The door of the dynamic loader.

#include "io/vdb.h"

#include "core/error.h"
#include "io/vdb_module.h"
#include "io/vdb_process.h"

#include <dlfcn.h>

namespace betamesh {

namespace {

// Stays loaded: OpenVDB has registered its types with itself.
const VdbModule& vdbModule() {
    static const VdbModule& module = []() -> const VdbModule& {
        void* const library = dlopen(kVdbModuleFile, RTLD_NOW | RTLD_LOCAL);
        const void* const symbol = library ? dlsym(library, kVdbModuleSymbol) : nullptr;
        if (!symbol)
            throw Error(std::string("support for .vdb cannot be loaded: ") + dlerror() + "; expected " +
                        kVdbModuleFile + " where betamesh was built or installed, or in LD_LIBRARY_PATH");
        return *static_cast<const VdbModule*>(symbol);
    }();
    return module;
}

}  // namespace

void loadVdb() {
    if (hasVdbProcess())
        loadVdbApart();
    else
        vdbModule();
}

FileContents readVdb(const std::filesystem::path& path, const ReadOptions& options) {
    return hasVdbProcess() ? readVdbApart(path, options) : vdbModule().read(path, options);
}

std::string encodeVdb(const Particles& particles, const std::string& file) {
    return vdbModule().encode(particles, file);
}

}  // namespace betamesh
