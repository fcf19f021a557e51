#include "help.h"

#include <algorithm>
#include <sstream>

namespace betamesh {
namespace {

constexpr const char* kShortHelpGroup = "Options";  // CLI11's group for options without a group of their own
constexpr std::size_t kDescriptionColumns = 84;     // to the right of the option names

std::string wrapped(const std::string& text, std::size_t columns) {
    std::istringstream words(text);
    std::string lines;
    std::size_t column = 0;
    for (std::string word; words >> word; column += word.size() + 1) {
        if (column > 0 && column + word.size() > columns) {
            lines += '\n';
            column = 0;
        } else if (column > 0) {
            lines += ' ';
        }
        lines += word;
    }
    return lines;
}

std::string argumentUsage(const CLI::Option& argument) {
    const std::string text = argument.get_name(true) + (argument.get_expected_max() > 1 ? "..." : "");
    return argument.get_required() ? text : '[' + text + ']';
}

class HelpFormatter : public CLI::Formatter {
public:
    HelpFormatter() {
        label("Positionals", "Arguments");
        label("SUBCOMMAND", "COMMAND");
    }

    std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override {
        if (mode == CLI::AppFormatMode::Sub) return make_expanded(command);
        return make_description(command) + make_usage(command, name) + make_positionals(command) +
               groupsOf(*command, mode == CLI::AppFormatMode::Normal) + make_subcommands(command, mode) + '\n' +
               make_footer(command);
    }

    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text;
        if (option->get_type_size() != 0 && option->nonpositional()) text += ' ' + placeholderOf(*option);
        if (option->get_expected_max() == CLI::detail::expected_max_vector_size && !option->nonpositional())
            text += " ...";
        if (option->get_required() && option->nonpositional()) text += " (required)";
        return text;
    }

    std::string make_option_usage(const CLI::Option* argument) const override { return argumentUsage(*argument); }

    std::string make_option_desc(const CLI::Option* option) const override {
        return wrapped(descriptionOf(*option), kDescriptionColumns);
    }

private:
    /// All groups of options; if `shortened`, only the first group and how to see the others.
    std::string groupsOf(const CLI::App& command, bool shortened) const {
        const std::vector<std::string> groups = optionGroups(command);
        std::string text;
        for (const std::string& group : groups) {
            if (shortened && group != kShortHelpGroup) continue;
            text += make_group(group, false, command.get_options([&](const CLI::Option* option) {
                return option->get_group() == group && option->nonpositional();
            }));
        }
        if (shortened && groups.size() > 1) text += "\n`" + fullName(command) + " --help-all` shows all options.\n";
        return text;
    }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> helpFormatter() { return std::make_shared<HelpFormatter>(); }

void showInShortHelp(CLI::App& command, const std::vector<std::string>& option_names) {
    for (const std::string& name : option_names) command.get_option(name)->group(kShortHelpGroup);
}

std::vector<std::string> optionGroups(const CLI::App& command) {
    std::vector<std::string> groups = command.get_groups();
    std::erase(groups, "");
    std::stable_partition(groups.begin(), groups.end(),
                          [](const std::string& group) { return group != kDeprecatedGroup; });
    return groups;
}

std::vector<std::string> subcommandsOf(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(subcommand->get_name());
    return names;
}

std::string fullName(const CLI::App& command) {
    const CLI::App* parent = command.get_parent();
    return (parent == nullptr ? "" : fullName(*parent) + ' ') + command.get_name();
}

std::string usageOf(const CLI::App& command) {
    std::string usage = fullName(command);
    for (const CLI::Option* option : command.get_options()) {
        if (option->get_positional()) usage += ' ' + argumentUsage(*option);
        if (!option->get_positional() && option->get_required())
            usage += ' ' + option->get_name() + ' ' + placeholderOf(*option);
    }
    return usage + " [options]";
}

std::string placeholderOf(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    std::size_t end = type.find(':');  // CLI11 appends ":POSITIVE" and the like for checks
    while (end != std::string::npos && end + 1 < type.size() && type[end + 1] == ' ') end = type.find(':', end + 1);
    return type.substr(0, end);
}

std::string descriptionOf(const CLI::Option& option) {
    const std::string standard = option.get_default_str();
    return option.get_description() + (standard.empty() ? "" : " [default: " + standard + "]");
}

}  // namespace betamesh
