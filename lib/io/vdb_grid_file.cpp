#include "io/vdb_grid_file.h"

#include "betamesh/error.h"
#include "io/bytes.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace betamesh {

namespace {

std::uint32_t readNumber(Cursor& in, const char* what) { return takeLittle<std::uint32_t>(in, what); }

/// Skips a string: its length and characters.
void skipString(Cursor& in, const char* what) { in.take(readNumber(in, what), what); }

/// Skips metadata: a number of entries, each with name, type and value.
void skipMetadata(Cursor& in) {
    for (std::uint32_t left = readNumber(in, "metadata"); left > 0; --left)
        for (int text = 0; text < 3; ++text) skipString(in, "metadata");
}

/// Throws Error if the file ends before the end of its last grid, or inside a string. OpenVDB itself does not check
/// this: it reads on, allocates gigabytes and may terminate the process. Files truncated by a full disk or a killed
/// simulation are common.
///
/// source  OpenVDB, io/Archive.cc and io/GridDescriptor.cc. Layout, little-endian: magic (8 bytes), file version and
///         library version (2 times 4), flag for grid offsets (1), UUID (36), metadata, int32 number of grids. For
///         each grid: name, type, parent, and the offsets of its header, its blocks and its end from the start of the
///         file. Grid header: compression (4), metadata, type of the transform.
void requireComplete(const std::string& path) {
    constexpr std::size_t kBlock = std::size_t{1} << 20;  // larger than any sequence of names and metadata
    constexpr std::uint32_t kOldestVersion = 222;
    if (const std::string why = whyNotRegular(path); !why.empty()) throw Error(why);
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    if (!stream) throw FileError("cannot be read: " + std::generic_category().message(errno), errno);
    const auto size = static_cast<std::int64_t>(stream.tellg());
    const auto blockAt = [&](std::int64_t at) {
        Bytes bytes(static_cast<std::size_t>(std::min<std::int64_t>(kBlock, size - at)));
        stream.seekg(at);
        stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!stream) throw Error("cannot be read");
        return bytes;
    };
    Bytes block = blockAt(0);
    Cursor in(block, "file header");
    if (takeLittle<std::int64_t>(in, "magic") != openvdb::OPENVDB_MAGIC)
        throw Error("not an OpenVDB file: the magic number is missing");
    if (readNumber(in, "version") < kOldestVersion) return;
    in.take(8, "library version");
    if (*in.take(1, "flags") == std::byte{0}) return;  // written to a stream: there are no grid offsets
    in.take(36, "UUID");
    skipMetadata(in);
    const std::uint32_t grids = readNumber(in, "number of grids");
    std::int64_t at = static_cast<std::int64_t>(in.offset());
    for (std::uint32_t i = 0; i < grids; ++i) {
        block = blockAt(at);
        Cursor descriptor(block, "grid " + std::to_string(i));
        for (int text = 0; text < 3; ++text) skipString(descriptor, "names");
        const auto position = [&](const char* what, std::int64_t min) {
            const auto offset = takeLittle<std::int64_t>(descriptor, what);
            if (offset < min || offset > size)
                throw Error("grid " + std::to_string(i) + ": " + what + " should be at byte " + std::to_string(offset) +
                            ", but the file has " + std::to_string(size) + " bytes. It is truncated or damaged.");
            return offset;
        };
        const std::int64_t header = position("header", at);
        position("blocks", 0);  // 0 for a grid that shares the tree of another grid
        at = position("end", header);
        const Bytes header_block = blockAt(header);
        Cursor in_header(header_block, "header of grid " + std::to_string(i));
        in_header.take(4, "compression");
        skipMetadata(in_header);
        skipString(in_header, "transform");
    }
}

/// The path, if the file is complete.
const std::string& checked(const std::string& path) {
    requireComplete(path);
    return path;
}

}  // namespace

GridFile::GridFile(const std::string& path) : stream_(checked(path), std::ios::binary) {
    stream_.exceptions(std::ios::failbit | std::ios::badbit);
    stream_state_->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(stream_, stream_state_, /*transfer=*/false);
    readHeader(stream_);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    openvdb::MetaMap().readMeta(stream_);
    for (std::int32_t left = readGridCount(stream_); left > 0; --left) {
        Descriptor descriptor;
        descriptor.read(stream_);
        if (inputHasGridOffsets())
            descriptor.seekToEnd(stream_);
        else  // the grid itself follows, and tells its end in no other way
            loaded_[descriptor.uniqueName()] = readHere(descriptor);
        descriptors_.emplace(descriptor.gridName(), descriptor);
    }
}

openvdb::GridBase::Ptr GridFile::read(const Descriptor& descriptor) {
    const openvdb::GridBase::Ptr grid = readTree(descriptor);
    if (!descriptor.isInstance()) return grid;
    for (const auto& [name, parent] : descriptors_)
        if (parent.uniqueName() == descriptor.instanceParentName()) {
            grid->setTree(readTree(parent)->baseTreePtr());
            return grid;
        }
    throw Error("grid '" + descriptor.gridName() + "' shares the tree of a grid that is missing");
}

openvdb::GridBase::Ptr GridFile::readTree(const Descriptor& descriptor) {
    if (!inputHasGridOffsets()) return loaded_.at(descriptor.uniqueName());
    descriptor.seekToGrid(stream_);
    return readHere(descriptor);
}

openvdb::GridBase::Ptr GridFile::readHere(const Descriptor& descriptor) {
    const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(descriptor.gridType());
    grid->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
    readGrid(grid, descriptor, stream_);
    return grid;
}

}  // namespace betamesh
