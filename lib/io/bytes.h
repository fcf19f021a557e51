// Bytes in memory: a bounded cursor to read them, a buffered writer to make them, whole files.

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

/// The same number with its bytes in the other order.
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

/// A number from memory of any alignment; other_order: its bytes are in the order this machine does not use.
template <typename T>
T loadNumber(const std::byte* from, bool other_order) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), from, sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {  // reversed as an integer: a float could not hold every bit pattern
        using Whole = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
        const auto bits = std::bit_cast<Whole>(raw);
        return std::bit_cast<T>(other_order ? withBytesReversed(bits) : bits);
    } else {
        const T number = std::bit_cast<T>(raw);
        return other_order ? withBytesReversed(number) : number;
    }
}

template <typename T>
T loadBig(const std::byte* from) {
    return loadNumber<T>(from, std::endian::native == std::endian::little);
}

/// Walks through the bytes of one file, in memory or read as it goes, and never leaves them: what a damaged count asks
/// for beyond the end is an Error with file and byte offset, before anything is allocated for it.
class Cursor {
public:
    /// Puts the next bytes at `to`, at most so many; returns how many, none at the end.
    using Source = std::function<std::size_t(std::byte* to, std::size_t count)>;

    /// All of them; they have to stay.
    Cursor(std::span<const std::byte> bytes, std::string file)
        : bytes_(bytes), size_(bytes.size()), file_(std::move(file)) {}
    /// size: how many the source has, or where that is not known the most it may have.
    Cursor(Source source, std::uint64_t size, std::string file)
        : source_(std::move(source)), size_(size), file_(std::move(file)) {}
    Cursor(Cursor&&) = default;
    Cursor(const Cursor&) = delete;

    std::uint64_t offset() const { return before_ + at_; }
    std::uint64_t remaining() const { return size_ - offset(); }
    const std::string& file() const { return file_; }

    /// The next count bytes, which it steps over. They stay until more is asked for.
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

    /// Steps over bytes of any number.
    void skip(std::uint64_t count, const char* what) {
        requireRows(1, count, what);
        constexpr std::uint64_t kPiece = std::uint64_t{1} << 18;
        for (; count > 0; count -= std::min(count, kPiece))
            take(static_cast<std::size_t>(std::min(count, kPiece)), what);
    }

    /// Fails unless rows of bytes_per_row each still fit in the file.
    void requireRows(std::uint64_t rows, std::uint64_t bytes_per_row, const char* what) const {
        if (bytes_per_row != 0 && rows > remaining() / bytes_per_row) failTruncated(rows, bytes_per_row, what);
    }

    /// At least so many of the bytes that follow, or all that are left; it does not step over them.
    std::string_view peek(std::size_t count) {
        if (count > bytes_.size() - at_) fetch(count);
        return {reinterpret_cast<const char*>(bytes_.data()) + at_, bytes_.size() - at_};
    }

    [[noreturn]] void fail(const std::string& text) const {
        throw Error(file_ + ": byte " + std::to_string(offset()) + ": " + text);
    }

private:
    /// Makes count bytes stand in memory, if there are as many.
    void fetch(std::size_t count);

    [[noreturn]] void failTruncated(std::uint64_t rows, std::uint64_t bytes_per_row, const char* what) const {
        fail(std::string(what) + " needs " + (rows == 1 ? "" : std::to_string(rows) + " times ") +
             std::to_string(bytes_per_row) + " bytes, the file ends after " + std::to_string(remaining()) +
             " (truncated, or a damaged count)");
    }

    Source source_;
    Bytes buffer_;                      // of a source: what stands in memory
    std::span<const std::byte> bytes_;  // what stands in memory
    std::uint64_t before_ = 0;          // bytes before these
    std::size_t at_ = 0;                // in these
    std::uint64_t size_;
    std::string file_;
};

/// Collects bytes and hands them on in large pieces.
class ByteWriter {
public:
    using Drain = std::function<void(std::span<const std::byte>)>;

    explicit ByteWriter(Drain drain) : drain_(std::move(drain)) {}

    void text(std::string_view characters) {
        if (characters.size() > kCapacity) {
            flush();
            drain_(std::as_bytes(std::span(characters)));
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

    /// Must be called at the end.
    void flush() {
        if (used_ > 0) drain_({buffer_.get(), used_});
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
    void putOrdered(T number, bool other_order) {
        if constexpr (std::is_same_v<T, float>)
            putOrdered(std::bit_cast<std::uint32_t>(number), other_order);
        else
            putRaw(other_order ? withBytesReversed(number) : number);
    }

    template <typename T>
    void putRaw(T number) {
        put(&number, sizeof(number));
    }

    Drain drain_;
    std::unique_ptr<std::byte[]> buffer_ = std::make_unique_for_overwrite<std::byte[]>(kCapacity);
    std::size_t used_ = 0;
};

/// A file, read as it goes. Throws Error with its name and the system's reason.
Cursor openFile(const std::filesystem::path& path);

/// The whole file.
Bytes readWholeFile(const std::filesystem::path& path);

}  // namespace betamesh
