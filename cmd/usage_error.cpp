#include "usage_error.h"

#include "base/nearest_word.h"
#include "help.h"

#include <algorithm>
#include <set>

namespace betamesh {
namespace {

constexpr std::size_t kMostNamesListed = 16;

/// The command that was being parsed; the program itself if it was none.
const CLI::App& commandOf(const CLI::App& program) {
    const CLI::App* command = &program;
    while (!command->get_subcommands().empty()) command = command->get_subcommands().back();
    return *command;
}

std::string listOf(const std::vector<std::string>& names, const std::string& last_separator = ", ") {
    std::string list;
    for (std::size_t i = 0; i < names.size(); ++i)
        list += (i == 0 ? "" : i + 1 == names.size() ? last_separator : ", ") + names[i];
    return list;
}

std::vector<std::string> optionNamesOf(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
        for (const std::string& name : option->get_snames()) names.push_back('-' + name);
    }
    return names;
}

std::string seeHelp(const CLI::App& app, const char* help = "--help") {
    return " See `" + fullName(app) + ' ' + help + "`.";
}

/// The option a message of CLI11 begins with, as in "--radius: 1 required LENGTH missing"; null if there is none.
const CLI::Option* optionNamed(const CLI::App& app, const std::string& message) {
    const auto isNamed = [&](const CLI::Option* option) {
        return message.starts_with(option->get_name() + ':') || message.starts_with(option->get_name(true) + ':');
    };
    const std::vector<const CLI::Option*> options = app.get_options();
    const auto found = std::find_if(options.begin(), options.end(), isNamed);
    return found == options.end() ? nullptr : *found;
}

std::string unknownOption(const CLI::App& app, const std::string& word) {
    const std::string typed = word.starts_with("--") ? word.substr(0, word.find('=')) : word;
    const std::vector<std::string> known = optionNamesOf(app);
    const std::string options =
        known.size() <= kMostNamesListed ? " Its options are " + listOf(known) + '.' : seeHelp(app, "--help-all");
    return fullName(app) + " has no option '" + typed + "'." + didYouMean(typed, known) + options;
}

std::string unknownCommand(const CLI::App& app, const std::string& word) {
    const std::vector<std::string> known = subcommandsOf(app);
    return fullName(app) + " has no command '" + word + "'." + didYouMean(word, known) + " The commands are " +
           listOf(known, " and ") + '.';
}

std::string unexpectedArgument(const CLI::App& app, const std::string& word) {
    bool takes_sequences = false;
    for (const CLI::Option* option : app.get_options())
        takes_sequences |= option->get_positional() && option->get_description().find("####") != std::string::npos;
    return fullName(app) + " does not expect the argument '" + word + "'. Usage: " + usageOf(app) + '.' +
           (takes_sequences ? " Write the frame number of a sequence as ####, because a shell replaces * by all names."
                            : "");
}

/// The explanation of words that are left over; empty if there are none.
std::string leftOver(const CLI::App& app, const std::vector<std::string>& words) {
    std::vector<std::string> left = app.remaining();
    if (left.empty()) return "";
    // CLI11 shortens "-qx" to "-x" when it has understood -q.
    for (const std::string& word : words)
        for (std::string& rest : left)
            if (word.size() > 2 && word[0] == '-' && word[1] != '-' && rest.size() > 1 && rest[0] == '-' &&
                word != rest && word.ends_with(rest.substr(1)))
                rest = word;
    const auto isOption = [](const std::string& word) { return word.size() > 1 && word[0] == '-'; };
    const auto option = std::find_if(left.begin(), left.end(), isOption);
    if (option != left.end() && *option != "--") return unknownOption(app, *option);
    const std::string& word = left.front();
    return subcommandsOf(app).empty() ? unexpectedArgument(app, word) : unknownCommand(app, word);
}

/// The explanation of required arguments and options that are missing; empty if there are none.
std::string missing(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        if (option->get_required() && option->count() == 0) names.push_back(option->get_name(option->get_positional()));
    if (!names.empty())
        return fullName(app) + " needs " + listOf(names, " and ") + ". Usage: " + usageOf(app) + '.' + seeHelp(app);
    if (app.get_require_subcommand_min() > app.get_subcommands().size())
        return fullName(app) + " needs a command: " + listOf(subcommandsOf(app), " or ") + '.' + seeHelp(app);
    return "";
}

/// The explanation of an option that was given without another one that it needs; empty if there is none.
std::string withoutNeeded(const CLI::App& app) {
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0) continue;
        for (const CLI::Option* needed : option->get_needs())
            if (needed->count() == 0)
                return option->get_name() + " has no meaning without " + needed->get_name() + ". Add " +
                       needed->get_name() + ' ' + placeholderOf(*needed) + '.' + seeHelp(app);
    }
    return "";
}

/// The explanation of an option with too few or too many values.
std::string wrongCount(const CLI::App& app, const CLI::Option& option) {
    if (option.count() == 0)
        return option.get_name() + " needs a value: " + placeholderOf(option) + ". " + descriptionOf(option);
    return option.get_name() + " is given " + std::to_string(option.count()) + " times, with " +
           listOf(option.results(), " and ") + ". Give it once." + seeHelp(app);
}

}  // namespace

std::string usageError(const CLI::App& program, const std::vector<std::string>& words, const CLI::ParseError& error) {
    const CLI::App& app = commandOf(program);
    const std::string message = error.what();
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr)
        if (const CLI::Option* option = optionNamed(app, message)) return wrongCount(app, *option);
    if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) return message;
    if (const std::string text = leftOver(app, words); !text.empty()) return text;
    if (const std::string text = missing(app); !text.empty()) return text;
    if (const std::string text = withoutNeeded(app); !text.empty()) return text;
    return fullName(app) + ": " + message + '.' + seeHelp(app);
}

}  // namespace betamesh
