// What the value of a key may be: how it is read from text, and written.

#pragma once

#include "batch/config/config.h"
#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace betamesh {

/// What is told of a key.
struct KeyWords {
    std::string path, option, unit, reason;
};

inline ConfigKey keyOf(const KeyWords& words, ConfigKey::Kind kind, const std::string& expects,
                       std::function<std::string(const Config&)> get,
                       std::function<void(Config&, const std::string& value)> set) {
    return {words.path, words.option, kind, expects, words.unit, words.reason, std::move(get), std::move(set)};
}

[[noreturn]] inline void failValue(const std::string& value, const std::string& expects) {
    throw Error("'" + value + "' was found; expected " + expects);
}

template <typename Number>
std::optional<Number> numberOf(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// The shortest text that reads back as the same number.
inline std::string textOf(double number) {
    std::array<char, 64> buffer{};
    const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    return {buffer.data(), end};
}

template <typename Member>
const auto& readOnly(const Config& config, Member member) {
    return member(const_cast<Config&>(config));  // members are plain accessors: they change nothing
}

template <typename Member>
ConfigKey textKey(const KeyWords& words, const std::string& expects, Member member,
                  std::function<void(const std::string&)> check = {}) {
    return keyOf(
        words, ConfigKey::Kind::text, expects, [=](const Config& config) { return readOnly(config, member); },
        [=](Config& config, const std::string& value) {
            if (check) check(value);
            member(config) = value;
        });
}

inline std::vector<std::string> wordsBetweenCommas(const std::string& text) {
    std::vector<std::string> words;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        word.erase(0, word.find_first_not_of(' '));
        words.push_back(word.substr(0, word.find_last_not_of(' ') + 1));
    }
    return words;
}

/// Names with commas between them; a list in YAML.
template <typename Member>
ConfigKey namesKey(const KeyWords& words, const std::string& expects, Member member,
                   std::function<void(const std::vector<std::string>&)> check = {}) {
    return keyOf(
        words, ConfigKey::Kind::names, expects,
        [=](const Config& config) {
            std::string text;
            for (const std::string& name : readOnly(config, member)) text += (text.empty() ? "" : ",") + name;
            return text;
        },
        [=](Config& config, const std::string& value) {
            const std::vector<std::string> names = wordsBetweenCommas(value);
            for (const std::string& name : names)
                if (name.empty() || std::count(names.begin(), names.end(), name) > 1) failValue(value, expects);
            if (check) check(names);
            member(config) = names;
        });
}

/// zero_is_auto: the word `auto` stands for the value 0.
template <typename Member>
ConfigKey integerKey(const KeyWords& words, int least, int most, bool zero_is_auto, Member member) {
    const std::string expects = std::string(zero_is_auto ? "auto or " : "") + "a whole number, " +
                                std::to_string(least) + " to " + std::to_string(most);
    return keyOf(
        words, ConfigKey::Kind::number, expects,
        [=](const Config& config) {
            const int number = readOnly(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : std::to_string(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<int>(0) : numberOf<int>(value);
            if (!number || (!automatic && (*number < least || *number > most))) failValue(value, expects);
            member(config) = *number;
        });
}

/// Above zero and finite; most included.
template <typename Member>
ConfigKey positiveKey(const KeyWords& words, const std::string& expects, double most, bool zero_is_auto,
                      Member member) {
    return keyOf(
        words, ConfigKey::Kind::number, expects,
        [=](const Config& config) {
            const double number = readOnly(config, member);
            return zero_is_auto && number == 0 ? std::string("auto") : textOf(number);
        },
        [=](Config& config, const std::string& value) {
            const bool automatic = zero_is_auto && value == "auto";
            const auto number = automatic ? std::optional<double>(0) : numberOf<double>(value);
            if (!number || (!automatic && !(*number > 0 && *number <= most))) failValue(value, expects);
            member(config) = *number;
        });
}

/// Any number from least to most.
template <typename Member>
ConfigKey realKey(const KeyWords& words, double least, double most, Member member) {
    const std::string expects = "a number, " + textOf(least) + " to " + textOf(most);
    return keyOf(
        words, ConfigKey::Kind::number, expects, [=](const Config& config) { return textOf(readOnly(config, member)); },
        [=](Config& config, const std::string& value) {
            const auto number = numberOf<double>(value);
            if (!number || !(*number >= least && *number <= most)) failValue(value, expects);
            member(config) = *number;
        });
}

/// Finite numbers with commas between them, or nothing where the text is anything else.
template <std::size_t count>
std::optional<std::array<double, count>> numbersOf(const std::string& text) {
    const std::vector<std::string> words = wordsBetweenCommas(text);
    if (words.size() != count) return std::nullopt;
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = numberOf<double>(words[i]);
        if (!number || !std::isfinite(*number)) return std::nullopt;
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

/// A point, or `auto`.
template <typename Member>
ConfigKey pointKey(const KeyWords& words, Member member) {
    const std::string expects = "auto or three numbers with commas between them";
    return keyOf(
        words, ConfigKey::Kind::names, expects,
        [=](const Config& config) {
            const auto& point = readOnly(config, member);
            return point ? textOfNumbers(*point) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<3>(value);
            if (!numbers && value != "auto") failValue(value, expects);
            member(config) = numbers;
        });
}

/// The ends of a scale, or `auto`.
template <typename Member>
ConfigKey rangeKey(const KeyWords& words, Member member) {
    const std::string expects = "auto or two numbers with a comma between them, the lower one first";
    return keyOf(
        words, ConfigKey::Kind::names, expects,
        [=](const Config& config) {
            const auto& range = readOnly(config, member);
            return range[1] > range[0] ? textOfNumbers(range) : "auto";
        },
        [=](Config& config, const std::string& value) {
            const auto numbers = numbersOf<2>(value);
            if (value != "auto" && !(numbers && (*numbers)[1] > (*numbers)[0])) failValue(value, expects);
            member(config) = numbers.value_or(std::array<double, 2>{0, 0});
        });
}

template <typename Member>
ConfigKey booleanKey(const KeyWords& words, Member member) {
    const std::string expects = "true or false";
    return keyOf(
        words, ConfigKey::Kind::boolean, expects,
        [=](const Config& config) { return std::string(readOnly(config, member) ? "true" : "false"); },
        [=](Config& config, const std::string& value) {
            if (value != "true" && value != "false") failValue(value, expects);
            member(config) = value == "true";
        });
}

template <typename Choice>
using Choices = std::vector<std::pair<std::string, Choice>>;

template <typename Choice, typename Member>
ConfigKey choiceKey(const KeyWords& words, const Choices<Choice>& choices, Member member) {
    std::string expects = choices.size() > 1 ? "one of" : "the word";
    for (const auto& choice : choices) expects += ' ' + choice.first;
    return keyOf(
        words, ConfigKey::Kind::choice, expects,
        [=](const Config& config) {
            return std::find_if(choices.begin(), choices.end(),
                                [&](const auto& choice) { return choice.second == readOnly(config, member); })
                ->first;
        },
        [=](Config& config, const std::string& value) {
            const auto found =
                std::find_if(choices.begin(), choices.end(), [&](const auto& choice) { return choice.first == value; });
            if (found == choices.end()) failValue(value, expects);
            member(config) = found->second;
        });
}

inline constexpr const char* kLengthAboveZero = "a number above 0, or a multiple of the spacing such as 1.5dx";

inline std::string textOf(const LengthText& length) { return textOf(length.value) + (length.in_spacings ? "dx" : ""); }

/// "0.02" or "1.5dx", 0 or more; nothing where the text is anything else.
inline std::optional<LengthText> lengthOf(std::string_view text) {
    const bool in_spacings = text.ends_with("dx");
    const auto number = numberOf<double>(text.substr(0, text.size() - (in_spacings ? 2 : 0)));
    if (!number || !(*number >= 0) || !std::isfinite(*number)) return std::nullopt;
    return LengthText{*number, in_spacings && *number > 0};
}

/// A length above 0. zero: the word that stands for the value 0; "0" itself, or empty where there is none.
template <typename Member>
ConfigKey lengthKey(const KeyWords& words, const std::string& zero, Member member) {
    const std::string expects = (zero.empty() ? "" : zero + ", ") + kLengthAboveZero;
    return keyOf(
        words, ConfigKey::Kind::number, expects,
        [=](const Config& config) {
            const LengthText& length = readOnly(config, member);
            return !zero.empty() && length.value == 0 ? zero : textOf(length);
        },
        [=](Config& config, const std::string& value) {
            const auto length = !zero.empty() && value == zero ? std::optional(LengthText{0, false}) : lengthOf(value);
            if (!length || (length->value == 0 && value != zero && zero != "0")) failValue(value, expects);
            member(config) = *length;
        });
}

/// A length or `auto`, which stands for none. zero: the word for 0, which is read too.
template <typename Member>
ConfigKey optionalLengthKey(const KeyWords& words, const std::string& zero, Member member) {
    const std::string expects = "auto, " + zero + ", " + kLengthAboveZero;
    return keyOf(
        words, ConfigKey::Kind::number, expects,
        [=](const Config& config) -> std::string {
            const std::optional<LengthText>& length = readOnly(config, member);
            return !length ? "auto" : length->value == 0 ? zero : textOf(*length);
        },
        [=](Config& config, const std::string& value) {
            const auto length = value == zero ? std::optional(LengthText{0, false}) : lengthOf(value);
            if (!length && value != "auto") failValue(value, expects);
            member(config) = length;
        });
}

struct ByteUnit {
    std::string_view name;
    double bytes;
};
inline constexpr std::array<ByteUnit, 6> kByteUnits{
    {{"TiB", 0x1p40}, {"GiB", 0x1p30}, {"MiB", 0x1p20}, {"TB", 1e12}, {"GB", 1e9}, {"MB", 1e6}}};

/// "16GiB"; zero is `auto`.
template <typename Member>
ConfigKey bytesKey(const KeyWords& words, Member member) {
    const std::string expects = "auto or a size from 1MiB to 1024TiB with its unit (MiB GiB TiB MB GB TB)";
    return keyOf(
        words, ConfigKey::Kind::number, expects,
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
            failValue(value, expects);
        });
}
}  // namespace betamesh
