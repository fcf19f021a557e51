// Gzip streams, the door of zlib.

#pragma once

#include "io/bytes.h"

namespace betamesh {

bool isGzip(std::span<const std::byte> bytes);

/// What a stream of one or more gzip members holds.
///
/// errors  a damaged stream; one that grows beyond a hundred times its size and 256 MiB, as no particles do
Bytes gunzip(std::span<const std::byte> bytes, const std::string& file);

/// The same bytes for the same input: no name, no time.
Bytes gzip(std::span<const std::byte> bytes);

}  // namespace betamesh
