#include "io/houdini_scf.h"

#include "base/parallel.h"

#include <blosc.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace betamesh {

namespace {

// source  files of Houdini 17.5, and the header of a block from Blosc's README_CHUNK_FORMAT. Numbers are big-endian,
//         but for those in the header of a block.
//   begin   "scf1", uint64 bytes of metadata, metadata
//   blocks  chunks of Blosc 1, one after the other; all but the last have the same size when unpacked
//   table   uint64 each: offsets of the blocks from the second on, counted from the first; the size of a block; the
//           size of the last one
//   end     uint64 bytes of the table, "1fcs"
// A chunk begins with its version, which is not zero. The table begins with zero: offsets are below 2^56.
constexpr std::string_view kBegin = "scf1", kEnd = "1fcs";
constexpr std::size_t kBlock = std::size_t{1} << 20;
constexpr std::size_t kBlocksAtOnce = 16;

constexpr std::size_t kHeader = BLOSC_MIN_HEADER_LENGTH;
constexpr std::size_t kSizeAt = 4, kPackedSizeAt = 12;  // in the header of a block: uint32, little-endian
constexpr int kLevel = 9, kShuffle = BLOSC_SHUFFLE, kTypeSize = 4;

constexpr std::uint64_t kMaxGrowth = 256;  // LZ4 and BloscLZ, which Houdini uses, stay below
constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{256} << 20;

class Unpacker {
public:
    explicit Unpacker(Cursor packed) : in_(std::move(packed)), limit_(limitOf(in_)) {
        in_.take(kBegin.size(), "magic");
        in_.skip(in_.big<std::uint64_t>("size of the metadata"), "metadata");
        first_block_ = in_.offset();
    }

    static std::uint64_t limitOf(const Cursor& packed) {
        return std::max(kAlwaysAllowed, packed.remaining() * kMaxGrowth);
    }

    std::size_t read(std::byte* to, std::size_t count) {
        if (at_ == block_.size() && !ended_) unpackNext();
        const std::size_t got = std::min(count, block_.size() - at_);
        std::copy_n(block_.data() + at_, got, to);
        at_ += got;
        return got;
    }

private:
    void unpackNext() {
        block_.clear();
        at_ = 0;
        while (block_.empty() && !ended_) {
            if (in_.peek(1).starts_with('\0'))
                checkTable();
            else
                unpackBlock();
        }
    }

    void unpackBlock() {
        const std::uint64_t begin = in_.offset();
        const std::string_view header = in_.peek(kHeader).substr(0, kHeader);
        if (header.size() < kHeader) in_.fail("the file ends here, expected a block or the table of blocks");
        const auto numberAt = [&](std::size_t at) {
            return loadLittle<std::uint32_t>(reinterpret_cast<const std::byte*>(header.data()) + at);
        };
        const std::size_t size = numberAt(kSizeAt), packed_size = numberAt(kPackedSizeAt);
        if (packed_size < kHeader)
            failBlock(begin, "has " + std::to_string(packed_size) + " bytes, expected 16 or more");
        if (size > BLOSC_MAX_BUFFERSIZE || (size > kBlock && size / kMaxGrowth > packed_size))
            failBlock(begin, "unpacks to " + std::to_string(size) + " bytes from " + std::to_string(packed_size) +
                                 ", expected a block of geometry");
        const std::byte* packed = in_.take(packed_size, "block");
        std::size_t valid_size = 0;
        if (blosc_cbuffer_validate(packed, packed_size, &valid_size) < 0 || valid_size != size)
            failBlock(begin, "is damaged: its header is not one of Blosc");
        made_ += size;
        if (made_ > limit_)
            failBlock(begin, "makes the content larger than " + std::to_string(limit_) + " bytes, expected geometry");
        block_.resize(size);
        if (blosc_decompress_ctx(packed, block_.data(), size, 1) != static_cast<int>(size))
            failBlock(begin, "is damaged: Blosc cannot unpack it");
        if (!offsets_.empty() && last_size_ != block_size_)
            failBlock(begin, "follows one of " + std::to_string(last_size_) + " bytes, expected " +
                                 std::to_string(block_size_) + " in all but the last");
        if (offsets_.empty()) block_size_ = size;
        last_size_ = size;
        offsets_.push_back(begin - first_block_);
    }

    void checkTable() {
        for (std::size_t i = 1; i < offsets_.size(); ++i) expectInTable(offsets_[i], "offset of a block");
        const auto block_size = in_.big<std::uint64_t>("size of a block");
        if (offsets_.size() > 1 && block_size != block_size_) failTable("size of a block", block_size, block_size_);
        expectInTable(last_size_, "size of the last block");
        expectInTable(sizeof(std::uint64_t) * (std::max<std::size_t>(offsets_.size(), 1) + 1), "size of the table");
        if (in_.peek(kEnd.size()).substr(0, kEnd.size()) != kEnd) in_.fail("expected '1fcs' at the end of the file");
        in_.take(kEnd.size(), "end");
        ended_ = true;
    }

    void expectInTable(std::uint64_t expected, const char* what) {
        const auto found = in_.big<std::uint64_t>(what);
        if (found != expected) failTable(what, found, expected);
    }
    [[noreturn]] void failTable(const char* what, std::uint64_t found, std::uint64_t expected) const {
        in_.fail(std::string("the table of blocks has ") + what + " " + std::to_string(found) + ", expected " +
                 std::to_string(expected));
    }
    [[noreturn]] void failBlock(std::uint64_t begin, const std::string& what) const {
        throw Error(in_.file() + ": byte " + std::to_string(begin) + ": block " + std::to_string(offsets_.size()) +
                    " " + what);
    }

    Cursor in_;
    std::uint64_t limit_, made_ = 0;
    std::uint64_t first_block_ = 0;
    Bytes block_;
    std::size_t at_ = 0;  // in block_
    std::vector<std::uint64_t> offsets_;
    std::uint64_t block_size_ = 0, last_size_ = 0;
    bool ended_ = false;
};

Bytes packedBlock(std::span<const std::byte> block) {
    Bytes packed(block.size() + BLOSC_MAX_OVERHEAD);
    const int size = blosc_compress_ctx(kLevel, kShuffle, kTypeSize, block.size(), block.data(), packed.data(),
                                        packed.size(), BLOSC_LZ4_COMPNAME, 0, 1);
    if (size <= 0) throw std::bad_alloc();  // all else that can fail does not depend on the block
    packed.resize(static_cast<std::size_t>(size));
    return packed;
}

}  // namespace

bool isScf(Cursor& in) { return in.peek(kBegin.size()).starts_with(kBegin); }

Cursor scfUnpacked(Cursor packed) {
    const std::string file = packed.file();
    const std::uint64_t limit = Unpacker::limitOf(packed);
    const auto unpacker = std::make_shared<Unpacker>(std::move(packed));
    return {[unpacker](std::byte* to, std::size_t count) { return unpacker->read(to, count); }, limit, file};
}

ScfWriter::ScfWriter(Drain drain) : drain_(std::move(drain)) {
    ByteWriter out(drain_);
    out.text(kBegin);
    out.big(std::uint64_t{0});  // no metadata
    out.flush();
}

void ScfWriter::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const std::size_t count = std::min(bytes.size(), kBlock * kBlocksAtOnce - waiting_.size());
        waiting_.insert(waiting_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
        bytes = bytes.subspan(count);
        if (waiting_.size() == kBlock * kBlocksAtOnce) pack();
    }
}

void ScfWriter::pack() {
    const std::span<const std::byte> all(waiting_);
    std::vector<Bytes> packed((all.size() + kBlock - 1) / kBlock);
    parallelFor(packed.size(), 1, [&](std::size_t b) {
        packed[b] = packedBlock(all.subspan(b * kBlock, std::min(kBlock, all.size() - b * kBlock)));
    });
    for (const Bytes& block : packed) {
        drain_(block);
        ends_.push_back((ends_.empty() ? 0 : ends_.back()) + block.size());
    }
    if (!packed.empty()) last_size_ = all.size() - (packed.size() - 1) * kBlock;
    waiting_.clear();
}

void ScfWriter::finish() {
    pack();
    ByteWriter out(drain_);
    std::uint64_t table_bytes = 2 * sizeof(std::uint64_t);
    for (std::size_t b = 1; b < ends_.size(); ++b, table_bytes += sizeof(std::uint64_t)) out.big(ends_[b - 1]);
    out.big(std::uint64_t{kBlock});
    out.big(last_size_);
    out.big(table_bytes);
    out.text(kEnd);
    out.flush();
}

}  // namespace betamesh
