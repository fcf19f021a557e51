
#include "io/gzip.h"

#include "base/parallel.h"

#include <zlib.h>

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

namespace betamesh {

namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 18;
constexpr int kWindowBits = 15;                                             // the maximum
constexpr int kGzipWindow = kWindowBits + 16;                               // zlib expects a gzip header if 16 is added
constexpr std::uint64_t kMaxUnconditionalBytes = std::uint64_t{256} << 20;  // allowed whatever the compressed size
constexpr std::uint64_t kMaxRatio = 100;                                    // decompressed to compressed size

constexpr std::size_t kWindow = std::size_t{1} << kWindowBits;
constexpr std::size_t kBlock = std::size_t{1} << 20, kBlocksAtOnce = 16;
constexpr int kMemoryLevel = 9;  // the maximum; makes meshes 1 % smaller than the default

class Inflater {
public:
    Inflater(Cursor packed, int window_bits)
        : in_(std::move(packed)), packed_bytes_(in_.remaining()), limit_(maxBytes(in_)) {
        if (inflateInit2(&stream_, window_bits) != Z_OK) throw std::bad_alloc();
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    static std::uint64_t maxBytes(const Cursor& packed) {
        return std::max(kMaxUnconditionalBytes, packed.remaining() * kMaxRatio);
    }

    std::size_t read(std::byte* to, std::size_t count) {
        std::size_t produced = 0;
        while (produced == 0 && !ended_) {
            feed();
            stream_.next_out = reinterpret_cast<Bytef*>(to);
            stream_.avail_out = static_cast<uInt>(std::min(count, kReadBytes));
            const uInt capacity = stream_.avail_out;
            const int status = inflate(&stream_, Z_NO_FLUSH);
            produced = capacity - stream_.avail_out;
            if (status == Z_STREAM_END)
                endMember();
            else if (status != Z_OK)
                fail(status == Z_BUF_ERROR
                         ? "truncated"
                         : std::string("damaged (") + (stream_.msg != nullptr ? stream_.msg : "unknown") + ")");
        }
        produced_ += produced;
        if (produced_ > limit_)
            throw Error(in_.file() + ": " + std::to_string(packed_bytes_) + " bytes of gzip decompress to more than " +
                        std::to_string(limit_) +
                        " bytes, which is unusual for geometry. Decompress the file with gunzip if this is intended.");
        return produced;
    }

private:
    /// Refills zlib's input if it is empty.
    void feed() {
        if (stream_.avail_in > 0) return;
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kReadBytes, in_.remaining()));
        stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(in_.take(count, "gzip")));
        stream_.avail_in = static_cast<uInt>(count);
    }
    /// Continues with the next member if another gzip header follows; ignores other trailing bytes.
    void endMember() {
        feed();
        ended_ = true;
        if (stream_.avail_in == 0 || *stream_.next_in != 0x1f) return;
        if (stream_.avail_in == 1) {  // the second byte of the magic number is not in memory yet
            last_ = *std::exchange(stream_.next_in, &last_);
            ended_ = !in_.peek(1).starts_with('\x8b');
        } else {
            ended_ = stream_.next_in[1] != 0x8b;
        }
        if (!ended_) inflateReset(&stream_);
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(in_.file() + ": the gzip stream is " + what + " near byte " +
                    std::to_string(in_.offset() - stream_.avail_in));
    }

    Cursor in_;
    z_stream stream_ = {};
    std::uint64_t packed_bytes_, limit_, produced_ = 0;
    bool ended_ = false;
    Bytef last_ = 0;
};

/// window_bits: as inflateInit2 takes them.
Cursor inflated(Cursor packed, int window_bits) {
    const std::string file = packed.file();
    const std::uint64_t limit = Inflater::maxBytes(packed);
    const auto inflater = std::make_shared<Inflater>(std::move(packed), window_bits);
    return {[inflater](std::byte* to, std::size_t count) { return inflater->read(to, count); }, limit, file};
}

Bytef* mutableBytes(std::span<const std::byte> bytes) {
    return const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
}

// A block compressed by deflate, padded to whole bytes so that blocks can be concatenated.
Bytes compressedBlock(std::span<const std::byte> block, std::span<const std::byte> dictionary) {
    z_stream stream = {};
    // The default level makes meshes about 5 % smaller and takes three times as long.
    if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, -kWindowBits, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    if (!dictionary.empty())
        deflateSetDictionary(&stream, mutableBytes(dictionary), static_cast<uInt>(dictionary.size()));
    constexpr std::size_t kFlush = 16;
    Bytes packed(deflateBound(&stream, static_cast<uLong>(block.size())) + kFlush);
    stream.next_in = mutableBytes(block);
    stream.avail_in = static_cast<uInt>(block.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_SYNC_FLUSH);
    packed.resize(packed.size() - stream.avail_out);
    deflateEnd(&stream);
    return packed;
}

std::uint32_t checksumOf(std::span<const std::byte> bytes) {
    return static_cast<std::uint32_t>(crc32(0, mutableBytes(bytes), static_cast<uInt>(bytes.size())));
}

}  // namespace

bool isGzip(Cursor& in) { return in.peek(2).starts_with("\x1f\x8b"); }

Cursor gunzipped(Cursor packed) { return inflated(std::move(packed), kGzipWindow); }

Cursor inflatedZlib(Cursor packed) { return inflated(std::move(packed), kWindowBits); }

bool inflateBlock(std::span<const std::byte> packed, std::span<std::byte> block) {
    auto size = static_cast<uLongf>(block.size());
    return uncompress(reinterpret_cast<Bytef*>(block.data()), &size, reinterpret_cast<const Bytef*>(packed.data()),
                      static_cast<uLong>(packed.size())) == Z_OK &&
           size == block.size();
}

GzipWriter::GzipWriter(Sink sink) : sink_(std::move(sink)), checksum_(checksumOf({})) {
    constexpr std::array<std::uint8_t, 10> kHeader{0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3};  // deflate, made on Unix
    sink_(std::as_bytes(std::span(kHeader)));
}

void GzipWriter::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const std::size_t count = std::min(bytes.size(), kBlock * kBlocksAtOnce - pending_.size());
        pending_.insert(pending_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
        bytes = bytes.subspan(count);
        if (pending_.size() == kBlock * kBlocksAtOnce) compressPending();
    }
}

void GzipWriter::compressPending() {
    const std::span<const std::byte> all(pending_);
    std::vector<Bytes> packed((all.size() + kBlock - 1) / kBlock);
    std::vector<std::uint32_t> checksum(packed.size());
    const auto block = [&](std::size_t b) {
        return all.subspan(b * kBlock, std::min(kBlock, all.size() - b * kBlock));
    };
    parallelFor(packed.size(), 1, [&](std::size_t b) {
        packed[b] =
            compressedBlock(block(b), b > 0 ? block(b - 1).last(kWindow) : std::span(std::as_const(dictionary_)));
        checksum[b] = checksumOf(block(b));
    });
    for (std::size_t b = 0; b < packed.size(); ++b) {
        sink_(packed[b]);
        const auto length = static_cast<z_off_t>(block(b).size());
        checksum_ = static_cast<std::uint32_t>(crc32_combine(checksum_, checksum[b], length));
    }
    size_ += static_cast<std::uint32_t>(all.size());
    const auto end = all.last(std::min(kWindow, all.size()));
    dictionary_.assign(end.begin(), end.end());
    pending_.clear();
}

void GzipWriter::finish() {
    compressPending();
    ByteWriter end(sink_);
    end.little(std::uint16_t{3});  // an empty final block
    end.little(checksum_);
    end.little(size_);
    end.flush();
}

}  // namespace betamesh
