// Gzip streams; wrapper of zlib.
//
// Read: one or more gzip members.
// Written: one member.
// Format: RFC 1952 (gzip) and RFC 1951 (deflate).

#pragma once

#include "io/bytes.h"

namespace betamesh {

/// Whether the next two bytes are the magic number of gzip.
bool isGzip(Cursor& in);

/// The contents of a gzip stream, decompressed on demand.
///
/// errors  a damaged stream; one that decompresses to more than 256 MiB and more than a hundred times its size, which
///         particles never do
Cursor gunzipped(Cursor packed);
/// The same for one zlib stream.
Cursor inflatedZlib(Cursor packed);

/// Decompresses one zlib stream of a known size; false where it is damaged or of another size.
bool inflateBlock(std::span<const std::byte> packed, std::span<std::byte> block);

/// Compresses data into one gzip member on several threads. Blocks of fixed size are compressed independently, each
/// with the end of the previous block as its dictionary.
///
/// same    bytes for the same input, for any thread count and however the input is divided among calls; the header
///         contains neither name nor time
class GzipWriter {
public:
    using Sink = std::function<void(std::span<const std::byte>)>;
    explicit GzipWriter(Sink sink);

    void write(std::span<const std::byte> bytes);
    /// Writes what is still buffered and the trailer. Must be called at the end.
    void finish();

private:
    void compressPending();

    Sink sink_;
    Bytes dictionary_;  // the last 32 KiB that were compressed
    Bytes pending_;     // not compressed yet
    std::uint32_t checksum_, size_ = 0;
};

}  // namespace betamesh
