#include "io/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <new>

namespace betamesh {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
constexpr int kGzipWindow = 15 + 16;  // the largest window; + 16: gzip, not zlib
constexpr std::size_t kAlwaysAllowed = std::size_t{256} << 20;
constexpr std::size_t kMaxGrowth = 100;

// zlib counts in 32 bits; larger input is fed piece by piece.
void feed(z_stream& stream, std::span<const std::byte> bytes, std::size_t& fed) {
    if (stream.avail_in > 0 || fed == bytes.size()) return;
    const std::size_t count = std::min(kPiece, bytes.size() - fed);
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data() + fed));
    stream.avail_in = static_cast<uInt>(count);
    fed += count;
}

struct Inflater {
    z_stream stream = {};
    Inflater() {
        if (inflateInit2(&stream, kGzipWindow) != Z_OK) throw std::bad_alloc();
    }
    ~Inflater() { inflateEnd(&stream); }
};

struct Deflater {
    z_stream stream = {};
    Deflater() {
        if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
    }
    ~Deflater() { deflateEnd(&stream); }
};

}  // namespace

bool isGzip(std::span<const std::byte> bytes) {
    return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

Bytes gunzip(std::span<const std::byte> bytes, const std::string& file) {
    const std::size_t limit = std::max(kAlwaysAllowed, bytes.size() * kMaxGrowth);
    Inflater inflater;
    z_stream& stream = inflater.stream;
    Bytes out;
    out.reserve(bytes.size() * 4);
    Bytes piece(kPiece);
    std::size_t fed = 0;
    for (;;) {
        feed(stream, bytes, fed);
        stream.next_out = reinterpret_cast<Bytef*>(piece.data());
        stream.avail_out = static_cast<uInt>(piece.size());
        const int status = inflate(&stream, Z_NO_FLUSH);
        const std::size_t made = piece.size() - stream.avail_out;
        if (made > limit - out.size())
            throw Error(file + ": " + std::to_string(bytes.size()) + " gzip bytes unpack to more than " +
                        std::to_string(limit) + ", expected particles; unpack it with gunzip if it is meant so");
        out.insert(out.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(made));
        if (status == Z_STREAM_END) {
            feed(stream, bytes, fed);
            const bool more = stream.avail_in > 1 && stream.next_in[0] == 0x1f && stream.next_in[1] == 0x8b;
            if (!more) return out;
            inflateReset(&stream);
        } else if (status != Z_OK) {
            const bool ended = status == Z_BUF_ERROR;
            throw Error(file + ": gzip stream is " +
                        (ended ? std::string("truncated")
                               : std::string("damaged (") + (stream.msg != nullptr ? stream.msg : "?") + ")") +
                        " near byte " + std::to_string(fed - stream.avail_in));
        }
    }
}

Bytes gzip(std::span<const std::byte> bytes) {
    Deflater deflater;
    z_stream& stream = deflater.stream;
    Bytes out;
    Bytes piece(kPiece);
    std::size_t fed = 0;
    int status = Z_OK;
    while (status != Z_STREAM_END) {
        feed(stream, bytes, fed);
        stream.next_out = reinterpret_cast<Bytef*>(piece.data());
        stream.avail_out = static_cast<uInt>(piece.size());
        status = deflate(&stream, fed == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
        const std::size_t made = piece.size() - stream.avail_out;
        out.insert(out.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(made));
    }
    return out;
}

}  // namespace betamesh
