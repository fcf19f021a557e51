// What the module that holds OpenVDB offers to the rest.

#pragma once

#include "betamesh/particles.h"
#include "io/file_contents.h"

#include <filesystem>
#include <string>

namespace betamesh {

/// Linking OpenVDB costs every start of the program some 30 ms of symbols, whether a .vdb is touched or not: so it
/// stands in a module of its own, betamesh_vdb, which io/vdb.h loads when it is needed.
struct VdbModule {
    FileContents (*read)(const std::filesystem::path& path, const ReadOptions& options);
    std::string (*encode)(const Particles& particles, const std::string& file);
};

}  // namespace betamesh
