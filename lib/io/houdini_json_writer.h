// Houdini's JSON in its binary encoding, written value by value.

#pragma once

#include "io/bytes.h"

#include <string_view>

namespace betamesh {

/// Writes one document in the binary encoding, little-endian.
class HoudiniJsonWriter {
public:
    explicit HoudiniJsonWriter(ByteWriter& out);

    void beginArray() { token(0x5b); }
    void endArray() { token(0x5d); }
    void beginMap() { token(0x7b); }
    void endMap() { token(0x7d); }
    void text(std::string_view characters);
    void integer(std::int64_t number);
    void real(double number);
    void boolean(bool value) { token(value ? 0x31 : 0x30); }

    /// Begins an array of numbers that has no end token: count calls of number() follow. T: float, std::int8_t,
    /// std::int32_t or std::int64_t.
    template <typename T>
    void beginNumbers(std::uint64_t count);
    template <typename T>
    void number(T value) {
        out_.little(value);
    }

private:
    void token(std::uint8_t code) { out_.little(code); }
    void length(std::uint64_t count);

    ByteWriter& out_;
};

}  // namespace betamesh
