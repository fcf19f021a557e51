// Gzip streams, the door of zlib.

#pragma once

#include "io/bytes.h"

namespace betamesh {

/// Does what follows begin like gzip?
bool isGzip(Cursor& in);

/// What a stream of one or more gzip members holds, unpacked as it is read.
///
/// errors  a damaged stream; one that grows beyond a hundred times its size and 256 MiB, as no particles do
Cursor gunzipped(Cursor packed);

/// Packs what comes into one gzip member, on several threads: it is cut into blocks of one size, each packed for itself
/// with the end of the one before as its dictionary.
///
/// same    bytes for the same input, whatever the threads and pieces in which it comes: no name, no time
class GzipWriter {
public:
    using Drain = std::function<void(std::span<const std::byte>)>;
    explicit GzipWriter(Drain drain);

    void write(std::span<const std::byte> bytes);
    /// Must be called at the end.
    void finish();

private:
    void pack();

    Drain drain_;
    Bytes dictionary_;  // the end of what was packed
    Bytes waiting_;
    std::uint32_t check_, size_ = 0;
};

}  // namespace betamesh
