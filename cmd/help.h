// Help texts: which options `--help` shows, and how they are laid out.

#pragma once

#include "command.h"

#include <memory>
#include <string>
#include <vector>

namespace betamesh {

inline constexpr const char* kDeprecatedGroup = "Deprecated";  ///< shown last

/// Lays out help for a terminal. `--help` shows only the group "Options" of a command, `--help-all` all groups.
std::shared_ptr<CLI::FormatterBase> helpFormatter();

/// Moves options to the group "Options", which `--help` shows.
void showInShortHelp(CLI::App& command, const std::vector<std::string>& option_names);

/// The groups of a command's options in the order in which help shows them.
std::vector<std::string> optionGroups(const CLI::App& command);

/// The names of a command's subcommands.
std::vector<std::string> subcommandsOf(const CLI::App& command);

/// "betamesh config print"
std::string fullName(const CLI::App& command);

/// "betamesh mesh IN OUT [options]"
std::string usageOf(const CLI::App& command);

/// What stands for the value of an option in the help: "LENGTH", "beta|alpha|union".
std::string placeholderOf(const CLI::Option& option);

/// What an option does, followed by its default value.
std::string descriptionOf(const CLI::Option& option);

}  // namespace betamesh
