// The man page and the shell completions, generated from the definitions of the commands.

#include "batch/job/job.h"
#include "betamesh/version.h"
#include "command.h"
#include "help.h"
#include "io/extension.h"
#include "value_checks.h"

#include <functional>
#include <iostream>
#include <sstream>

namespace betamesh {
namespace {

struct ManualArguments {
    const CLI::App* program = nullptr;
    std::string form;
};

/// A command with its full name: "config", "config print".
struct Entry {
    std::string name;
    const CLI::App* app;
};

/// The commands below an app, each followed by its own subcommands.
std::vector<Entry> entriesOf(const CLI::App& app, const std::string& prefix = "") {
    std::vector<Entry> entries;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        entries.push_back({prefix + command->get_name(), command});
        for (const Entry& entry : entriesOf(*command, command->get_name() + ' ')) entries.push_back(entry);
    }
    return entries;
}

bool takesValue(const CLI::Option& option) { return option.get_type_size() != 0; }

/// The words of the placeholder "beta|alpha|union"; none if the placeholder is not a list of words.
std::vector<std::string> choicesOf(const CLI::Option& option) {
    std::vector<std::string> choices;
    const std::string type = placeholderOf(option);
    if (!takesValue(option) || type.find('|') == std::string::npos) return choices;
    std::istringstream in(type);
    for (std::string choice; std::getline(in, choice, '|');) choices.push_back(choice);
    return choices;
}

std::vector<std::string> namesOf(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back('-' + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

std::string concatenate(const std::vector<std::string>& words, const std::string& separator) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
    return text;
}

void forOptions(const CLI::App& app, const std::function<void(const CLI::Option&)>& visit) {
    for (const CLI::Option* option : app.get_options()) visit(*option);
}

/// Text escaped so that troff prints it literally.
std::string troff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
        out += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
    }
    return out;
}

/// Text whose line breaks troff keeps.
std::string verbatim(const std::string& text) { return ".nf\n" + troff(text) + "\n.fi\n"; }

std::string optionEntry(const CLI::Option& option) {
    std::string head = option.get_positional() ? option.get_name(true) : concatenate(namesOf(option), ", ");
    if (takesValue(option) && !option.get_positional()) head += ' ' + placeholderOf(option);
    return ".TP\n.B " + troff(head) + '\n' + troff(descriptionOf(option)) + '\n';
}

/// The arguments and options of a command, with a heading for each group if there are several.
std::string optionsPage(const CLI::App& app) {
    const std::vector<std::string> groups = optionGroups(app);
    std::string arguments, text;
    forOptions(app, [&](const CLI::Option& option) {
        if (option.get_positional()) arguments += optionEntry(option);
    });
    for (const std::string& group : groups) {
        if (groups.size() > 1) text += ".PP\n.I " + troff(group) + '\n';
        forOptions(app, [&](const CLI::Option& option) {
            if (!option.get_positional() && option.get_group() == group) text += optionEntry(option);
        });
    }
    return arguments + text;
}

/// What is written in a format: "particles, meshes".
std::string contentsOf(const FileFormat& format) {
    std::vector<std::string> kinds;
    if (format.write_particles != nullptr) kinds.push_back("particles");
    if (format.write_mesh != nullptr) kinds.push_back("meshes");
    if (format.write_curves != nullptr) kinds.push_back("curves");
    if (format.write_spheres != nullptr) kinds.push_back("spheres");
    if (format.is_drawing) kinds.push_back("drawings of two-dimensional frames");
    return concatenate(kinds, ", ");
}

/// The file formats, with the test of each and the foreign program that proves it.
std::string formatsPage() {
    std::string text =
        ".SH FORMATS\nThe extension of a file selects its format. Files ending in .gz are compressed by gzip, those "
        "ending in .sc by Blosc.\n";
    for (const FileFormat& format : fileFormats()) {
        std::string row;
        if (format.read != nullptr) {
            row += "Read: " + std::string(format.read_extensions) + " (";
            row += format.reads_particles && format.reads_surfaces ? "particles, meshes, curves"
                   : format.reads_particles                        ? "particles"
                                                                   : "meshes, curves";
            row += "). ";
        }
        if (!format.write_extensions.empty())
            row += "Written: " + std::string(format.write_extensions) + " (" + contentsOf(format) + "). ";
        if (!format.holds_attributes) row += "Holds neither velocity nor attributes. ";
        if (format.id_bits > 0 && format.id_bits < 64) row += "Ids have " + std::to_string(format.id_bits) + " bits. ";
        row += "Proof: " + std::string(format.proof) + " (test " + std::string(format.test) + ").";
        text += ".TP\n.B " + troff(std::string(format.name)) + '\n' + troff(row) + '\n';
    }
    return text;
}

std::string manPage(const CLI::App& program) {
    std::string text = std::string(".TH BETAMESH 1 \"\" \"betamesh ") + version() +
                       "\" \"User Commands\"\n.SH NAME\nbetamesh \\- " + troff(program.get_description()) +
                       "\n.SH SYNOPSIS\n.B betamesh\n.I COMMAND\n[options]\n.SH OPTIONS\n" + optionsPage(program) +
                       ".SH COMMANDS\n";
    for (const Entry& entry : entriesOf(program)) {
        text += ".SS betamesh " + troff(entry.name) + '\n' + troff(entry.app->get_description()) + '\n' +
                optionsPage(*entry.app);
        if (!entry.app->get_footer().empty()) text += ".PP\n" + verbatim(entry.app->get_footer());
    }
    text += formatsPage();
    return text + ".SH EXIT STATUS\n" + verbatim(program.get_footer());
}

/// Names of the subcommands of an app.
/// Names of commands that have subcommands.
std::vector<std::string> parentsOf(const CLI::App& program) {
    std::vector<std::string> parents;
    for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
        if (!subcommandsOf(*command).empty()) parents.push_back(command->get_name());
    return parents;
}

std::string bashCompletion(const CLI::App& program) {
    std::string below, options, values;  // entries of `case`: completions by command, and by command and option
    for (const Entry& entry : entriesOf(program)) {
        const std::vector<std::string> names = subcommandsOf(*entry.app);
        if (!names.empty()) below += "        '" + entry.name + "') words='" + concatenate(names, " ") + "' ;;\n";
        std::string words;
        forOptions(*entry.app, [&](const CLI::Option& option) {
            for (const std::string& name : namesOf(option)) {
                words += ' ' + name;
                const auto choices = choicesOf(option);
                if (!choices.empty())
                    values +=
                        "        '" + entry.name + ' ' + name + "') words='" + concatenate(choices, " ") + "' ;;\n";
            }
        });
        options += "        '" + entry.name + "') words='" + words + "' ;;\n";
    }
    return "# bash completion for betamesh; generated by `betamesh manual bash`.\n"
           "_betamesh() {\n"
           "    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
           "    local command=${COMP_WORDS[1]} words=\n"
           "    ((COMP_CWORD > 1)) || words='" +
           concatenate(subcommandsOf(program), " ") +
           " --help --version'\n"
           "    case $command in " +
           concatenate(parentsOf(program), "|") +
           ") ((COMP_CWORD < 3)) || command+=\" ${COMP_WORDS[2]}\" ;; esac\n"
           "    [[ -n $words ]] || case \"$command $before\" in\n" +
           values +
           "    esac\n"
           "    [[ -n $words ]] || case $command in\n" +
           below +
           "    esac\n"
           "    [[ -n $words || $current != -* ]] || case $command in\n" +
           options +
           "    esac\n"
           "    COMPREPLY=()\n"
           "    [[ -z $words ]] || mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
           "}\n"
           "complete -o default -F _betamesh betamesh\n";
}

/// Text escaped for single quotes and for _arguments, to which brackets and colons are special.
std::string zshText(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\'') out += "'\\''";
        if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
        if (c != '\'') out += c == '\n' ? ' ' : c;
    }
    return out;
}

std::string zshOptions(const CLI::App& app) {
    std::string text;
    forOptions(app, [&](const CLI::Option& option) {
        const auto choices = choicesOf(option);
        for (const std::string& name : namesOf(option)) {
            text += " \\\n            '*" + name + '[' + zshText(descriptionOf(option)) + ']';
            if (!choices.empty()) text += ":value:(" + concatenate(choices, " ") + ')';
            if (choices.empty() && takesValue(option)) text += ':' + zshText(placeholderOf(option)) + ":_files";
            text += '\'';
        }
    });
    return text + " \\\n            '*:file:_files'";
}

std::string zshCompletion(const CLI::App& program) {
    std::string commands, cases, below;
    for (const std::string& parent : parentsOf(program))
        below += "        " + parent + ") compadd " + concatenate(subcommandsOf(*program.get_subcommand(parent)), " ") +
                 " ;;\n";
    for (const Entry& entry : entriesOf(program)) {
        if (entry.name.find(' ') == std::string::npos)
            commands += " \\\n            '" + entry.name + ':' + zshText(entry.app->get_description()) + '\'';
        cases +=
            "        '" + entry.name + "')\n            _arguments" + zshOptions(*entry.app) + "\n            ;;\n";
    }
    return "#compdef betamesh\n"
           "# zsh completion for betamesh; generated by `betamesh manual zsh`.\n"
           "_betamesh() {\n"
           "    if ((CURRENT == 2)); then\n"
           "        local -a commands=(" +
           commands +
           ")\n"
           "        _describe command commands\n"
           "        return\n"
           "    fi\n"
           "    local command=$words[2]\n"
           "    shift words\n"
           "    ((CURRENT--))\n"
           "    if [[ $command == (" +
           concatenate(parentsOf(program), "|") +
           ") ]]; then\n"
           "        if ((CURRENT == 2)); then\n"
           "            case $command in\n" +
           below +
           "            esac\n"
           "            return\n"
           "        fi\n"
           "        command+=\" $words[2]\"\n"
           "        shift words\n"
           "        ((CURRENT--))\n"
           "    fi\n"
           "    case $command in\n" +
           cases +
           "    esac\n"
           "}\n"
           "_betamesh \"$@\"\n";
}

/// The first sentence: fish shows one line.
std::string firstSentence(const std::string& text) { return text.substr(0, text.find(". ")); }

/// Text in single quotes for fish, on one line.
std::string fishText(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'' || c == '\\') out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out + '\'';
}

/// The completion of the option of a command.
std::string fishOption(const std::string& command, const CLI::Option& option) {
    std::string text = "complete -c betamesh -n '__betamesh_is " + command + '\'';
    for (const std::string& name : option.get_snames()) text += " -s " + name;
    for (const std::string& name : option.get_lnames()) text += " -l " + name;
    const auto choices = choicesOf(option);
    if (takesValue(option)) text += choices.empty() ? " -r" : " -x -a " + fishText(concatenate(choices, " "));
    return text + " -d " + fishText(firstSentence(descriptionOf(option))) + '\n';
}

/// The completions of the subcommands of an app, offered where the command line has `command` and nothing else yet.
std::string fishSubcommands(const std::string& command, const CLI::App& app) {
    std::string text;
    for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; }))
        text += "complete -c betamesh -n '__betamesh_is " + command + "' -f -a " + below->get_name() + " -d " +
                fishText(below->get_description()) + '\n';
    return text;
}

std::string fishCompletion(const CLI::App& program) {
    std::string text =
        "# fish completion for betamesh; generated by `betamesh manual fish`.\n"
        "# Succeeds if the command line up to the cursor has this command.\n"
        "function __betamesh_is\n"
        "    set -l words (commandline -opc)\n"
        "    set -l command $words[2]\n"
        "    if contains -- \"$command\" " +
        concatenate(parentsOf(program), " ") +
        "\n"
        "        set command $words[2..3]\n"
        "    end\n"
        "    test \"$command\" = \"$argv\"\n"
        "end\n" +
        fishSubcommands("", program);
    forOptions(program, [&](const CLI::Option& option) { text += fishOption("", option); });
    for (const Entry& entry : entriesOf(program)) {
        text += fishSubcommands(entry.name, *entry.app);
        forOptions(*entry.app, [&](const CLI::Option& option) {
            if (!option.get_positional()) text += fishOption(entry.name, option);
        });
    }
    return text;
}

int printManual(const ManualArguments& arguments) {
    std::cout << (arguments.form == "man"    ? manPage(*arguments.program)
                  : arguments.form == "bash" ? bashCompletion(*arguments.program)
                  : arguments.form == "zsh"  ? zshCompletion(*arguments.program)
                                             : fishCompletion(*arguments.program));
    return kAllWritten;
}

}  // namespace

void addManualCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "manual", "Prints the man page or the completion for a shell.", printManual);
    command->footer(
        "Examples:\n"
        "  betamesh manual man | man -l -         # show the man page\n"
        "  source <(betamesh manual bash)         # complete commands and options in this bash\n"
        "  betamesh manual fish > ~/.config/fish/completions/betamesh.fish");
    arguments->program = &program;
    command->add_option("FORM", arguments->form, "man: the man page; otherwise the shell to complete for.")
        ->type_name("man|bash|zsh|fish")
        ->required()
        ->check(oneOf({"man", "bash", "zsh", "fish"}));
}

}  // namespace betamesh
