// The layer that plays a sequence of .usda files, by value clips of USD.

#pragma once

#include "betamesh/io.h"

#include <filesystem>
#include <string>
#include <vector>

namespace betamesh {

/// The file of one frame.
struct ClipFile {
    int frame = 0;
    std::string asset;           ///< path relative to the layer, for USD
    std::filesystem::path path;  ///< to open
};

/// A layer with one prim that takes its values from a file per frame. It is its own manifest: it declares every
/// attribute that some of the files declare. Between frames the values of the earlier frame hold, because meshes of two
/// frames have nothing in common; renderers blur by `velocities`.
///
/// in      files: written by encodeUsda() with WriteOptions::frame, ascending frames; others are left out
///         asset: path of the layer itself, relative to itself
/// out     the text of the layer, which has a digest of the rest of it; empty if there are no such files
/// cost    reads the beginning of each file
/// source  "Value Clips" in the documentation of OpenUSD
std::string usdClipsLayer(const std::vector<ClipFile>& files, const std::string& asset, const WriteOptions& options);

/// Whether a file was written by usdClipsLayer(). False if it cannot be read.
bool isUsdClipsLayer(const std::filesystem::path& path);

/// Whether such a file was changed afterwards.
bool isEditedUsdClipsLayer(const std::filesystem::path& path);

/// Copies frame rate, up axis and unit of a file of encodeUsda() to options. Does nothing if there is no such file.
void copyUsdUnits(const std::filesystem::path& path, WriteOptions& options);

}  // namespace betamesh
