#include "io/houdini_json_writer.h"

#include "io/houdini_json_tokens.h"

#include <limits>

namespace betamesh {

using namespace houdini_json;

HoudiniJsonWriter::HoudiniJsonWriter(ByteWriter& out) : out_(out) { out_.text(kLittleMagic); }

void HoudiniJsonWriter::length(std::uint64_t count) {
    if (count < code::first_length_code) {
        token(static_cast<std::uint8_t>(count));
    } else if (count <= 0xffff) {
        token(code::length16);
        out_.little(static_cast<std::uint16_t>(count));
    } else if (count <= 0xffffffff) {
        token(code::length32);
        out_.little(static_cast<std::uint32_t>(count));
    } else {
        token(code::length64);
        out_.little(static_cast<std::int64_t>(count));
    }
}

void HoudiniJsonWriter::text(std::string_view characters) {
    token(code::text);
    length(characters.size());
    out_.text(characters);
}

void HoudiniJsonWriter::integer(std::int64_t number) {
    const auto writeAs = [&]<typename T>(std::uint8_t type, T) {
        if (number < std::numeric_limits<T>::min() || number > std::numeric_limits<T>::max()) return false;
        token(type);
        out_.little(static_cast<T>(number));
        return true;
    };
    writeAs(code::int8, std::int8_t{}) || writeAs(code::int16, std::int16_t{}) ||
        writeAs(code::int32, std::int32_t{}) || writeAs(code::int64, std::int64_t{});
}

void HoudiniJsonWriter::real(double number) {
    token(code::real64);
    out_.little(number);
}

template <typename T>
void HoudiniJsonWriter::beginNumbers(std::uint64_t count) {
    token(code::uniform);
    token(std::is_same_v<T, float>          ? code::real32
          : std::is_same_v<T, std::int8_t>  ? code::int8
          : std::is_same_v<T, std::int32_t> ? code::int32
                                            : code::int64);
    length(count);
}

template void HoudiniJsonWriter::beginNumbers<float>(std::uint64_t);
template void HoudiniJsonWriter::beginNumbers<std::int8_t>(std::uint64_t);
template void HoudiniJsonWriter::beginNumbers<std::int32_t>(std::uint64_t);
template void HoudiniJsonWriter::beginNumbers<std::int64_t>(std::uint64_t);

}  // namespace betamesh
