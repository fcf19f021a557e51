// Reading and writing bytes: a bounds-checked cursor, a buffered writer, whole files.

#pragma once

#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace betamesh {

using Bytes = std::vector<std::byte>;

/// The number with its bytes in reverse order.
template <typename T>
T withBytesReversed(T number) {
    if constexpr (sizeof(T) == 8)
        return std::bit_cast<T>(__builtin_bswap64(std::bit_cast<std::uint64_t>(number)));
    else if constexpr (sizeof(T) == 4)
        return std::bit_cast<T>(__builtin_bswap32(std::bit_cast<std::uint32_t>(number)));
    else if constexpr (sizeof(T) == 2)
        return std::bit_cast<T>(__builtin_bswap16(std::bit_cast<std::uint16_t>(number)));
    else
        return number;
}

/// Loads a number from unaligned memory. swap_bytes: its byte order is not the machine's.
template <typename T>
T loadNumber(const std::byte* from, bool swap_bytes) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), from, sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {  // swapped as an integer, because a float may not preserve every bit
                                                  // pattern
        using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
        const auto bits = std::bit_cast<Bits>(raw);
        return std::bit_cast<T>(swap_bytes ? withBytesReversed(bits) : bits);
    } else {
        const T number = std::bit_cast<T>(raw);
        return swap_bytes ? withBytesReversed(number) : number;
    }
}

template <typename T>
T loadBig(const std::byte* from) {
    return loadNumber<T>(from, std::endian::native == std::endian::little);
}
template <typename T>
T loadLittle(const std::byte* from) {
    return loadNumber<T>(from, std::endian::native != std::endian::little);
}

/// Reads the bytes of one file in order, from memory or from a source that is read on demand. Never reads beyond the
/// end: if a damaged count asks for more, that is an Error with file name and byte offset, before any memory is
/// allocated.
class Cursor {
public:
    /// Writes up to `count` of the next bytes to `to`; returns their number, 0 at the end.
    using Source = std::function<std::size_t(std::byte* to, std::size_t count)>;

    /// Reads bytes in memory, which must outlive the cursor.
    Cursor(std::span<const std::byte> bytes, std::string file)
        : bytes_(bytes), size_(bytes.size()), file_(std::move(file)) {}
    /// size: number of bytes in the source, or an upper limit if that is not known.
    Cursor(Source source, std::uint64_t size, std::string file)
        : source_(std::move(source)), size_(size), file_(std::move(file)) {}
    Cursor(Cursor&&) = default;
    Cursor(const Cursor&) = delete;

    std::uint64_t offset() const { return before_ + at_; }
    std::uint64_t remaining() const { return size_ - offset(); }
    const std::string& file() const { return file_; }

    /// Returns the next `count` bytes and moves past them. They are valid until the next call that reads.
    const std::byte* take(std::size_t count, const char* what) {
        requireRows(1, count, what);
        if (count > bytes_.size() - at_) {
            fetch(count);
            requireRows(1, count, what);
        }
        const std::byte* here = bytes_.data() + at_;
        at_ += count;
        return here;
    }

    template <typename T>
    T big(const char* what) {
        return loadBig<T>(take(sizeof(T), what));
    }

    /// Moves past `count` bytes, however many.
    void skip(std::uint64_t count, const char* what) {
        requireRows(1, count, what);
        constexpr std::uint64_t kPiece = std::uint64_t{1} << 18;
        for (; count > 0; count -= std::min(count, kPiece))
            take(static_cast<std::size_t>(std::min(count, kPiece)), what);
    }

    /// Throws Error unless the rest of the file is long enough for rows of bytes_per_row bytes each.
    void requireRows(std::uint64_t rows, std::uint64_t bytes_per_row, const char* what) const {
        if (bytes_per_row != 0 && rows > remaining() / bytes_per_row) failTruncated(rows, bytes_per_row, what);
    }

    /// At least the next `count` bytes, or all that are left, without moving past them.
    std::string_view peek(std::size_t count) {
        if (count > bytes_.size() - at_) fetch(count);
        return {reinterpret_cast<const char*>(bytes_.data()) + at_, bytes_.size() - at_};
    }

    [[noreturn]] void fail(const std::string& text) const {
        throw Error(file_ + ": byte " + std::to_string(offset()) + ": " + text);
    }

private:
    /// Reads until the next `count` bytes are in memory, or the source ends.
    void fetch(std::size_t count);

    [[noreturn]] void failTruncated(std::uint64_t rows, std::uint64_t bytes_per_row, const char* what) const {
        fail(std::string(what) + ": " + (rows == 1 ? "" : std::to_string(rows) + " times ") +
             std::to_string(bytes_per_row) + " bytes were expected, but the file ends after " +
             std::to_string(remaining()) + ". It is truncated, or a count in it is damaged.");
    }

    Source source_;
    Bytes buffer_;                      // the part of the source that is in memory
    std::span<const std::byte> bytes_;  // the part of the file that is in memory
    std::uint64_t before_ = 0;          // offset of bytes_ in the file
    std::size_t at_ = 0;                // position in bytes_
    std::uint64_t size_;
    std::string file_;
};

/// The next number, little-endian.
template <typename T>
T takeLittle(Cursor& in, const char* what) {
    return loadLittle<T>(in.take(sizeof(T), what));
}

/// Buffers bytes and passes them to a sink in large blocks.
class ByteWriter {
public:
    using Sink = std::function<void(std::span<const std::byte>)>;

    explicit ByteWriter(Sink sink) : sink_(std::move(sink)) {}

    void text(std::string_view characters) {
        if (characters.size() > kCapacity) {
            flush();
            sink_(std::as_bytes(std::span(characters)));
        } else {
            put(characters.data(), characters.size());
        }
    }

    template <typename T>
    void little(T number) {
        putOrdered(number, std::endian::native != std::endian::little);
    }
    template <typename T, std::size_t n>
    void little(const std::array<T, n>& numbers) {
        if constexpr (std::endian::native == std::endian::little)
            put(numbers.data(), sizeof numbers);
        else
            for (const T number : numbers) little(number);
    }
    template <typename T>
    void big(T number) {
        putOrdered(number, std::endian::native == std::endian::little);
    }

    /// Passes buffered bytes to the sink. Must be called at the end.
    void flush() {
        if (used_ > 0) sink_({buffer_.get(), used_});
        used_ = 0;
    }

private:
    /// count: at most kCapacity.
    void put(const void* from, std::size_t count) {
        if (count > kCapacity - used_) flush();
        if (count > 0) std::memcpy(buffer_.get() + used_, from, count);
        used_ += count;
    }

    static constexpr std::size_t kCapacity = std::size_t{1} << 18;

    template <typename T>
    void putOrdered(T number, bool swap_bytes) {
        if constexpr (std::is_same_v<T, float>)
            putOrdered(std::bit_cast<std::uint32_t>(number), swap_bytes);
        else
            putRaw(swap_bytes ? withBytesReversed(number) : number);
    }

    template <typename T>
    void putRaw(T number) {
        put(&number, sizeof(number));
    }

    Sink sink_;
    std::unique_ptr<std::byte[]> buffer_ = std::make_unique_for_overwrite<std::byte[]>(kCapacity);
    std::size_t used_ = 0;
};

/// Opens a file, which is then read on demand. Throws Error with its name and the system's reason.
Cursor openFile(const std::filesystem::path& path);

/// Why a path cannot be read as a file: it is a FIFO, a socket or a device, on which reading could wait for ever. Empty
/// if it is a regular file or a folder, or does not exist.
std::string whyNotRegular(const std::filesystem::path& path);
/// Throws Error with that reason.
void requireRegularFile(const std::filesystem::path& path);

/// Reads a whole file. Throws Error with its name and the system's reason.
Bytes readWholeFile(const std::filesystem::path& path);

}  // namespace betamesh
