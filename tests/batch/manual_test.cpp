// The help, the man page and the completions show the options of every command.

#include "support/program.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

const std::vector<std::vector<std::string>> kCommands{{"mesh"},
                                                      {"run"},
                                                      {"sample"},
                                                      {"info"},
                                                      {"check"},
                                                      {"submit"},
                                                      {"report"},
                                                      {"config", "print"},
                                                      {"config", "presets"},
                                                      {"render"},
                                                      {"compare"},
                                                      {"coherence"},
                                                      {"manual"}};

std::string printed(const TemporaryFolder& folder, const std::vector<std::string>& words) {
    const Outcome outcome = runProgram(words, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out;
}

/// The long names of the options in a help text.
std::set<std::string> longOptions(const std::string& help) {
    std::set<std::string> names;
    static const std::regex option("(^|,| )(--[a-z][a-z-]*)[ ,\n]");
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("  -")) continue;
        line = line.substr(0, 30) + '\n';
        std::smatch found;
        if (std::regex_search(line, found, option)) names.insert(found[2]);
    }
    return names;
}

bool isInstalled(const char* program) {
    return std::system((std::string("command -v ") + program + " > /dev/null").c_str()) == 0;
}

TEST(Manual, ContainsEveryOptionOfEveryCommand) {
    const TemporaryFolder folder;
    std::string man = printed(folder, {"manual", "man"});
    for (std::size_t at = man.find("\\-"); at != std::string::npos; at = man.find("\\-", at)) man.erase(at, 1);
    const std::string bash = printed(folder, {"manual", "bash"}), zsh = printed(folder, {"manual", "zsh"});
    for (std::vector<std::string> words : kCommands) {
        words.push_back("--help-all");
        const auto options = longOptions(printed(folder, words));
        EXPECT_GE(options.size(), 1U) << words.front();
        for (const std::string& option : options)
            for (const std::string& text : {man, bash, zsh})
                EXPECT_TRUE(std::regex_search(text, std::regex(option + "[ \\['\n,]")))
                    << words.front() << ' ' << option;
    }
    EXPECT_EQ(runProgram({"manual", "fish"}, folder.path()).exit_code, 2);
}

TEST(Manual, HelpShowsTheOptionsUsedFirstAndHelpAllTheRest) {
    const TemporaryFolder folder;
    const std::string help = printed(folder, {"mesh", "--help"}), all = printed(folder, {"mesh", "--help-all"});
    EXPECT_NE(help.find("`betamesh mesh --help-all` shows all options."), std::string::npos) << help;
    EXPECT_EQ(all.find("shows all options"), std::string::npos) << all;
    EXPECT_EQ(longOptions(help),
              (std::set<std::string>{"--help", "--help-all", "--preset", "--frames", "--radius", "--spacing",
                                     "--dimension", "--skin", "--passes", "--attributes", "--threads", "--overwrite",
                                     "--skip-existing", "--dry-run"}));
    for (const char* group : {"Options", "Input", "Surface", "Smoothing", "Output", "Running", "Farm and log"}) {
        EXPECT_EQ(help.find(std::string("\n") + group + ":\n") != std::string::npos, std::string(group) == "Options");
        EXPECT_NE(all.find(std::string("\n") + group + ":\n"), std::string::npos) << group;
    }
    EXPECT_GT(all.find("\nDeprecated:\n"), all.find("\nFarm and log:\n"));
    for (const char* command : {"run", "render", "compare"}) {
        const std::string short_help = printed(folder, {command, "--help"});
        EXPECT_LE(longOptions(short_help).size(), 18U) << short_help;
        EXPECT_LT(longOptions(short_help).size(), longOptions(printed(folder, {command, "--help-all"})).size());
        EXPECT_NE(short_help.find(std::string("`betamesh ") + command + " --help-all`"), std::string::npos);
    }
    EXPECT_EQ(printed(folder, {"info", "--help"}).find("shows all options"), std::string::npos);
    const std::string check = printed(folder, {"check", "--help"});
    EXPECT_TRUE(longOptions(check).contains("--particles"));
    EXPECT_FALSE(longOptions(check).contains("--where"));
    EXPECT_NE(printed(folder, {"check", "--help-all"}).find("--where"), std::string::npos);
    EXPECT_NE(printed(folder, {"--help-all"}).find("--bubble-gap"), std::string::npos);
}

TEST(Manual, GroffHasNoWarnings) {
    if (!isInstalled("groff")) GTEST_SKIP() << "groff is not installed";
    const TemporaryFolder folder;
    write(folder / "betamesh.1", printed(folder, {"manual", "man"}));
    ASSERT_EQ(
        std::system(("groff -man -ww -Tutf8 " + folder / "betamesh.1" + " > " + folder / "text 2> " + folder / "faults")
                        .c_str()),
        0);
    EXPECT_EQ(contentsOf(folder / "faults"), "");
    EXPECT_GT(contentsOf(folder / "text").size(), 10'000U);
}

TEST(Manual, BashCompletes) {
    const TemporaryFolder folder;
    write(folder / "completion", printed(folder, {"manual", "bash"}));
    const auto completed = [&](const std::string& words) {
        const std::string script = "source " + folder / "completion" + "; COMP_WORDS=(" + words +
                                   "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _betamesh; echo \"${COMPREPLY[*]}\"";
        EXPECT_EQ(std::system(("bash -c '" + script + "' > " + folder / "said 2>&1").c_str()), 0);
        return contentsOf(folder / "said");
    };
    EXPECT_EQ(completed("betamesh me"), "mesh\n");
    EXPECT_EQ(completed("betamesh mesh --arc"), "--arc-subdivisions\n");
    EXPECT_EQ(completed("betamesh mesh a.vdb --surface \"\""), "beta alpha union\n");
    EXPECT_EQ(completed("betamesh run a.yaml --progress o"), "openjd\n");
    EXPECT_EQ(completed("betamesh config p"), "print presets\n");
    EXPECT_EQ(completed("betamesh mesh a.vdb --preset \"\""), "flip paper preview sph splash viscous\n");
    EXPECT_EQ(completed("betamesh config print --preset f"), "flip\n");
    EXPECT_EQ(completed("betamesh config print --s"), "--set\n");
    EXPECT_EQ(completed("betamesh submit a.yaml --to d"), "deadline\n");
    EXPECT_EQ(completed("betamesh mesh a.v"), "\n");  // files, by bash itself
}

TEST(Manual, ZshParsesItsCompletion) {
    if (!isInstalled("zsh")) GTEST_SKIP() << "zsh is not installed";
    const TemporaryFolder folder;
    write(folder / "_betamesh", printed(folder, {"manual", "zsh"}));
    EXPECT_EQ(std::system(("zsh -n " + folder / "_betamesh").c_str()), 0);
}

}  // namespace
}  // namespace betamesh
