
#include "io/vdb.h"

#include "base/module.h"
#include "io/vdb_module.h"
#include "io/vdb_process.h"

namespace betamesh {

namespace {

const VdbModule& vdbModule() {
    static const void* const module = loadModule("betamesh_vdb", "support for .vdb");
    return *static_cast<const VdbModule*>(module);
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
