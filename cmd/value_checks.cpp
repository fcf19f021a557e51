#include "value_checks.h"

#include "base/nearest_word.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <system_error>

namespace betamesh {
namespace {

/// The number if the text is nothing else.
template <typename Number>
std::optional<Number> numberOf(const std::string& text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// accepts completes the sentence "Use ...".
CLI::Validator check(const std::function<bool(const std::string&)>& isValid, const std::string& accepts,
                     const std::function<std::string(const std::string&)>& hint = {}) {
    return CLI::Validator(
        [=](std::string& value) {
            if (isValid(value)) return std::string();
            return "'" + value + "' is not valid. Use " + accepts + '.' + (hint ? hint(value) : "");
        },
        "");
}

}  // namespace

CLI::Validator wholeNumber(std::int64_t least, std::int64_t most) {
    const bool bounded = most < std::numeric_limits<std::int64_t>::max();
    const std::string accepts = "a whole number " + std::string(bounded ? "from " : "of at least ") +
                                std::to_string(least) + (bounded ? " to " + std::to_string(most) : "");
    return check(
        [=](const std::string& value) {
            const auto number = numberOf<std::int64_t>(value);
            return number && *number >= least && *number <= most;
        },
        accepts);
}

CLI::Validator numberAboveZero() {
    return check(
        [](const std::string& value) {
            const auto number = numberOf<double>(value);
            return number && std::isfinite(*number) && *number > 0;
        },
        "a number above 0");
}

CLI::Validator numberFromZero() {
    return check(
        [](const std::string& value) {
            const auto number = numberOf<double>(value);
            return number && std::isfinite(*number) && *number >= 0;
        },
        "a number of at least 0");
}

CLI::Validator oneOf(const std::vector<std::string>& words) {
    std::string accepts = "one of ";
    for (const std::string& word : words) accepts += (word == words.front() ? "" : ", ") + word;
    return check([=](const std::string& value) { return std::find(words.begin(), words.end(), value) != words.end(); },
                 accepts, [=](const std::string& value) { return didYouMean(value, words); });
}

}  // namespace betamesh
