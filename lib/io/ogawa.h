// Ogawa: the container of Alembic files.
//
// Layout, little-endian: "Ogawa", ff once the file is complete, 00 01 (version), u64 position of the root group. A
// group: u64 number of children, then a u64 for each: its position, with bit 63 set if it is data. Position 0 is an
// empty group or empty data. Data: u64 number of bytes, then these.
// Source: Alembic 1.8, lib/Alembic/Ogawa.

#pragma once

#include "io/bytes.h"

#include <functional>
#include <set>

namespace betamesh {

/// The reference to a child in its group.
using OgawaChild = std::uint64_t;
inline constexpr OgawaChild kOgawaDataBit = OgawaChild{1} << 63;
inline constexpr OgawaChild kEmptyGroup = 0;
inline constexpr OgawaChild kEmptyData = kOgawaDataBit;

/// Lays a file out first and writes it from beginning to end afterwards. Children are added before their groups.
class OgawaWriter {
public:
    using Write = std::function<void(ByteWriter&)>;

    /// Data of so many bytes, which write() writes when their turn comes.
    OgawaChild data(std::uint64_t size, Write write);
    OgawaChild data(std::string bytes);
    OgawaChild group(const std::vector<OgawaChild>& children);

    void write(ByteWriter& out, OgawaChild root) const;

private:
    struct Block {
        std::uint64_t size;  ///< as the file states it: of children in a group, of bytes in data
        Write write;
    };

    std::vector<Block> blocks_;
    std::uint64_t end_ = 16;  // of the file so far
};

/// Reads any part of a file. No position or size in it is trusted: an allocation is at most as large as the file, a
/// group that is a part of itself is an error, and what is read in total is limited to a multiple of the file's size,
/// so that a small file cannot ask for much work by naming the same bytes again and again.
class OgawaReader {
public:
    /// Reads the bytes at a position, which are inside the file.
    using Source = std::function<void(std::uint64_t at, std::span<std::byte> to)>;

    /// errors  a file that does not begin as an Ogawa file, or is not complete
    OgawaReader(Source source, std::uint64_t size, std::string file);

    OgawaChild root() const { return root_; }
    /// The children of a group. Every group can be read once.
    ///
    /// errors  a reference to data, or outside of the file; a group that was read before
    std::vector<OgawaChild> group(OgawaChild child, const char* what);
    /// Number of bytes of data.
    std::uint64_t dataSize(OgawaChild child, const char* what);
    /// Bytes of data, without the first `skip`; none if there are fewer.
    Bytes data(OgawaChild child, const char* what, std::uint64_t skip = 0);

    [[noreturn]] void fail(std::uint64_t at, const std::string& text) const;

private:
    std::uint64_t numberAt(std::uint64_t at, const char* what);
    void read(std::uint64_t at, std::span<std::byte> to, const char* what);

    Source source_;
    std::uint64_t size_;
    std::string file_;
    std::uint64_t left_to_read_;
    std::set<OgawaChild> groups_read_;
    OgawaChild root_ = kEmptyGroup;
};

}  // namespace betamesh
