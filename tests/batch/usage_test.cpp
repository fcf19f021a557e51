// What the program answers to a wrong command line, and how it writes to terminals.

#include "support/job_folder.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

namespace betamesh {
namespace {

struct WrongUsage {
    std::vector<std::string> words;
    std::vector<std::string> answers;  ///< parts of the error
};

const std::vector<WrongUsage> kWrongUsages{
    {{}, {"betamesh needs a command: mesh, run, ", " or manual."}},
    {{"mehs"}, {"betamesh has no command 'mehs'. Did you mean 'mesh'? The commands are mesh, run, "}},
    {{"frobnicate"}, {"betamesh has no command 'frobnicate'. The commands are mesh, "}},
    {{"--verison"}, {"betamesh has no option '--verison'. Did you mean '--version'?"}},
    {{"mesh"}, {"betamesh mesh needs IN and OUT. Usage: betamesh mesh IN OUT [options].", "`betamesh mesh --help`"}},
    {{"mesh", "a.ply"}, {"betamesh mesh needs OUT."}},
    {{"mesh", "a.ply", "b.ply", "c.ply"}, {"betamesh mesh does not expect the argument 'c.ply'.", "####"}},
    {{"mesh", "a.ply", "b.ply", "--radus", "1"}, {"no option '--radus'. Did you mean '--radius'?", "--help-all"}},
    {{"mesh", "a.ply", "b.ply", "1dx", "--radus"}, {"no option '--radus'. Did you mean '--radius'?"}},
    {{"mesh", "--radus=1", "a.ply"}, {"no option '--radus'. Did you mean '--radius'?"}},
    {{"mesh", "a.ply", "b.ply", "-q=3"}, {"betamesh mesh has no option '-q=3'."}},
    {{"mesh", "a.ply", "b.ply", "--radius"}, {"--radius needs a value: LENGTH. Ball radius:"}},
    {{"mesh", "a.ply", "b.ply", "-j"}, {"--threads needs a value: N."}},
    {{"mesh", "a.ply", "b.ply", "--radius", "1", "--radius", "2"}, {"--radius is given 2 times, with 1 and 2."}},
    {{"mesh", "a.ply", "b.ply", "--overwrite", "--skip-existing"}, {"--overwrite and --skip-existing"}},
    {{"mesh", "a.ply", "b.ply", "--smoothing", "cohernt"}, {"'cohernt'", "coherent, paper, none", "mean 'coherent'?"}},
    {{"mesh", "a.ply", "b.ply", "--preset", "flp"}, {"'flp'", "Did you mean 'flip'?"}},
    {{"mesh", "a.ply", "b.ply", "--progress", "tracto"}, {"'tracto'", "auto, bar", "Did you mean 'tractor'?"}},
    {{"mesh", "a.ply", "b.ply", "--set", "surface.radus=1"}, {"'surface.radus'", "'surface.radius'"}},
    {{"mesh", "a.ply", "b.plu"}, {"b.plu: '.plu' is not a format for meshes.", ".bgeo", "Did you mean '.ply'?"}},
    {{"mesh", "a.ply", "b"}, {"b: the name has no extension", ".bgeo"}},
    {{"mesh", "a.ply", "b/"}, {"b/: the name has no extension", "as in b/name.####.ply."}},
    {{"convert", "a.ply", "b"}, {"b: the name has no extension", "as in b/name.####.ply."}},
    {{"mesh", "a.ply", "b.svg"}, {"b.svg", "surface.dimension 3", "--dimension 2"}},
    {{"mesh", "a.ply", "b.vdb", "--dimension", "2"}, {"b.vdb: '.vdb' is not a format for curves."}},
    {{"mesh", "a.ply", "b.ply", "--format", "ply"}, {"--format is for OUT '-'"}},
    {{"mesh", "a.ply", "-", "--format", "plly"}, {"--format: 'plly' is not valid.", "Did you mean 'ply'?"}},
    {{"run"}, {"betamesh run needs PIPELINE."}},
    {{"run", "a.ply"}, {"a.ply: this is a file of particles or meshes (.ply), not a pipeline file (.yaml)."}},
    {{"run", "absent.yaml"}, {"absent.yaml: No such file or directory. Give the path of a pipeline file (.yaml)."}},
    {{"sample", "jiter", "s.ply"}, {"'jiter'", "dambreak", "Did you mean 'jitter'?"}},
    {{"sample", "jitter", "a.ply", "--particles", "abc"},
     {"--particles: 'abc' is not valid. Use a whole number of at"}},
    {{"sample", "jitter", "b.ply", "--particles", "1000000000000"},
     {"--particles 1000000000000 need about ", " GiB, but there are ", "Use at most "}},
    {{"sample", "jitter", "a.ply", "--particles", "-3"}, {"--particles: '-3' is not valid."}},
    {{"sample", "jitter", "a.ply", "--seed", "1.5"}, {"--seed: '1.5' is not valid. Use a whole number of at least 0."}},
    {{"info"}, {"betamesh info needs FILE."}},
    {{"info", "none.####.ply"}, {"'none.####.ply': no such file on disk. Expected names such as none.0001.ply"}},
    {{"check", "none.####.ply"}, {"'none.####.ply': no such file on disk."}},
    {{"check", "--ovrwrite", "a.ply"}, {"no option '--ovrwrite'. See `betamesh check --help-all`."}},
    {{"info", "--ovrwrite", "a.ply"}, {"no option '--ovrwrite'. Its options are ", "--json"}},
    {{"check", "a.ply", "--radius", "3"}, {"--radius has no meaning without --particles. Add --particles IN."}},
    {{"check", "a.ply", "--tolerance", "-1"}, {"--tolerance: '-1' is not valid. Use a number of at least 0."}},
    {{"coherence", "none.####.ply"}, {"'none.####.ply': no such file on disk."}},
    {{"coherence", "--pipeline", "a.yaml"}, {"--pipeline has no meaning without --frame. Add --frame F."}},
    {{"coherence", "a.ply", "--max-jump", "x"}, {"--max-jump: 'x' is not valid."}},
    {{"render", "none.####.ply", "a.####.png"}, {"'none.####.ply': no such file on disk."}},
    {{"render", "a.ply", "a.jpg"}, {"a.jpg", ".png or .exr"}},
    {{"compare", "none.####.ply", "a.####.png"}, {"'none.####.ply': no such file on disk."}},
    {{"compare", "a.ply", "a.png", "--columns", "1000"},
     {"--columns: '1000' is not valid. Use a whole number from 1 to"}},
    {{"config"}, {"betamesh config needs a command: print, check or presets."}},
    {{"config", "prnt"}, {"betamesh config has no command 'prnt'. Did you mean 'print'?"}},
    {{"submit", "a.yaml"}, {"betamesh submit needs --to. Usage: betamesh submit PIPELINE --to slurm|"}},
    {{"submit", "a.yaml", "--to", "slrm"}, {"'slrm'", "slurm, openjd", "Did you mean 'slurm'?"}},
    {{"report", "none.####.ply.json", "-o", "a.html"}, {"'none.####.ply.json': no such file on disk."}},
    {{"report", "none.json", "-o", "a.html"}, {"none.json: no such file."}},
    {{"report", "*.ply.json", "-o", "a.html"}, {"*.ply.json: no such file.", "such as NAME.####.ply.json"}},
    {{"manual", "fush"}, {"FORM: 'fush' is not valid. Use one of man, bash, zsh, fish. Did you mean 'fish'?"}},
};

TEST(Usage, EveryWrongCommandLineIsAnsweredInOneLineThatHelps) {
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "jitter", "a.ply", "--particles", "60", "-q"}, folder.path()).exit_code, 0);
    for (const WrongUsage& usage : kWrongUsages) {
        std::string line = "betamesh";
        for (const std::string& word : usage.words) line += ' ' + word;
        SCOPED_TRACE(line);
        const Outcome outcome = runProgram(usage.words, folder.path());
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(count(outcome.err, "\n"), 1U) << outcome.err;
        EXPECT_LT(outcome.err.size(), 600U) << outcome.err;
        EXPECT_NE(outcome.err.find(" error: "), std::string::npos) << outcome.err;
        for (const std::string& part : usage.answers)
            EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    }
    EXPECT_FALSE(fs::exists(folder / "a.html") || fs::exists(folder / "b.ply"));
}

TEST(Usage, HelpIsAWordAsWellAsAnOption) {
    const TemporaryFolder folder;
    const auto run = [&](const std::vector<std::string>& words) { return runProgram(words, folder.path()); };
    EXPECT_EQ(run({"help"}).out, run({"--help"}).out);
    EXPECT_EQ(run({"help", "mesh"}).exit_code, 0);
    EXPECT_EQ(run({"help", "mesh"}).out, run({"mesh", "--help"}).out);
    EXPECT_EQ(run({"help", "mehs"}).exit_code, 2);
}

TEST(Usage, TheVersionHasAShortOption) {
    const TemporaryFolder folder;
    const Outcome outcome = runProgram({"-V"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.out, runProgram({"--version"}, folder.path()).out);
}

/// What the program writes to stderr if that is a terminal.
std::string onTerminal(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) return "";
    const std::string name = ptsname(terminal);
    const pid_t process = fork();
    if (process == 0) {
        const int side = open(name.c_str(), O_RDWR | O_NOCTTY);
        dup2(side, STDERR_FILENO);
        std::vector<std::string> settings = environment, all{BETAMESH_PROGRAM};
        for (std::string& setting : settings) putenv(setting.data());
        all.insert(all.end(), words.begin(), words.end());
        std::vector<char*> arguments;
        for (std::string& word : all) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        execv(arguments[0], arguments.data());
        _exit(127);
    }
    std::string text;
    pollfd wait{terminal, POLLIN, 0};
    char block[4096];
    while (poll(&wait, 1, 60000) > 0) {
        const ssize_t got = read(terminal, block, sizeof block);
        if (got <= 0) break;
        text.append(block, static_cast<std::size_t>(got));
    }
    waitpid(process, nullptr, 0);
    close(terminal);
    return text;
}

TEST(Usage, ColoursAreForTerminalsAndNotIfTheEnvironmentRefusesThem) {
    const TemporaryFolder folder;
    const std::vector<std::string> words{"info", folder / "absent.ply"};
    const std::string colourful = onTerminal(words, {"TERM=xterm-256color", "NO_COLOR="});
    if (colourful.empty()) GTEST_SKIP() << "no terminal can be made here";
    EXPECT_NE(colourful.find("\x1b["), std::string::npos) << colourful;
    const std::string plain = onTerminal(words, {"TERM=xterm-256color", "NO_COLOR=1"});
    EXPECT_NE(plain.find("absent.ply"), std::string::npos);
    EXPECT_EQ(plain.find('\x1b'), std::string::npos) << plain;
    EXPECT_EQ(runProgram(words, folder.path(), {"TERM=xterm-256color"}).err.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace betamesh
