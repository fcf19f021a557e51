#include "io/ogawa.h"

#include <limits>
#include <utility>

namespace betamesh {

namespace {

constexpr std::string_view kMagic = "Ogawa";
constexpr std::uint64_t kHeaderBytes = 16;

}  // namespace

OgawaChild OgawaWriter::data(std::uint64_t size, Write write) {
    if (size == 0) return kEmptyData;
    blocks_.push_back({size, std::move(write)});
    return std::exchange(end_, end_ + sizeof(std::uint64_t) + size) | kOgawaDataBit;
}

OgawaChild OgawaWriter::data(std::string bytes) {
    const std::size_t size = bytes.size();
    return data(size, [bytes = std::move(bytes)](ByteWriter& out) { out.text(bytes); });
}

OgawaChild OgawaWriter::group(const std::vector<OgawaChild>& children) {
    if (children.empty()) return kEmptyGroup;
    blocks_.push_back({children.size(), [children](ByteWriter& out) {
                           for (const OgawaChild child : children) out.little(child);
                       }});
    return std::exchange(end_, end_ + sizeof(std::uint64_t) * (1 + children.size()));
}

void OgawaWriter::write(ByteWriter& out, OgawaChild root) const {
    using namespace std::string_view_literals;
    out.text(kMagic);
    out.text("\xff\0\1"sv);
    out.little(root);
    for (const Block& block : blocks_) {
        out.little(block.size);
        block.write(out);
    }
    out.flush();
}

OgawaReader::OgawaReader(Source source, std::uint64_t size, std::string file)
    : source_(std::move(source)), size_(size), file_(std::move(file)) {
    // Alembic stores equal arrays once, such as the zeros of several attributes.
    constexpr std::uint64_t kBytesPerByte = 64, kMinBytes = std::uint64_t{1} << 20;
    left_to_read_ = size > std::numeric_limits<std::uint64_t>::max() / kBytesPerByte
                        ? size
                        : std::max(kMinBytes, kBytesPerByte * size);
    std::array<std::byte, kHeaderBytes> header;
    if (size < kHeaderBytes) fail(0, "the file is too short for Alembic. It is truncated.");
    read(0, header, "header");
    const std::string_view text(reinterpret_cast<const char*>(header.data()), header.size());
    if (!text.starts_with(kMagic)) fail(0, "not an Alembic file in the Ogawa container");
    if (text[5] != '\xff')
        fail(5,
             "the file is not complete: the program that wrote it was interrupted or has not finished. Write it "
             "again.");
    if (text[6] != 0 || text[7] != 1)
        fail(6, "version " + std::to_string(std::to_integer<int>(header[6]) << 8 | std::to_integer<int>(header[7])) +
                    " of the Ogawa container is unknown. 1 was expected.");
    root_ = loadLittle<std::uint64_t>(header.data() + 8);
}

std::vector<OgawaChild> OgawaReader::group(OgawaChild child, const char* what) {
    if (child == kEmptyGroup) return {};
    if ((child & kOgawaDataBit) != 0) fail(child & ~kOgawaDataBit, std::string(what) + ": a group was expected");
    if (!groups_read_.insert(child).second)
        fail(child, std::string(what) + ": a group is used twice. The file is damaged.");
    const std::uint64_t count = numberAt(child, what);
    const std::uint64_t begin = child + sizeof(std::uint64_t);
    if (count > (size_ - begin) / sizeof(OgawaChild))
        fail(child, std::string(what) + ": a group of " + std::to_string(count) + " children exceeds the file. It is " +
                        "truncated or damaged.");
    std::vector<OgawaChild> children(count);
    read(begin, std::as_writable_bytes(std::span(children)), what);
    if constexpr (std::endian::native != std::endian::little)
        for (OgawaChild& c : children) c = withBytesReversed(c);
    return children;
}

std::uint64_t OgawaReader::dataSize(OgawaChild child, const char* what) {
    if (child == kEmptyData) return 0;
    const std::uint64_t at = child & ~kOgawaDataBit;
    if (at == child) fail(at, std::string(what) + ": data were expected");
    const std::uint64_t size = numberAt(at, what);
    if (size > size_ - at - sizeof(std::uint64_t))
        fail(at,
             std::string(what) + ": " + std::to_string(size) + " bytes exceed the file. It is truncated or damaged.");
    return size;
}

Bytes OgawaReader::data(OgawaChild child, const char* what, std::uint64_t skip) {
    const std::uint64_t size = dataSize(child, what);
    Bytes bytes(size > skip ? size - skip : 0);
    if (!bytes.empty()) read((child & ~kOgawaDataBit) + sizeof(std::uint64_t) + skip, bytes, what);
    return bytes;
}

void OgawaReader::fail(std::uint64_t at, const std::string& text) const {
    throw Error(file_ + ": byte " + std::to_string(at) + ": " + text);
}

std::uint64_t OgawaReader::numberAt(std::uint64_t at, const char* what) {
    std::array<std::byte, sizeof(std::uint64_t)> bytes;
    read(at, bytes, what);
    return loadLittle<std::uint64_t>(bytes.data());
}

void OgawaReader::read(std::uint64_t at, std::span<std::byte> to, const char* what) {
    if (at > size_ || to.size() > size_ - at)
        fail(at, std::string(what) + " would lie outside of the file. It is truncated or damaged.");
    if (to.size() > left_to_read_)
        fail(at, std::string(what) + ": the parts of the file overlap so much that it must be damaged");
    left_to_read_ -= to.size();
    source_(at, to);
}

}  // namespace betamesh
