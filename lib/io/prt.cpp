#include "io/prt.h"

#include "base/lower_case.h"
#include "io/gzip.h"
#include "io/number_columns.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace betamesh {

namespace {

constexpr std::string_view kMagic = "\xc0PRT\r\n\x1a\n", kSuccessor = "\xc0PRT2\r\n\x1a";
constexpr std::uint32_t kMostChannels = 1000, kMostArity = 1000;
constexpr std::uint64_t kMostPacked = 1100;  // bytes that zlib makes of one, at most about 1,032
constexpr std::size_t kHeader = 56, kLongestName = 32;

// Numbers of types in the file, in their order; 3 is a half float.
constexpr std::array<NumberType, 11> kTypes{NumberType::int16,   NumberType::int32,   NumberType::int64,
                                            NumberType::float32, NumberType::float32, NumberType::float64,
                                            NumberType::uint16,  NumberType::uint32,  NumberType::uint64,
                                            NumberType::int8,    NumberType::uint8};
constexpr std::array<const char*, 11> kTypeNames{"int16",  "int32",  "int64",  "float16", "float32", "float64",
                                                 "uint16", "uint32", "uint64", "int8",    "uint8"};
constexpr std::uint32_t kHalf = 3;

struct Channel {
    std::string name;
    std::uint32_t type = 0, arity = 0, offset = 0;

    std::size_t numberBytes() const { return type == kHalf ? 2 : bytesOf(kTypes[type]); }
    std::size_t bytes() const { return arity * numberBytes(); }
};

float fromHalf(std::uint16_t bits) {
    const std::uint32_t sign = static_cast<std::uint32_t>(bits & 0x8000u) << 16, exponent = bits >> 10 & 0x1fu,
                        mantissa = bits & 0x3ffu;
    if (exponent == 0) {  // zero, or below the normal numbers
        const float value = static_cast<float>(mantissa) * 0x1p-24F;
        return sign != 0 ? -value : value;
    }
    const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
    return std::bit_cast<float>(sign | wide << 23 | mantissa << 13);
}

Channel readChannel(Cursor& in, std::uint32_t definition_bytes, std::size_t number) {
    const std::byte* from = in.take(definition_bytes, "a channel");
    Channel channel;
    channel.name.assign(reinterpret_cast<const char*>(from), kLongestName);
    channel.name.resize(std::min(channel.name.find('\0'), kLongestName));
    if (channel.name.empty()) channel.name = "channel" + std::to_string(number);
    channel.type = loadLittle<std::uint32_t>(from + kLongestName);
    channel.arity = loadLittle<std::uint32_t>(from + kLongestName + 4);
    channel.offset = loadLittle<std::uint32_t>(from + kLongestName + 8);
    if (channel.type >= kTypes.size())
        in.fail("channel '" + channel.name + "' has type " + std::to_string(channel.type) + ", expected 0 to 10");
    if (channel.arity == 0 || channel.arity > kMostArity)
        in.fail("channel '" + channel.name + "' has " + std::to_string(channel.arity) + " numbers, expected 1 to " +
                std::to_string(kMostArity));
    return channel;
}

NumberColumn columnOf(const Channel& channel, const std::byte* rows, std::size_t count, std::size_t row_bytes) {
    NumberColumn column;
    for (std::size_t i = 0; i < count; ++i) {
        const std::byte* from = rows + i * row_bytes + channel.offset;
        if (channel.type == kHalf)
            for (std::size_t k = 0; k < channel.arity; ++k)
                column.real.push_back(fromHalf(loadLittle<std::uint16_t>(from + 2 * k)));
        else
            appendNumbers(kTypes[channel.type], from, channel.arity, std::endian::native != std::endian::little,
                          column);
    }
    return column;
}

bool isNamed(const std::string& name, const std::string& wanted) { return lowerCase(name) == lowerCase(wanted); }

/// The name under which a channel is read.
std::string nameOf(const Channel& channel, const ReadOptions& options) {
    if (isNamed(channel.name, "Position")) return "P";
    if (!options.id.empty() && isNamed(channel.name, options.id)) return options.id;
    return isNamed(channel.name, "Velocity") ? "velocity" : channel.name;
}

FileContents pointsFrom(const std::vector<Channel>& channels, const std::byte* rows, std::size_t count,
                        std::size_t row_bytes, const ReadOptions& options, const std::string& file) {
    FileContents points;
    for (const Channel& channel : channels)
        if (isNamed(channel.name, "Position")) {
            points.position = positionsFrom(columnOf(channel, rows, count, row_bytes), 3, options.origin);
            points.has_double_positions = channel.type != kHalf && kTypes[channel.type] == NumberType::float64;
        }
    for (const Channel& channel : channels) {
        const std::string name = nameOf(channel, options);
        if (name == "P" || (!options.attributes && name != options.id)) continue;
        addColumn(name, channel.arity, columnOf(channel, rows, count, row_bytes), count, options, file, points);
    }
    return points;
}

/// Declares the channels; throws Error unless one of them is the position.
void declare(const std::vector<Channel>& channels, const ReadOptions& options, const Cursor& in,
             FileContents& contents) {
    bool has_position = false;
    for (const Channel& channel : channels) {
        has_position |= isNamed(channel.name, "Position") && channel.arity == 3;
        contents.declared.push_back({nameOf(channel, options), kTypeNames[channel.type], channel.arity, ""});
    }
    if (!has_position) in.fail("has no channel Position of three numbers");
}

/// PRT2. A file is the magic, a version and chunks: four letters, the length (u64) and the data. Texts begin with their
/// length (u8).
///   Chan  u8 channels; of each its name, its type as in "3 * float32" and its bytes (u8)
///   Part  name, filter, u64 particles, u64 blocks; of each block u32 bytes, u32 particles and the bytes. The filter
///         transpose-zlib: a zlib stream of the first bytes of all particles, then of the second bytes, and so on
/// Other chunks are metadata and an index.
class ChunkReader {
public:
    ChunkReader(Cursor& in, const ReadOptions& options) : in_(in), options_(options) {}

    FileContents read() {
        in_.take(kSuccessor.size(), "magic");
        contents_.format = "prt2 version " + std::to_string(takeLittle<std::uint32_t>(in_, "version"));
        bool has_particles = false;
        while (!in_.peek(1).empty()) {
            const std::string kind(reinterpret_cast<const char*>(in_.take(4, "a chunk")), 4);
            const auto length = takeLittle<std::uint64_t>(in_, "length of a chunk");
            in_.requireRows(length, 1, "a chunk");
            const std::uint64_t end = in_.offset() + length;
            if (kind == "Chan") readChannels();
            if (kind == "Part") readParticles();
            has_particles |= kind == "Part";
            if (in_.offset() > end)
                in_.fail("chunk " + kind + " is longer than the " + std::to_string(length) + " bytes that it declares");
            in_.skip(end - in_.offset(), "a chunk");
        }
        if (!has_particles) in_.fail("has no particles (chunk Part)");
        return std::move(contents_);
    }

private:
    std::size_t smallNumber(const char* what) {
        const auto number = static_cast<std::size_t>(*in_.take(1, what));
        if (number > 127) in_.fail(std::string(what) + " is " + std::to_string(number) + ", expected at most 127");
        return number;
    }
    std::string text(const char* what) {
        const std::size_t size = smallNumber(what);
        return {reinterpret_cast<const char*>(in_.take(size, what)), size};
    }

    void readChannels() {
        if (!channels_.empty()) in_.fail("chunk Chan is there twice");
        for (std::size_t count = smallNumber("number of channels"); count > 0; --count) {
            Channel channel;
            channel.name = text("name of a channel");
            if (channel.name.empty()) channel.name = "channel" + std::to_string(channels_.size());
            const std::string type = text("type of a channel");
            std::string_view number = type;
            const auto arity = nextInteger(number);
            channel.arity = static_cast<std::uint32_t>(std::clamp<std::int64_t>(arity.value_or(1), 0, kMostArity));
            if (arity) number.remove_prefix(std::min(number.size(), std::string_view(" * ").size()));
            const auto found = std::find(kTypeNames.begin(), kTypeNames.end(), number);
            if (found == kTypeNames.end() || channel.arity == 0)
                in_.fail("channel '" + channel.name + "' has type '" + type +
                         "', expected float32, 3 * float32 or alike");
            channel.type = static_cast<std::uint32_t>(found - kTypeNames.begin());
            channel.offset = static_cast<std::uint32_t>(row_bytes_);
            if (smallNumber("bytes of a channel") != channel.bytes())
                in_.fail("channel '" + channel.name + "' of type '" + type + "' does not have the bytes of that type");
            row_bytes_ += channel.bytes();
            channels_.push_back(channel);
        }
        declare(channels_, options_, in_, contents_);
    }

    void readParticles() {
        if (channels_.empty()) in_.fail("expected chunk Chan before chunk Part");
        text("name of the particles");
        const std::string filter = text("filter");
        if (filter != "transpose-zlib")
            in_.fail("particles are stored by the filter '" + filter + "', expected transpose-zlib");
        const auto total = takeLittle<std::uint64_t>(in_, "number of particles");
        std::uint64_t left = total;
        for (auto blocks = takeLittle<std::uint64_t>(in_, "number of blocks"); blocks > 0; --blocks) {
            const auto size = takeLittle<std::uint32_t>(in_, "length of a block"),
                       count = takeLittle<std::uint32_t>(in_, "particles of a block");
            const std::uint64_t bytes = std::uint64_t{count} * row_bytes_;
            if (count > left || bytes > kMostPacked * (std::uint64_t{size} + 1))
                in_.fail("a block of " + std::to_string(size) + " bytes claims to hold " + std::to_string(count) +
                         " particles");
            left -= count;
            const Bytes rows = unpackedRows(std::span(in_.take(size, "a block"), size), count);
            deliver(pointsFrom(channels_, rows.data(), count, row_bytes_, options_, in_.file()), total, options_,
                    contents_);
        }
        if (left != 0) in_.fail(std::to_string(total - left) + " particles, expected " + std::to_string(total));
    }

    Bytes unpackedRows(std::span<const std::byte> packed, std::size_t count) const {
        Bytes columns(count * row_bytes_), rows(columns.size());
        if (!inflateBlock(packed, columns)) in_.fail("a block cannot be decompressed by zlib");
        for (std::size_t byte = 0; byte < row_bytes_; ++byte)
            for (std::size_t i = 0; i < count; ++i) rows[i * row_bytes_ + byte] = columns[byte * count + i];
        return rows;
    }

    Cursor& in_;
    const ReadOptions& options_;
    FileContents contents_;
    std::vector<Channel> channels_;
    std::size_t row_bytes_ = 0;
};

}  // namespace

FileContents parsePrt(Cursor in, const ReadOptions& options) {
    if (in.peek(kSuccessor.size()).starts_with(kSuccessor)) return ChunkReader(in, options).read();
    if (!in.peek(kMagic.size()).starts_with(kMagic)) in.fail("expected a PRT file, which begins with the bytes c0 PRT");
    in.take(kMagic.size(), "magic");
    const auto header_bytes = takeLittle<std::uint32_t>(in, "header length");
    in.take(kLongestName, "signature");
    const auto version = takeLittle<std::uint32_t>(in, "version");
    const auto count = takeLittle<std::int64_t>(in, "number of particles");
    if (header_bytes < kHeader)
        in.fail("the header has " + std::to_string(header_bytes) + " bytes, expected 56 or more");
    if (count < 0) in.fail("the number of particles is " + std::to_string(count) + ": the file was not finished");
    in.skip(header_bytes - kHeader, "metadata");
    takeLittle<std::uint32_t>(in, "a reserved number");
    const auto channel_count = takeLittle<std::uint32_t>(in, "number of channels"),
               definition_bytes = takeLittle<std::uint32_t>(in, "length of a channel's definition");
    if (channel_count > kMostChannels || definition_bytes < kLongestName + 12)
        in.fail(std::to_string(channel_count) + " channels of " + std::to_string(definition_bytes) +
                " bytes, expected at most " + std::to_string(kMostChannels) + " of 44 or more");
    FileContents contents;
    contents.format = "prt version " + std::to_string(version);
    std::vector<Channel> channels;
    std::size_t row_bytes = 0;
    for (std::uint32_t c = 0; c < channel_count; ++c) {
        channels.push_back(readChannel(in, definition_bytes, c));
        row_bytes += channels.back().bytes();
    }
    for (const Channel& channel : channels)
        if (channel.offset > row_bytes || channel.bytes() > row_bytes - channel.offset)
            in.fail("channel '" + channel.name + "' begins at byte " + std::to_string(channel.offset) +
                    " of particles that have " + std::to_string(row_bytes));
    declare(channels, options, in, contents);
    if (static_cast<std::uint64_t>(count) > kMostPacked * (in.remaining() + 1) / row_bytes)
        in.fail(std::to_string(count) + " particles of " + std::to_string(row_bytes) +
                " bytes are more than the rest of the file can hold. It is truncated or damaged.");
    const std::string file = in.file();
    Cursor rows = inflatedZlib(std::move(in));
    deliverRows(
        rows, static_cast<std::uint64_t>(count), row_bytes,
        [&](const std::byte* first, std::size_t some) {
            return pointsFrom(channels, first, some, row_bytes, options, file);
        },
        options, contents);
    return contents;
}

}  // namespace betamesh
