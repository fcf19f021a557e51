// The container of Houdini's .sc files: blocks of bytes, each compressed by Blosc. The wrapper of libblosc.

#pragma once

#include "io/bytes.h"

namespace betamesh {

/// Do the next bytes begin such a container?
bool isScf(Cursor& in);

/// The content of a container, unpacked as it is read.
///
/// errors  a damaged block, with its byte; a table of blocks that does not agree with them; content that grows beyond
///         256 times the file's size and 256 MiB, which no geometry does
Cursor scfUnpacked(Cursor packed);

/// Packs bytes into a container as Houdini does: blocks of one MiB, shuffled by four bytes, LZ4; on several threads.
///
/// same    bytes for the same input, whatever the threads and the pieces in which it comes
class ScfWriter {
public:
    using Drain = std::function<void(std::span<const std::byte>)>;
    explicit ScfWriter(Drain drain);

    void write(std::span<const std::byte> bytes);
    /// Must be called at the end.
    void finish();

private:
    void pack();

    Drain drain_;
    Bytes waiting_;
    std::vector<std::uint64_t> ends_;  // of the blocks so far, from the first one's begin
    std::uint64_t last_size_ = 0;      // of the last block before it was packed
};

}  // namespace betamesh
