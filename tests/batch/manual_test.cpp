// The help, the man page and the completions show the options of every command.

#include "io/extension.h"
#include "support/program.h"

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

const std::vector<std::vector<std::string>> kCommands{
    {"mesh"},   {"run"},     {"convert"},   {"sample"},          {"info"},
    {"check"},  {"submit"},  {"report"},    {"config", "print"}, {"config", "presets"},
    {"render"}, {"compare"}, {"coherence"}, {"manual"}};

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
    const std::string fish = printed(folder, {"manual", "fish"});
    for (std::vector<std::string> words : kCommands) {
        words.push_back("--help-all");
        const auto options = longOptions(printed(folder, words));
        EXPECT_GE(options.size(), 1U) << words.front();
        const std::string command = words.size() > 2 ? words[0] + ' ' + words[1] : words[0];
        for (const std::string& option : options)
            EXPECT_TRUE(std::regex_search(
                fish, std::regex("'__betamesh_is " + command + "'( -s [^ ]+)* -l " + option.substr(2) + "[ \n]")))
                << command << ' ' << option;
        for (const std::string& option : options)
            for (const std::string& text : {man, bash, zsh})
                EXPECT_TRUE(std::regex_search(text, std::regex(option + "[ \\['\n,]")))
                    << words.front() << ' ' << option;
    }
    EXPECT_EQ(runProgram({"manual", "csh"}, folder.path()).exit_code, 2);
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

TEST(Manual, ListsEveryFormatWithItsTestAndItsProof) {
    const TemporaryFolder folder;
    const std::string man = printed(folder, {"manual", "man"});
    const std::size_t begin = man.find(".SH FORMATS");
    ASSERT_NE(begin, std::string::npos);
    const std::string formats = man.substr(begin, man.find(".SH", begin + 1) - begin);
    for (const FileFormat& format : fileFormats())
        for (const std::string_view part : {format.name, format.proof})
            EXPECT_NE(formats.find(part), std::string::npos) << part;
    EXPECT_NE(formats.find("Read: .vtp .vtu (particles, meshes, curves). Written: .vtp"), std::string::npos) << formats;
    EXPECT_NE(formats.find("(test golden.ForeignFiles)"), std::string::npos) << formats;
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
    EXPECT_EQ(completed("betamesh submit a.yaml --to d"), "deadline-cloud deadline\n");
    EXPECT_EQ(completed("betamesh mesh a.v"), "\n");  // files, by bash itself
}

TEST(Manual, FishCompletes) {
    if (!isInstalled("fish")) GTEST_SKIP() << "fish is not installed";
    const TemporaryFolder folder;
    write(folder / "completion", printed(folder, {"manual", "fish"}));
    const auto completed = [&](const std::string& line) {
        write(folder / "ask", "source " + folder / "completion" + "\ncomplete -C '" + line + "'\n");
        EXPECT_EQ(
            std::system(("cd " + folder.path().string() + "; HOME=$PWD fish --no-config ask > said 2> faults").c_str()),
            0);
        EXPECT_EQ(contentsOf(folder / "faults"), "");
        std::set<std::string> words;
        std::istringstream lines(contentsOf(folder / "said"));
        for (std::string found; std::getline(lines, found);) words.insert(found.substr(0, found.find('\t')));
        return words;
    };
    using Words = std::set<std::string>;
    EXPECT_EQ(completed("betamesh me"), Words{"mesh"});
    EXPECT_EQ(completed("betamesh mesh --arc"), Words{"--arc-subdivisions"});
    EXPECT_EQ(completed("betamesh mesh a.vdb --surface "), (Words{"alpha", "beta", "union"}));
    EXPECT_EQ(completed("betamesh run a.yaml --progress o"), Words{"openjd"});
    EXPECT_EQ(completed("betamesh config p"), (Words{"presets", "print"}));
    EXPECT_EQ(completed("betamesh config print --s"), Words{"--set"});
    EXPECT_EQ(completed("betamesh config check --str"), Words{});  // an option of `betamesh check`
    EXPECT_EQ(completed("betamesh submit a.yaml --to d"), Words{"deadline"});
}

/// As far as this can be told without fish: every line is one of the few forms, and every quote is closed.
TEST(Manual, FishCompletionIsWellFormed) {
    const TemporaryFolder folder;
    std::istringstream lines(printed(folder, {"manual", "fish"}));
    static const std::regex form(
        R"(complete -c betamesh -n '__betamesh_is [a-z ]*'( -s [A-Za-z])*( -l [a-z-]+)?( -r| -x -a '[^']*'| -f -a [a-z]+)? -d '([^'\\]|\\['\\])*')");
    std::size_t completions = 0;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("complete")) continue;
        ++completions;
        EXPECT_TRUE(std::regex_match(line, form)) << line;
    }
    EXPECT_GT(completions, 200U);
}

TEST(Manual, ZshParsesItsCompletion) {
    if (!isInstalled("zsh")) GTEST_SKIP() << "zsh is not installed";
    const TemporaryFolder folder;
    write(folder / "_betamesh", printed(folder, {"manual", "zsh"}));
    EXPECT_EQ(std::system(("zsh -n " + folder / "_betamesh").c_str()), 0);
}

/// A command in the documentation.
struct Example {
    std::string source, line;
};

/// The lines of a text that begin with the name of the program. `begin`: what they have before it.
void addExamples(const std::string& source, const std::string& text, const std::string& begin,
                 std::vector<Example>& examples) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with(begin + "betamesh ")) examples.push_back({source, line.substr(begin.size())});
}

/// The contents of the code blocks of a language, one after the other.
std::vector<std::string> codeBlocks(const std::string& markdown, const std::string& language) {
    std::vector<std::string> blocks;
    std::istringstream lines(markdown);
    bool inside = false, wanted = false;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("```")) {
            inside = !inside;
            wanted = inside && line == "```" + language;
            if (wanted) blocks.emplace_back();
        } else if (wanted) {
            blocks.back() += line + '\n';
        }
    }
    return blocks;
}

/// The example with as little to compute as possible, and without programs that are not installed here.
std::string reduced(const Example& example) {
    std::string line = example.line.substr(0, example.line.find("  #"));
    line = std::regex_replace(line, std::regex("--particles [0-9]+"), "--particles 60");
    line = std::regex_replace(line, std::regex("--frames 1-240"), "--frames 1-48");
    const auto add = [&](const char* option, const std::string& more) {
        if (line.find(option) != std::string::npos) return;
        const std::size_t end = std::min({line.size(), line.find(" -- "), line.find(" <"), line.find(" >")});
        line.insert(end, more);
    };
    if (line.starts_with("betamesh sample ")) add("--particles", " --particles 60");
    if (line.starts_with("betamesh sample ")) add("--frames", " --frames 1-2");
    if (line.starts_with("betamesh render ") || line.starts_with("betamesh compare ")) {
        add("--width", " --width 64 --height 48");
        add("--samples", line.starts_with("betamesh render ") ? " --samples 1" : "");
    }
    if (line.starts_with("betamesh run pipelines/"))
        add("preview.width", " --set preview.width=64 --set preview.height=48");
    if (!isInstalled("ffmpeg")) line = std::regex_replace(line, std::regex(" --movie [^ ]+"), "");
    if (!isInstalled("man")) line = std::regex_replace(line, std::regex(" \\| man -l -"), " > page");
    return line;
}

/// Files that examples name, with few particles: a simulation of 48 frames and its meshes.
class Examples : public ::testing::Test {
protected:
    void SetUp() override {
        write(folder_ / "bin/sbatch", "#!/bin/sh\necho 1\n");
        std::filesystem::permissions(folder_ / "bin/sbatch", std::filesystem::perms::owner_all);
        std::filesystem::create_symlink(BETAMESH_PROGRAM, folder_ / "bin/betamesh");
        std::filesystem::create_directories(folder_ / "files/.config/fish/completions");
        write(folder_ / "files/splash.yaml",
              "version: 1\ninput: {path: sim/splash.####.vdb}\nframes: 1-48\noutput: {path: mesh/splash.####.ply}\n");
        write(folder_ / "files/look.yaml", "version: 1\n");
        std::filesystem::copy(BETAMESH_SOURCE "/pipelines", folder_ / "files/pipelines",
                              std::filesystem::copy_options::recursive);
        for (const char* line :
             {"betamesh sample drop sim/splash.####.vdb --frames 1-48 --particles 60",
              "betamesh mesh sim/splash.####.vdb mesh/splash.####.ply", "betamesh sample drop drop.bgeo --particles 60",
              "betamesh sample drop splash.0012.bgeo --particles 60",
              "betamesh sample drop splash.0012.ply --particles 60",
              "betamesh sample drop splash.0012.bgeo.sc --particles 60",
              "betamesh sample drop flip.0012.vdb --particles 60",
              "betamesh sample puddle sim/puddle.####.ply --frames 1-48 --particles 60",
              "betamesh sample drop sim/dam.####.vdb --frames 1-24 --particles 60",
              "betamesh mesh sim/dam.####.vdb mesh/dam.####.ply"})
            ASSERT_EQ(run(line), 0) << line << contentsOf(folder_ / "said");
        for (const char* name : {"dambreak", "rotcube", "drop"}) {
            const std::string stem = std::string("demo/") + name + ".####.vdb";
            ASSERT_EQ(run(std::string("betamesh sample ") + name + ' ' + stem + " --frames 1-2 --particles 60"), 0);
            ASSERT_EQ(run("betamesh mesh " + stem + " demo/mesh/" + name + ".####.ply"), 0);
        }
    }

    /// Runs a line in the folder of the files. Returns its exit code.
    int run(const std::string& line) {
        write(folder_ / "line.sh",
              "cd " + folder_ / "files" + " && export HOME=$PWD PATH=" + folder_ / "bin" + ":$PATH && " + line + '\n');
        const int status = std::system(
            ("timeout 300 bash " + folder_ / "line.sh" + " > " + folder_ / "said 2>&1 < /dev/null").c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    TemporaryFolder folder_;
};

TEST_F(Examples, OfTheManualAndTheReadmesRun) {
    std::vector<Example> examples;
    for (const std::vector<std::string>& words : kCommands) {
        std::vector<std::string> help = words;
        help.emplace_back("--help");
        addExamples(words[0] + " --help", printed(folder_, help), "  ", examples);
    }
    const std::size_t in_help = examples.size();
    EXPECT_GE(in_help, 20U);
    for (const char* file : {"README.md", "pipelines/README.md", "docker/README.md"})
        for (const std::string& block : codeBlocks(contentsOf(BETAMESH_SOURCE "/" + std::string(file)), "sh"))
            addExamples(file, block, "", examples);
    EXPECT_GE(examples.size(), in_help + 20);
    for (const char* name : {"dambreak", "rotcube", "drop"}) {
        const std::string file = "pipelines/" + std::string(name) + ".yaml";
        addExamples(file, contentsOf(BETAMESH_SOURCE "/" + file), "#   ", examples);
    }
    for (const Example& example : examples) {
        const std::string line = reduced(example);
        SCOPED_TRACE(example.source + ": " + line);
        // A command that makes meshes or samples refuses to replace those that other examples need.
        const bool writes = std::regex_search(line, std::regex("^betamesh (mesh|run|sample|render|compare|convert) "));
        const bool resumes = line.find("--skip-existing") != std::string::npos || line.find(" - ") != std::string::npos;
        const int exit_code = run(line + (writes && !resumes ? " --overwrite" : ""));
        // Coherence and reports exit with 1 for what they find.
        const bool may_find = std::regex_search(line, std::regex("^betamesh (coherence|report|check .*--particles) "));
        EXPECT_TRUE(exit_code == 0 || (may_find && exit_code == 1)) << exit_code << '\n'
                                                                    << contentsOf(folder_ / "said");
    }
}

TEST_F(Examples, PipelineFilesInTheReadmesAreValid) {
    std::size_t found = 0;
    for (const char* file : {"README.md", "pipelines/README.md"})
        for (const std::string& block : codeBlocks(contentsOf(BETAMESH_SOURCE "/" + std::string(file)), "yaml")) {
            ++found;
            write(folder_ / "files/block.yaml", block);
            EXPECT_EQ(run("betamesh config check block.yaml"), 0) << block << contentsOf(folder_ / "said");
        }
    EXPECT_GE(found, 2U);
}

}  // namespace
}  // namespace betamesh
