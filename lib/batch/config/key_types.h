// Types of configuration values: how a value is read from text, checked, and written as text again.

#pragma once

#include "base/list_entries.h"
#include "base/nearest_word.h"
#include "batch/config/config.h"
#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace betamesh {

/// What the user reads about a key.
struct KeyText {
    std::string path, option, unit, help;
};

/// `accepts` describes the valid values so that it completes the sentence "Use ...".
inline ConfigKey makeKey(const KeyText& text, ConfigKey::Kind kind, const std::string& accepts,
                         std::function<std::string(const Config&)> get,
                         std::function<void(Config&, const std::string& value)> set) {
    return {text.path, text.option, kind, accepts, text.unit, text.help, std::move(get), std::move(set)};
}

template <typename Number>
std::optional<Number> numberOf(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// Whether files can store the number, as a 32-bit float.
inline bool fitsFloat(double number) { return std::abs(number) <= double{std::numeric_limits<float>::max()}; }

/// Whether a number above 0 stays above 0, with full precision, as a 32-bit float.
inline bool isFloatAboveZero(double number) {
    return number >= double{std::numeric_limits<float>::min()} && fitsFloat(number);
}

/// Why a number that is valid otherwise is not: it is outside the range of 32-bit floats. Empty if it is inside, or if
/// the text is anything else.
inline std::string outsideFloats(std::string_view text) {
    const auto number = numberOf<double>(text.substr(0, text.size() - (text.ends_with("dx") ? 2 : 0)));
    if (!number || *number == 0 || !std::isfinite(*number) || isFloatAboveZero(std::abs(*number))) return "";
    return " Files store 32-bit floats, which range from 1.2e-38 to 3.4e38.";
}

/// choices: words that may have been meant.
[[noreturn]] inline void failValue(const std::string& value, const std::string& accepts,
                                   const std::vector<std::string>& choices = {}) {
    throw Error("'" + value + "' is not valid. Use " + accepts + '.' + outsideFloats(value) +
                didYouMean(value, choices));
}

/// The shortest text that reads back as the same number.
inline std::string textOf(double number) {
    std::array<char, 64> buffer{};
    const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    return {buffer.data(), end};
}

/// Six digits, for messages.
inline std::string shortNumber(double number) {
    std::array<char, 32> buffer{};
    const auto [end, error] =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, std::chars_format::general, 6);
    return {buffer.data(), end};
}

template <typename Member>
const auto& readOnly(const Config& config, Member member) {
    return member(const_cast<Config&>(config));  // an accessor returns a reference and changes nothing
}

template <typename Member>
ConfigKey textKey(const KeyText& text, const std::string& accepts, Member member,
                  const std::function<void(const std::string&)>& check = {}) {
    return makeKey(
        text, ConfigKey::Kind::text, accepts, [=](const Config& config) { return readOnly(config, member); },
        [=](Config& config, const std::string& value) {
            if (check) check(value);
            member(config) = value;
        });
}

/// Names separated by commas, or a list in YAML. Each name may occur once.
template <typename Member>
ConfigKey namesKey(const KeyText& text, const std::string& accepts, Member member,
                   const std::function<void(const std::vector<std::string>&)>& check = {}) {
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [=](const Config& config) {
            std::string list;
            for (const std::string& name : readOnly(config, member)) list += (list.empty() ? "" : ",") + name;
            return list;
        },
        [=](Config& config, const std::string& value) {
            const std::vector<std::string> names = entriesOf(value);
            for (const std::string& name : names)
                if (name.empty() || std::count(names.begin(), names.end(), name) > 1) failValue(value, accepts);
            if (check) check(names);
            member(config) = names;
        });
}

/// A whole number from least to most. With zero_is_auto the word `auto` stands for the value 0.
template <typename Member>
ConfigKey integerKey(const KeyText& text, int least, int most, bool zero_is_auto, Member member) {
    const std::string accepts = std::string(zero_is_auto ? "auto, or " : "") + "a whole number from " +
                                std::to_string(least) + " to " + std::to_string(most);
    return makeKey(
        text, ConfigKey::Kind::number, accepts,
        [=](const Config& config) {
            const int number = readOnly(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : std::to_string(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<int>(0) : numberOf<int>(value);
            if (!number || (!automatic && (*number < least || *number > most))) failValue(value, accepts);
            member(config) = *number;
        });
}

/// A number above 0 and at most `most`, of at least the smallest normal 32-bit float. With zero_is_auto the word `auto`
/// stands for the value 0.
template <typename Member>
ConfigKey positiveKey(const KeyText& text, const std::string& accepts, double most, bool zero_is_auto, Member member) {
    return makeKey(
        text, ConfigKey::Kind::number, accepts,
        [=](const Config& config) {
            const double number = readOnly(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : textOf(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<double>(0) : numberOf<double>(value);
            if (!number || (!automatic && !(isFloatAboveZero(*number) && *number <= most))) failValue(value, accepts);
            member(config) = *number;
        });
}

/// A number from least to most.
template <typename Member>
ConfigKey realKey(const KeyText& text, double least, double most, Member member) {
    const std::string accepts = "a number from " + textOf(least) + " to " + textOf(most);
    return makeKey(
        text, ConfigKey::Kind::number, accepts, [=](const Config& config) { return textOf(readOnly(config, member)); },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (!number || !(*number >= least && *number <= most)) failValue(value, accepts);
            member(config) = *number;
        });
}

/// `count` numbers that fit 32-bit floats, separated by commas; nullopt if the text is anything else.
template <std::size_t count>
std::optional<std::array<double, count>> numbersOf(const std::string& text) {
    const std::vector<std::string> entries = entriesOf(text);
    if (entries.size() != count) return std::nullopt;
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = numberOf<double>(entries[i]);
        if (!number || !fitsFloat(*number)) return std::nullopt;
        numbers[i] = *number;
    }
    return numbers;
}

template <std::size_t count>
std::string textOfNumbers(const std::array<double, count>& numbers) {
    std::string text;
    for (const double number : numbers) text += (text.empty() ? "" : ",") + textOf(number);
    return text;
}

/// A point, or `auto` (nullopt).
template <typename Member>
ConfigKey pointKey(const KeyText& text, Member member) {
    const std::string accepts = "auto, or three numbers separated by commas";
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [=](const Config& config) {
            const auto& point = readOnly(config, member);
            return point ? textOfNumbers(*point) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<3>(value);
            if (!numbers && value != "auto") failValue(value, accepts);
            member(config) = numbers;
        });
}

/// The lower and upper end of a range, or `auto` (two equal values).
template <typename Member>
ConfigKey rangeKey(const KeyText& text, Member member) {
    const std::string accepts = "auto, or two numbers separated by a comma, the lower one first";
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [=](const Config& config) {
            const auto& range = readOnly(config, member);
            return range[1] > range[0] ? textOfNumbers(range) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<2>(value);
            if (value != "auto" && !(numbers && (*numbers)[1] > (*numbers)[0])) failValue(value, accepts);
            member(config) = numbers.value_or(std::array<double, 2>{0, 0});
        });
}

template <typename Member>
ConfigKey booleanKey(const KeyText& text, Member member) {
    const std::string accepts = "true or false";
    return makeKey(
        text, ConfigKey::Kind::boolean, accepts,
        [=](const Config& config) { return std::string(readOnly(config, member) ? "true" : "false"); },
        [=](Config& config, const std::string& value) {
            if (value != "true" && value != "false") failValue(value, accepts);
            member(config) = value == "true";
        });
}

/// true, false or `auto` (nullopt). Its option is a flag that means true.
template <typename Member>
ConfigKey automaticBooleanKey(const KeyText& text, Member member) {
    const std::string accepts = "auto, true or false";
    return makeKey(
        text, ConfigKey::Kind::boolean, accepts,
        [=](const Config& config) {
            const std::optional<bool>& is_wanted = readOnly(config, member);
            return std::string(!is_wanted ? "auto" : *is_wanted ? "true" : "false");
        },
        [=](Config& config, const std::string& value) {
            if (value != "auto" && value != "true" && value != "false") failValue(value, accepts);
            member(config) = value == "auto" ? std::nullopt : std::optional(value == "true");
        });
}

template <typename Choice>
using Choices = std::vector<std::pair<std::string, Choice>>;

/// One of several words.
template <typename Choice, typename Member>
ConfigKey choiceKey(const KeyText& text, const Choices<Choice>& choices, Member member) {
    std::string accepts = "one of ";
    std::vector<std::string> names;
    for (const auto& choice : choices) {
        accepts += (names.empty() ? "" : ", ") + choice.first;
        names.push_back(choice.first);
    }
    ConfigKey key = makeKey(
        text, ConfigKey::Kind::choice, accepts,
        [=](const Config& config) {
            return std::find_if(choices.begin(), choices.end(),
                                [&](const auto& choice) { return choice.second == readOnly(config, member); })
                ->first;
        },
        [=](Config& config, const std::string& value) {
            const auto found =
                std::find_if(choices.begin(), choices.end(), [&](const auto& choice) { return choice.first == value; });
            if (found == choices.end()) failValue(value, accepts, names);
            member(config) = found->second;
        });
    key.choices = names;
    return key;
}

inline constexpr const char* kLengthAboveZero =
    "a number above 0 in world units, or a multiple of the particle spacing such as 1.5dx";

inline std::string textOf(const Length& length) { return textOf(length.value) + (length.in_spacings ? "dx" : ""); }

/// A length such as "0.02" or "1.5dx", 0 or in the range of 32-bit floats; nullopt if the text is anything else.
inline std::optional<Length> lengthOf(std::string_view text) {
    const bool in_spacings = text.ends_with("dx");
    const auto number = numberOf<double>(text.substr(0, text.size() - (in_spacings ? 2 : 0)));
    if (!number || !(*number == 0 || isFloatAboveZero(*number))) return std::nullopt;
    return Length{*number, in_spacings && *number > 0};
}

/// A length above 0. `zero` is a word for the value 0, which may be "0" itself; empty if 0 is not allowed.
template <typename Member>
ConfigKey lengthKey(const KeyText& text, const std::string& zero, Member member) {
    const std::string accepts = (zero.empty() ? "" : zero + ", ") + kLengthAboveZero;
    return makeKey(
        text, ConfigKey::Kind::length, accepts,
        [=](const Config& config) {
            const Length& length = readOnly(config, member);
            return !zero.empty() && length.value == 0 ? zero : textOf(length);
        },
        [=](Config& config, const std::string& value) {
            const auto length = !zero.empty() && value == zero ? std::optional(Length{0, false}) : lengthOf(value);
            if (!length || (length->value == 0 && value != zero && zero != "0")) failValue(value, accepts);
            member(config) = *length;
        });
}

/// A length, or `auto` (nullopt). `zero` is a word for the value 0; the number 0 is accepted too.
template <typename Member>
ConfigKey optionalLengthKey(const KeyText& text, const std::string& zero, Member member) {
    const std::string accepts = "auto, " + zero + ", " + kLengthAboveZero;
    return makeKey(
        text, ConfigKey::Kind::length, accepts,
        [=](const Config& config) -> std::string {
            const std::optional<Length>& length = readOnly(config, member);
            return !length ? "auto" : length->value == 0 ? zero : textOf(*length);
        },
        [=](Config& config, const std::string& value) {
            const auto length = value == zero ? std::optional(Length{0, false}) : lengthOf(value);
            if (!length && value != "auto") failValue(value, accepts);
            member(config) = length;
        });
}

struct ByteUnit {
    std::string_view name;
    double bytes;
};
inline constexpr std::array<ByteUnit, 6> kByteUnits{
    {{"TiB", 0x1p40}, {"GiB", 0x1p30}, {"MiB", 0x1p20}, {"TB", 1e12}, {"GB", 1e9}, {"MB", 1e6}}};

/// A size in bytes with its unit, such as "16GiB", or `auto` (0).
template <typename Member>
ConfigKey bytesKey(const KeyText& text, Member member) {
    const std::string accepts = "auto, or a size from 1MiB to 1024TiB with its unit (MiB, GiB, TiB, MB, GB or TB)";
    return makeKey(
        text, ConfigKey::Kind::number, accepts,
        [=](const Config& config) {
            const std::uint64_t bytes = readOnly(config, member);
            if (bytes == 0) return std::string("auto");
            for (const ByteUnit& unit : kByteUnits) {
                const auto unit_bytes = static_cast<std::uint64_t>(unit.bytes);
                if (bytes % unit_bytes == 0) return std::to_string(bytes / unit_bytes) + std::string(unit.name);
            }
            return textOf(static_cast<double>(bytes) / 0x1p20) + "MiB";
        },
        [=](Config& config, const std::string& value) {
            if (value == "auto") {
                member(config) = 0;
                return;
            }
            for (const ByteUnit& unit : kByteUnits) {
                if (!value.ends_with(unit.name)) continue;
                const auto number =
                    numberOf<double>(std::string_view(value).substr(0, value.size() - unit.name.size()));
                if (!number || !(*number * unit.bytes >= 0x1p20 && *number * unit.bytes <= 0x1p50)) break;
                member(config) = static_cast<std::uint64_t>(*number * unit.bytes);
                return;
            }
            failValue(value, accepts);
        });
}

}  // namespace betamesh
