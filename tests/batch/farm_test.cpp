// Checks what `submit` hands to farm engines: by their rules, with shells, and by running it.

#include "batch/farm/farm.h"

#include "base/random.h"
#include "batch/farm/command_words.h"
#include "batch/job/frames.h"
#include "betamesh/error.h"
#include "support/job_folder.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

std::vector<FrameTask> tasksOf(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    std::vector<FrameTask> tasks(count);
    for (std::size_t i = 0; i < count; ++i) {
        tasks[i].frame = static_cast<int>(10 + i);
        tasks[i].memory = random.below(4) == 0 ? 0 : random.below(2'000'000'000);
    }
    return tasks;
}

TEST(Farm, ChunksContainEveryFrameOnceInOrderAndCostAboutTheSame) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const std::vector<FrameTask> tasks = tasksOf(1 + random.below(300), seed);
        const std::size_t most = 1 + random.below(40);
        const auto chunks = chunksOfEqualCost(tasks, static_cast<int>(random.below(9)), random.between(0.1, 500), most);
        ASSERT_GE(chunks.size(), 1U);
        EXPECT_LE(chunks.size(), most);
        std::size_t next = 0;
        double total = 0, largest = 0, dearest = 0;
        for (const auto& chunk : chunks) {
            EXPECT_FALSE(chunk.empty());
            double cost = 0;
            for (const int frame : chunk) {
                ASSERT_EQ(frame, tasks.at(next).frame);
                const double of_frame = static_cast<double>(tasks[next++].memory);
                cost += of_frame;
                largest = std::max(largest, of_frame);
            }
            total += cost;
            dearest = std::max(dearest, cost);
        }
        EXPECT_EQ(next, tasks.size());
        EXPECT_LE(dearest, total / static_cast<double>(chunks.size()) * 1.5 + 2 * largest);

        const auto equal = chunksOfSize(tasks, most);
        EXPECT_EQ(equal.size(), (tasks.size() + most - 1) / most);
        EXPECT_EQ(equal.front().front(), tasks.front().frame);
        EXPECT_EQ(equal.back().back(), tasks.back().frame);
    }
}

TEST(Farm, FramesWithoutInputAreTasksOfTheirOwnWhereTheyMayBe) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        std::vector<FrameTask> tasks = tasksOf(1 + random.below(300), seed);
        constexpr std::array kMissing{FrameAction::fail_missing, FrameAction::skip_missing, FrameAction::write_empty};
        std::set<int> missing;
        for (FrameTask& task : tasks) {
            if (seed % 2 == 0 && random.below(2) == 0) continue;
            task.action = kMissing[random.below(3)];
            task.memory = 0;
            missing.insert(task.frame);
        }
        EXPECT_EQ(withoutInput(tasks), missing.size());
        const auto chunks = chunksOfEqualCost(tasks, 4, 1e6, tasks.size());
        if (seed % 2 == 1) {
            EXPECT_EQ(chunks.size(), tasks.size());
        }
        for (const auto& chunk : chunks)
            EXPECT_LE(std::ranges::count_if(chunk, [&](int frame) { return missing.contains(frame); }), 2);
        const std::size_t most = 1 + random.below(20);
        EXPECT_LE(chunksOfEqualCost(tasks, 4, 1e6, most).size(), most);
    }
}

TEST(Farm, AShellReadsQuotedWordsBackUnchanged) {
    const TemporaryFolder folder;
    const std::vector<std::string> words{"plain", "",     "two words", "it's",     "$HOME",
                                         "`ls`",  "a\"b", "*",         "#IFRAME#", "\\"};
    const std::string file = folder / "words";
    ASSERT_EQ(std::system(("printf '%s|' " + shellWords(words) + " > " + file).c_str()), 0);
    std::string expected;
    for (const std::string& word : words) expected += word + '|';
    EXPECT_EQ(contentsOf(file), expected);
}

/// Words that some shell, template or engine could take for something else.
const std::vector<std::string> kAwkwardWords{
    "plain",         "",           "two words", "it's",    "$HOME",   "${HOME}",  "`id`",
    "$(id)",         "a\"b",       "\"",        "*",       "?[a]",    "~",        "\\",
    "\\\\",          "end\\",      "a\\\"b",    "-x",      "--",      "#",        "a#b",
    "a;b",           "a&b|c>d",    "!history",  "=",       "a=b",     "100%",     "\xc3\xa4",
    "{{Param}}",     "}",          "{a",        "<QUOTE>", "z<0.25",  "#IFRAME#", "####",
    "line\nbreak",   "tab\there",  "\xff",      "'",       "''",      "\r",       "a\\\\\"b",
    "a,b",           "[x]",        ": y",       "- z",     "&anchor", "!tag",     "null",
    "\x1b[m",        "a\xc2\x85z",  // U+0085, U+2028: line breaks in YAML
    "a\xe2\x80\xa8z"};

/// A job with these words in its command line and folder.
FarmJob awkwardJob(const std::string& program, const std::vector<std::string>& words, const std::string& folder) {
    FarmJob job;
    job.name = words.empty() ? "name" : words[0];
    job.folder = folder;
    job.run = {program, "run"};
    job.run.insert(job.run.end(), words.begin(), words.end());
    job.report = {program, "report"};
    job.report.insert(job.report.end(), words.begin(), words.end());
    job.chunks = {{1, 2}, {3}};
    return job;
}

/// How .NET divides the arguments of a process: quotes group, and backslashes escape only before a quote.
std::vector<std::string> dividedByDotNet(const std::string& arguments) {
    std::vector<std::string> words;
    std::size_t i = 0;
    while (true) {
        while (i < arguments.size() && (arguments[i] == ' ' || arguments[i] == '\t')) ++i;
        if (i == arguments.size()) return words;
        std::string word;
        bool quoted = false;
        for (; i < arguments.size() && (quoted || (arguments[i] != ' ' && arguments[i] != '\t')); ++i) {
            std::size_t backslashes = 0;
            while (i + backslashes < arguments.size() && arguments[i + backslashes] == '\\') ++backslashes;
            if (i + backslashes < arguments.size() && arguments[i + backslashes] == '"') {
                word += std::string(backslashes / 2, '\\');
                i += backslashes;
                if (backslashes % 2 == 1)
                    word += '"';
                else
                    quoted = !quoted;
            } else if (backslashes > 0) {
                word += std::string(backslashes, '\\');
                i += backslashes - 1;
            } else {
                word += arguments[i];
            }
        }
        words.push_back(word);
    }
}

/// The text without the tokens of an engine, whose values follow.
std::string withTokens(std::string text, const std::vector<std::pair<std::string, std::string>>& values) {
    for (const auto& [token, value] : values)
        for (std::size_t at = text.find(token); at != std::string::npos; at = text.find(token, at + value.size()))
            text.replace(at, token.size(), value);
    return text;
}

/// Runs what engines run, with a program that records its arguments and the folder it is in.
class AwkwardWords : public ::testing::Test {
protected:
    void SetUp() override {
        write(program_, "#!/bin/bash\n{ printf '%s\\0' \"$PWD\" \"$@\"; } > " + record_ + "\n");
        fs::permissions(program_, fs::perms::owner_all);
        write(folder_ / "bin/deadlinecommand", "#!/bin/bash\nprintf '%s\\0' \"$@\" > " + record_ + "\n");
        fs::permissions(folder_ / "bin/deadlinecommand", fs::perms::owner_all);
    }

    int shell(const std::string& script, const std::string& variables = "") {
        write(folder_ / "script", script);
        return std::system(
            ("cd / && PATH=" + folder_ / "bin" + ":$PATH " + variables + " bash " + folder_ / "script").c_str());
    }

    /// The words that the program recorded.
    std::vector<std::string> recorded() const {
        std::vector<std::string> words;
        std::istringstream in(contentsOf(record_));
        for (std::string word; std::getline(in, word, '\0');) words.push_back(word);
        return words;
    }

    TemporaryFolder folder_;
    std::string program_ = folder_ / "pro gram's/be=ta/betamesh", record_ = folder_ / "record";
};

TEST_F(AwkwardWords, ReachTheProgramUnchangedOrAreRefused) {
    std::map<std::string, int> accepted;
    for (std::uint64_t seed = 0; seed < 120; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        std::vector<std::string> words;
        for (std::size_t i = 1 + random.below(3); i > 0; --i)
            words.push_back(kAwkwardWords[seed < kAwkwardWords.size() ? seed : random.below(kAwkwardWords.size())]);
        const std::string name = words[0].empty() || words[0].find('/') != std::string::npos ? "folder" : words[0];
        const std::string folder = folder_ / ("jobs/in " + name);
        fs::create_directories(folder);
        const std::string program = seed % 2 == 0 ? program_ : folder_ / "betamesh";
        fs::copy_file(program_, folder_ / "betamesh", fs::copy_options::overwrite_existing);
        const FarmJob job = awkwardJob(program, words, folder);
        std::vector<std::string> expected{folder, "run"};
        expected.insert(expected.end(), words.begin(), words.end());
        const auto expect = [&](const char* engine, std::vector<std::string> more) {
            ++accepted[engine];
            more.insert(more.begin(), expected.begin(), expected.end());
            EXPECT_EQ(recorded(), more) << engine;
        };
        const auto refuses = [](const auto& text) {
            try {
                text();
                return false;
            } catch (const Error& error) {
                const std::string why = error.what();
                EXPECT_TRUE(why.find(" contains ") != std::string::npos ||
                            why.find(" is not UTF-8") != std::string::npos)
                    << why;
                return true;
            }
        };

        EXPECT_EQ(shell(slurmArray(job), "SLURM_ARRAY_TASK_ID=1"), 0);
        expect("slurm", {"--frames", "1-2", "--skip-existing"});
        std::vector<std::string> report{folder, "report"};
        report.insert(report.end(), words.begin(), words.end());
        report.insert(report.end(), {"--frames", "1-3"});
        EXPECT_EQ(shell(slurmReport(job)), 0);
        EXPECT_EQ(recorded(), report);

        if (!refuses([&] { openCueCommand(job); })) {
            EXPECT_EQ(shell(withTokens(openCueCommand(job), {{"#FRAMESPEC#", "1-2"}})), 0);
            expect("opencue", {"--skip-existing", "--frames", "1-2"});
        }

        if (!refuses([&] { deadlineCommand(job); })) {
            EXPECT_EQ(shell(deadlineCommand(job)), 0);
            const std::vector<std::string> given = recorded();
            ASSERT_GE(given.size(), 5U);
            const std::string arguments =
                withTokens(given[4], {{"<QUOTE>", "\""}, {"<STARTFRAME>", "1"}, {"<ENDFRAME>", "2"}});
            std::vector<std::string> command = dividedByDotNet(arguments);
            command.insert(command.begin(), given[2]);
            EXPECT_EQ(shell(shellWords(command)), 0);
            expect("deadline", {"--skip-existing", "--frames", "1-2"});
        }

        if (!refuses([&] { openJobTemplate(job); })) {
            const std::string bundled = deadlineCloudBundle(job)[0].text;
            for (const std::string& text : {openJobTemplate(job), bundled}) {
                const auto commandOf = [&](std::size_t step) {
                    const YAML::Node action = YAML::Load(text)["steps"][step]["script"]["actions"]["onRun"];
                    std::vector<std::string> command{action["command"].Scalar()};
                    for (const auto& word : action["args"]) command.push_back(word.Scalar());
                    for (std::string& word : command)
                        word = withTokens(word, {{"{{Task.Param.Frame}}", "1-2"},
                                                 {"{{Param.Frames}}", "1-3:2"},
                                                 {"{{Param.Folder}}", folder}});
                    return shellWords(command);
                };
                EXPECT_EQ(shell(commandOf(0)), 0);
                expect("openjd", {"--skip-existing", "--progress", "openjd", "--frames", "1-2"});
                EXPECT_EQ(shell(commandOf(1)), 0);
                report.back() = "1-3x2";
                EXPECT_EQ(recorded(), report);
            }
            EXPECT_EQ(count(bundled, "jobs/in "), 0U) << bundled;  // the folder is a parameter
            EXPECT_EQ(YAML::Load(deadlineCloudBundle(job)[1].text)["parameterValues"][2]["value"].Scalar(), folder);
        }
    }
    EXPECT_EQ(accepted["slurm"], 120);
    for (const char* engine : {"opencue", "deadline", "openjd"}) EXPECT_GE(accepted[engine], 60) << engine;
}

/// How sbatch reads a line #SBATCH.
/// source  Slurm, src/sbatch/opt.c: a backslash escapes the next character, quotes group, # begins a comment
std::vector<std::string> readBySbatch(const std::string& line) {
    std::vector<std::string> words;
    std::string word;
    bool any = false, escaped = false;
    char quote = 0;
    for (const char c : line + ' ') {
        if (escaped) {
            word += c;
            any = true;
            escaped = false;
        } else if (c == '\\') {
            escaped = true;
        } else if (quote != 0) {
            if (c == quote)
                quote = 0;
            else
                word += c;
        } else if (c == '"' || c == '\'') {
            quote = c;
            any = true;
        } else if (c == '#') {
            break;
        } else if (c == ' ' || c == '\t') {
            if (any) words.push_back(word);
            word.clear();
            any = false;
        } else {
            word += c;
            any = true;
        }
    }
    return words;
}

TEST_F(AwkwardWords, OptionsOfSbatchAreInBothScripts) {
    for (const std::string& awkward : kAwkwardWords) {
        SCOPED_TRACE(awkward);
        FarmJob job = awkwardJob(program_, {}, "/");
        job.name = awkward;
        job.sbatch_options = {"-p", "long", "--comment=" + awkward, "--array=1-2%1"};
        const bool has_control = std::any_of(awkward.begin(), awkward.end(), [](unsigned char c) { return c < 32; });
        if (has_control) {
            EXPECT_THROW(slurmArray(job), Error);
            EXPECT_THROW(slurmReport(job), Error);
            continue;
        }
        for (const bool is_array : {true, false}) {
            std::istringstream script(is_array ? slurmArray(job) : slurmReport(job));
            std::vector<std::string> options;
            for (std::string line; std::getline(script, line);)
                if (line.starts_with("#SBATCH "))
                    for (const std::string& word : readBySbatch(line.substr(8))) options.push_back(word);
            EXPECT_EQ(options.front(), "--job-name=" + awkward + (is_array ? "" : "-report"));
            std::vector<std::string> expected{"-p", "long", "--comment=" + awkward};
            if (is_array) expected.emplace_back("--array=1-2%1");
            EXPECT_EQ(
                std::vector<std::string>(options.end() - static_cast<std::ptrdiff_t>(expected.size()), options.end()),
                expected);
        }
    }
}

class Submit : public JobFolder {
protected:
    void SetUp() override {
        writeFrames(1, 5);
        write(folder_ / "my job.yaml",
              "version: 1\ninput: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\nrun: {threads: 2}\n");
    }
    std::string submitted(const std::string& farm, const std::vector<std::string>& further = {}) {
        std::vector<std::string> words{"submit", "my job.yaml", "--to", farm, "--print", "--chunk-size", "2"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_FALSE(exists("out"));
        return outcome.out;
    }
    /// Runs a command in another folder, as farms do.
    int shell(const std::string& command) { return std::system(("cd / && " + command + " 2> /dev/null").c_str()); }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
    return text;
}

TEST_F(Submit, TheOpenCueCommandMeshesTheFramesOfItsToken) {
    const std::string command = submitted("opencue");
    const std::vector<std::string> dry_run{"submit",    "my job.yaml",  "--to", "opencue",
                                           "--dry-run", "--chunk-size", "2"};
    EXPECT_EQ(runProgram(dry_run, folder_.path()).out, command);
    EXPECT_NE(command.find(" #FRAMESPEC#"), std::string::npos) << command;
    EXPECT_EQ(shell(replaced(replaced(command, "\n", ""), "#FRAMESPEC#", "2-3")), 0);
    EXPECT_TRUE(absent(1) && written(2) && written(3) && absent(4));
}

TEST_F(Submit, TheDeadlineArgumentsMeshTheFramesOfTheirTokens) {
    const std::string command = submitted("deadline");
    std::smatch found;
    ASSERT_TRUE(
        std::regex_search(command, found, std::regex("-executable env -arguments '(.*)' -frames 1-5 -chunksize 2")))
        << command;
    const std::string arguments =
        replaced(replaced(replaced(found[1], "<QUOTE>", "\""), "<STARTFRAME>", "4"), "<ENDFRAME>", "5");
    EXPECT_EQ(shell("env " + arguments), 0);
    EXPECT_TRUE(absent(3) && written(4) && written(5));
}

TEST_F(Submit, TractorTasksAreChunksOfFramesAndThenTheReport) {
    const std::string job = submitted("tractor");
    EXPECT_EQ(count(job, "{"), count(job, "}"));
    for (const char* frames : {"{--frames} {1-2}}", "{--frames} {3-4}}", "{--frames} {5}}"})
        EXPECT_EQ(count(job, frames), 1U) << job;
    EXPECT_EQ(count(job, "{--progress} {tractor}"), 3U);
    EXPECT_GT(job.find("{report}"), job.rfind("{run}"));
}

/// The operators of Tractor's job scripts, as far as they concern what is run: they write a line `subtasks TITLE
/// [serial]` or `end`, and for each command its words, one a line, between `run TITLE` and an empty line. Options and
/// operators that Tractor does not know are errors.
/// source  Pixar's documentation of Tractor: Job Scripting Operators
constexpr const char* kTractor = R"tcl(
proc options {known words} {
    set given [dict create -subtasks {} -cmds {} -serialsubtasks 0 -title {}]
    foreach {option value} $words {
        if {$option ni $known} {error "no option $option"}
        dict set given $option $value
    }
    return $given
}
proc nested {title given} {
    set serial [expr {[dict get $given -serialsubtasks] ? " serial" : ""}]
    puts "subtasks $title$serial"
    eval [dict get $given -subtasks]
    puts end
    set ::title $title
    eval [dict get $given -cmds]
}
proc Job {args} {
    set given [options {-title -subtasks -serialsubtasks} $args]
    nested [dict get $given -title] $given
}
proc Task {title args} {nested $title [options {-subtasks -cmds -serialsubtasks} $args]}
proc RemoteCmd {launch args} {
    options -service $args
    puts "run $::title"
    foreach word $launch {puts $word}
    puts ""
}
)tcl";

TEST_F(Submit, TractorRunsTheTasksAsTclReadsThem) {
    if (std::system("command -v tclsh > /dev/null") != 0) GTEST_SKIP() << "no tclsh here";
    write(folder_ / "job.tcl", kTractor + submitted("tractor", {"--set", "input.velocity=$v [exit] \"x\"; #"}));
    ASSERT_EQ(shell("tclsh " + folder_ / "job.tcl" + " > " + folder_ / "said"), 0);
    std::istringstream said(contentsOf(folder_ / "said"));
    std::vector<std::string> order;
    std::map<std::string, std::vector<std::string>> commands;
    for (std::string line; std::getline(said, line);) {
        order.push_back(line);
        if (!line.starts_with("run ")) continue;
        for (std::string word; std::getline(said, word) && !word.empty();) commands[line].push_back(word);
    }
    EXPECT_EQ(order, (std::vector<std::string>{"subtasks my job serial", "subtasks Mesh", "subtasks frames 1-2", "end",
                                               "run frames 1-2", "subtasks frames 3-4", "end", "run frames 3-4",
                                               "subtasks frames 5", "end", "run frames 5", "end", "subtasks Report",
                                               "end", "run Report", "end"}));
    // What Tcl might replace stays as it is; without it the words do what they say.
    std::vector<std::string>& words = commands["run frames 3-4"];
    const auto strange = std::find(words.begin(), words.end(), "input.velocity=$v [exit] \"x\"; #");
    ASSERT_NE(strange, words.end()) << contentsOf(folder_ / "said");
    *strange = "input.velocity=v";
    EXPECT_EQ(shell(shellWords(words) + " > " + folder_ / "progress"), 0);
    EXPECT_TRUE(absent(2) && written(3) && written(4) && absent(5));
    EXPECT_EQ(contentsOf(folder_ / "progress"), "TR_PROGRESS 050%\nTR_PROGRESS 100%\n");
    EXPECT_NE(shell(shellWords(commands["run Report"])), 0);  // frames are missing, the page is there
    EXPECT_TRUE(exists("out/my job.html"));
}

TEST_F(Submit, TheSlurmScriptMeshesTheChunkOfItsTask) {
    write(folder_ / "array.sh", submitted("slurm", {"--no-report", "--set", "smoothing.passes=2"}));
    const std::string text = contentsOf(folder_ / "array.sh");
    for (const char* line :
         {"#SBATCH --array=1-3\n", "#SBATCH --requeue\n", "#SBATCH --cpus-per-task=2\n", "#SBATCH --mem="})
        EXPECT_EQ(count(text, line), 1U) << text;
    EXPECT_EQ(shell("SLURM_ARRAY_TASK_ID=2 bash " + folder_ / "array.sh"), 0);
    EXPECT_TRUE(absent(2) && written(3) && written(4) && absent(5));
    EXPECT_EQ(shell("SLURM_ARRAY_TASK_ID=3 bash " + folder_ / "array.sh"), 0);
    EXPECT_TRUE(written(5));
}

TEST_F(Submit, FramesOfASimulationThatIsStillToRunAreAllSubmitted) {
    for (const int on_disk : {5, 1, 0}) {
        SCOPED_TRACE(on_disk);
        for (int frame = on_disk + 1; frame <= 5; ++frame) fs::remove(folder_ / numbered("in/a", frame, ".ply"));
        const auto printed = [&](const std::vector<std::string>& further) {
            std::vector<std::string> words{"submit", "my job.yaml", "--to", "slurm", "--print"};
            words.insert(words.end(), further.begin(), further.end());
            return runProgram(words, folder_.path());
        };
        const Outcome named = printed({"--frames", "1-240"});
        EXPECT_EQ(named.exit_code, 0) << named.err;
        EXPECT_NE(named.out.find("#SBATCH --array=1-2" + std::string(on_disk == 5 ? "36" : "40")), std::string::npos)
            << named.out.substr(0, 300);
        EXPECT_EQ(count(named.out, "#SBATCH --mem="), 1U) << "of the report";
        EXPECT_NE(named.err.find(std::to_string(240 - on_disk) + " of 240 frames have no input yet"), std::string::npos)
            << named.err;
        EXPECT_EQ(count(printed({"--frames", "1-240", "--set", "run.memory_limit=1GiB"}).out, "#SBATCH --mem="), 2U);
        EXPECT_NE(printed({"--frames", "1-240", "--chunk-size", "10"}).out.find("--array=1-24\n"), std::string::npos);
        const Outcome unnamed = printed({});
        EXPECT_EQ(unnamed.exit_code, on_disk > 0 ? 0 : 2);
        EXPECT_NE(unnamed.err.find("with --frames"), std::string::npos) << unnamed.err;
    }
}

TEST_F(Submit, OptionsAfterTwoDashesReplaceDefaultsOfSlurm) {
    const std::string plain = submitted("slurm");
    for (const char* line : {"#SBATCH --time=60\n", "#SBATCH --mem=", "#SBATCH --cpus-per-task="})
        EXPECT_EQ(count(plain, line), 2U) << line;  // the array and the report
    EXPECT_EQ(count(plain, "#SBATCH --output=my\\ job.%A_%a.log\n"), 1U) << plain;
    EXPECT_EQ(count(plain, "#SBATCH --output=my\\ job.report.%j.log\n"), 1U) << plain;
    EXPECT_EQ(count(plain, "sbatch --dependency=afterany:"), 1U) << plain;
    const std::string changed =
        submitted("slurm", {"--", "--mem-per-cpu=2G", "--time=4:00:00", "--output=log.%j", "--cpus-per-task=3"});
    for (const char* option : {"--mem=", "--time=60", "--output=my", "--cpus-per-task=2", "--cpus-per-task=1"})
        EXPECT_EQ(count(changed, option), 0U) << changed;
    // A task of an hour by the estimate has twelve.
    FarmJob job;
    job.run = {"betamesh"};
    job.chunks = {{1}};
    job.longest_task_seconds = 3600;
    EXPECT_EQ(count(slurmArray(job), "#SBATCH --time=720\n"), 1U) << slurmArray(job);
}

/// Stands for sbatch: runs a script at once, the tasks of an array one after the other, and prints an id.
constexpr const char* kSbatch = R"(#!/bin/bash
script="${@: -1}"
printf '%s\n' "${*:1:$#-1}" >> "$SUBMISSIONS"
bash -n "$script" || exit
tasks=$(sed -n 's/^#SBATCH --array=1-//p' "$script")
for task in $(seq "${tasks:-1}"); do
    SLURM_ARRAY_TASK_ID=$task bash "$script" >> "$SUBMISSIONS.log" 2>&1 || exit
done
echo "77;cluster"
)";

TEST_F(Submit, ScriptsThatSbatchRunsEndWithTheMeshesOfALocalRun) {
    ASSERT_EQ(mesh({}, "local/a.####.ply").exit_code, 0);
    write(folder_ / "bin/sbatch", kSbatch);
    fs::permissions(folder_ / "bin/sbatch", fs::perms::owner_all);
    const std::vector<std::string> environment{"PATH=" + folder_ / "bin" + ":" + std::getenv("PATH"),
                                               "SUBMISSIONS=" + folder_ / "submissions"};
    for (const bool by_script : {false, true}) {
        SCOPED_TRACE(by_script);
        std::vector<std::string> words{"submit", "my job.yaml", "--to", "slurm", "--chunk-size", "2"};
        if (by_script) words.insert(words.end(), {"-o", "some scripts"});
        words.insert(words.end(), {"--set", "run.retries=2", "--", "--output=log", "--account=water works"});
        const Outcome outcome = runProgram(words, folder_.path(), environment);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        std::string expected =
            "--parsable --output=log --account=water works\n--parsable --output=log "
            "--account=water works --dependency=afterany:77\n";
        if (by_script) {
            EXPECT_FALSE(exists("out"));
            for (const char* name : {"my job.array.sh", "my job.report.sh", "my job.submit.sh"})
                EXPECT_EQ(shell("bash -n '" + folder_ / ("some scripts/" + std::string(name)) + "'"), 0) << name;
            EXPECT_EQ(shell("env " + shellWords(environment) + " bash '" + folder_ / "some scripts/my job.submit.sh'"),
                      0);
            expected = "--parsable\n--dependency=afterany:77\n";
            const std::string scripts = contentsOf(folder_ / "some scripts/my job.array.sh") +
                                        contentsOf(folder_ / "some scripts/my job.report.sh");
            EXPECT_EQ(count(scripts, "#SBATCH --output=log --account=water\\ works\n"), 2U) << scripts;
        }
        EXPECT_EQ(contentsOf(folder_ / "submissions"), expected);
        ASSERT_TRUE(exists("out/my job.html")) << contentsOf(folder_ / "submissions.log");
        auto meshes = meshesIn("out");
        meshes.erase("my job.html");
        EXPECT_TRUE(meshes == meshesIn("local"));
        fs::remove_all(folder_ / "out");
        fs::remove(folder_ / "submissions");
    }
}

TEST_F(Submit, TheReportCoversAllOutputs) {
    write(folder_ / "my job.yaml",
          "version: 1\ninput: {path: in/a.####.ply}\noutputs:\n- {path: out/a.####.ply}\n"
          "- {path: rough/b.####.ply, surface: {radius: 2dx}}\n");
    EXPECT_EQ(count(submitted("slurm"), " report 'out/a.####.ply.json' 'rough/b.####.ply.json' -o 'out/my job.html' "),
              1U);
}

TEST_F(Submit, ABundleOfDeadlineCloudListsItsFiles) {
    write(folder_ / "base.yaml", "version: 1\nsmoothing: {passes: 2}\n");
    write(folder_ / "my job.yaml",
          "version: 1\ninclude: base.yaml\ninput: {path: in/a.####.ply}\n"
          "output: {path: out/a.####.ply}\npreview: {path: look/a.####.png}\n");
    const Outcome outcome =
        runProgram({"submit", "my job.yaml", "--to", "deadline-cloud", "--frames", "1-5x2"}, folder_.path());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("absolute"), std::string::npos) << outcome.err;
    EXPECT_NE(runProgram({"submit", folder_ / "my job.yaml", "--to", "deadline-cloud", "--print"}, folder_.path())
                  .err.find("my job.yaml: this path is absolute"),
              std::string::npos);
    const std::string bundle = folder_ / "my job.deadline-cloud";
    const YAML::Node root = YAML::LoadFile(bundle + "/template.yaml");
    const YAML::Node references = YAML::LoadFile(bundle + "/asset_references.yaml")["assetReferences"];
    const std::string folder = fs::canonical(folder_.path()).string();
    std::vector<std::string> inputs, outputs;
    for (const char* name : {"base.yaml", "in/a.0001.ply", "in/a.0003.ply", "in/a.0005.ply", "my job.yaml"})
        inputs.push_back(folder + '/' + name);
    EXPECT_EQ(references["inputs"]["filenames"].as<std::vector<std::string>>(), inputs);
    EXPECT_EQ(references["outputs"]["directories"].as<std::vector<std::string>>(),
              (std::vector<std::string>{folder + "/look", folder + "/out"}));
    std::map<std::string, std::string> values;
    for (const auto& entry : YAML::LoadFile(bundle + "/parameter_values.yaml")["parameterValues"])
        values[entry["name"].Scalar()] = entry["value"].Scalar();
    EXPECT_EQ(values,
              (std::map<std::string, std::string>{{"Folder", folder}, {"Frames", "1-5:2"}, {"FramesPerTask", "3"}}));
    for (const auto& definition : root["parameterDefinitions"])
        EXPECT_EQ(values.erase(definition["name"].Scalar()), 1U);
    // A file where the folder would be is not replaced.
    const Outcome refused =
        runProgram({"submit", "my job.yaml", "--to", "deadline-cloud", "-o", "base.yaml"}, folder_.path());
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_TRUE(fs::is_regular_file(folder_ / "base.yaml"));
}

TEST_F(Submit, OpenJobDescriptionsKeepAGivenChunkSize) {
    const auto chunks = [](const std::string& text) {
        return YAML::Load(text)["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["chunks"];
    };
    EXPECT_FALSE(chunks(submitted("openjd"))["targetRuntimeSeconds"]);
    const Outcome by_duration =
        runProgram({"submit", "my job.yaml", "--to", "openjd", "--print", "--task-minutes", "3"}, folder_.path());
    EXPECT_EQ(chunks(by_duration.out)["targetRuntimeSeconds"].as<int>(), 180);
}

TEST(Farm, OpenJobDescriptionsRefuseMoreFramesThanAParameterHolds) {
    FarmJob job;
    job.run = {"betamesh", "run"};
    job.chunks.emplace_back();
    for (int i = 0; i < 300; ++i) job.chunks[0].push_back(i * i * 3);  // no two gaps alike
    try {
        openJobTemplate(job);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("at most 1024"), std::string::npos) << error.what();
    }
}

TEST_F(Submit, PrintsTheOptionsAfterTwoDashes) {
    const std::string text = submitted("slurm", {"--", "--partition=long", "--time", "4:00:00"});
    EXPECT_EQ(count(text, "#SBATCH --partition=long --time 4:00:00\n"), 2U) << text;  // the array and the report
}

/// The rules of the 2023-09 schema and its TASK_CHUNKING extension that concern what is written.
class OpenJobRules {
public:
    static void keys(const YAML::Node& node, const std::set<std::string>& needed,
                     const std::set<std::string>& allowed) {
        ASSERT_TRUE(node.IsMap());
        for (const std::string& key : needed) EXPECT_TRUE(node[key]) << key;
        for (const auto& row : node)
            EXPECT_TRUE(needed.contains(row.first.Scalar()) || allowed.contains(row.first.Scalar()))
                << row.first.Scalar();
    }
    static void name(const YAML::Node& node, std::size_t most) {
        EXPECT_GE(node.Scalar().size(), 1U);
        EXPECT_LE(node.Scalar().size(), most);
        for (const char c : node.Scalar()) EXPECT_FALSE(std::iscntrl(static_cast<unsigned char>(c)));
    }
    static void identifier(const YAML::Node& node) {
        EXPECT_TRUE(std::regex_match(node.Scalar(), std::regex("[A-Za-z_][A-Za-z0-9_]{0,63}"))) << node.Scalar();
    }
    /// Every {{reference}} is one of these.
    static void references(const YAML::Node& node, const std::set<std::string>& known) {
        static const std::regex reference(R"(\{\{\s*([A-Za-z0-9_.]*)\s*\}\})");
        const std::string text = node.Scalar();
        for (auto found = std::sregex_iterator(text.begin(), text.end(), reference); found != std::sregex_iterator();
             ++found)
            EXPECT_TRUE(known.contains((*found)[1])) << text;
        EXPECT_EQ(count(text, "{{"),
                  static_cast<std::size_t>(std::distance(std::sregex_iterator(text.begin(), text.end(), reference),
                                                         std::sregex_iterator())));
    }
    static void action(const YAML::Node& node, const std::set<std::string>& known) {
        keys(node, {"command"}, {"args", "timeout", "cancelation"});
        EXPECT_FALSE(node["command"].Scalar().empty());
        for (const auto& word : node["args"]) {
            references(word, known);
            for (const char c : word.Scalar()) EXPECT_FALSE(std::iscntrl(static_cast<unsigned char>(c)));
        }
        keys(node["cancelation"], {"mode"}, {"notifyPeriodInSeconds"});
        EXPECT_EQ(node["cancelation"]["mode"].Scalar(), "NOTIFY_THEN_TERMINATE");
        EXPECT_GE(node["cancelation"]["notifyPeriodInSeconds"].as<int>(), 1);
        EXPECT_LE(node["cancelation"]["notifyPeriodInSeconds"].as<int>(), 600);
    }
};

TEST_F(Submit, OpenJobDescriptionsFollowTheSchema) {
    const std::string text = submitted("openjd", {"--frames", "1-5x2", "--set", "smoothing.passes=2"});
    const YAML::Node root = YAML::Load(text);
    using Rules = OpenJobRules;
    Rules::keys(root, {"specificationVersion", "name", "steps"},
                {"extensions", "description", "parameterDefinitions", "jobEnvironments"});
    EXPECT_EQ(root["specificationVersion"].Scalar(), "jobtemplate-2023-09");
    EXPECT_EQ(root["extensions"].as<std::vector<std::string>>(), std::vector<std::string>{"TASK_CHUNKING"});
    Rules::name(root["name"], 128);

    std::set<std::string> known;
    for (const auto& parameter : root["parameterDefinitions"]) {
        Rules::identifier(parameter["name"]);
        EXPECT_TRUE(known.insert("Param." + parameter["name"].Scalar()).second);
        const bool number = parameter["type"].Scalar() == "INT";
        EXPECT_TRUE(number || parameter["type"].Scalar() == "STRING");
        Rules::keys(parameter, {"name", "type"}, {"description", "default", number ? "minValue" : "minLength"});
    }
    EXPECT_EQ(root["parameterDefinitions"][0]["default"].Scalar(), "1-5:2");
    EXPECT_LE(root["parameterDefinitions"].size(), 50U);

    std::set<std::string> environments;
    for (const auto& environment : root["jobEnvironments"]) {
        Rules::keys(environment, {"name", "script"}, {"description", "variables"});
        Rules::name(environment["name"], 64);
        EXPECT_TRUE(environments.insert(environment["name"].Scalar()).second);
        Rules::keys(environment["script"]["actions"], {"onEnter"}, {"onExit"});
        Rules::action(environment["script"]["actions"]["onEnter"], known);
    }
    EXPECT_FALSE(environments.empty());

    std::set<std::string> steps;
    for (const auto& step : root["steps"]) {
        Rules::keys(step, {"name", "script"},
                    {"description", "dependencies", "stepEnvironments", "hostRequirements", "parameterSpace"});
        Rules::name(step["name"], 64);
        for (const auto& dependency : step["dependencies"])
            EXPECT_TRUE(steps.contains(dependency["dependsOn"].Scalar())) << dependency;
        EXPECT_TRUE(steps.insert(step["name"].Scalar()).second);
        if (const YAML::Node host = step["hostRequirements"]) {
            for (const auto& amount : host["amounts"]) {
                const std::string name = amount["name"].Scalar();
                EXPECT_TRUE(name == "amount.worker.vcpu" || name == "amount.worker.memory") << name;
                EXPECT_GT(amount["min"].as<double>(), 0);
            }
        }
        std::set<std::string> in_step = known;
        if (const YAML::Node space = step["parameterSpace"]) {
            for (const auto& parameter : space["taskParameterDefinitions"]) {
                Rules::identifier(parameter["name"]);
                in_step.insert("Task.Param." + parameter["name"].Scalar());
                Rules::keys(parameter, {"name", "type", "range", "chunks"}, {});
                EXPECT_EQ(parameter["type"].Scalar(), "CHUNK[INT]");
                Rules::references(parameter["range"], known);
                Rules::keys(parameter["chunks"], {"defaultTaskCount", "rangeConstraint"}, {"targetRuntimeSeconds"});
                Rules::references(parameter["chunks"]["defaultTaskCount"], known);
                EXPECT_EQ(parameter["chunks"]["rangeConstraint"].Scalar(), "CONTIGUOUS");
            }
        }
        Rules::keys(step["script"]["actions"], {"onRun"}, {});
        Rules::action(step["script"]["actions"]["onRun"], in_step);
    }
    EXPECT_EQ(steps, (std::set<std::string>{"Mesh", "Report"}));

    // And its words do what they say.
    std::vector<std::string> words{root["steps"][0]["script"]["actions"]["onRun"]["command"].Scalar()};
    for (const auto& word : root["steps"][0]["script"]["actions"]["onRun"]["args"])
        words.push_back(replaced(word.Scalar(), "{{Task.Param.Frame}}", "3-3"));
    EXPECT_EQ(shell(shellWords(words) + " > " + folder_ / "said"), 0);
    EXPECT_TRUE(absent(1) && written(3) && absent(5));
    EXPECT_NE(contentsOf(folder_ / "said").find("openjd_progress: 100"), std::string::npos);
}

TEST_F(Submit, FilesAreReplacedOnlyOnRequest) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{"openjd", "-o", "job.tcl"}, "job.tcl"},
        {{"openjd"}, "my job.openjd.yaml"},
        {{"tractor", "-o", "job.tcl"}, "job.tcl"},
        {{"slurm", "-o", "scripts"}, "scripts/my job.report.sh"},
        {{"deadline-cloud"}, "my job.deadline-cloud/asset_references.yaml"}};
    for (const auto& [further, file] : cases) {
        SCOPED_TRACE(further[0] + ' ' + file);
        const fs::path folder = fs::path(folder_ / file).parent_path();
        fs::create_directories(folder);
        write(folder_ / file, "mine");
        std::vector<std::string> words{"submit", "my job.yaml", "--to"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome refused = runProgram(words, folder_.path());
        EXPECT_EQ(refused.exit_code, 2);
        EXPECT_NE(refused.err.find(file + " already exists. Use --overwrite"), std::string::npos) << refused.err;
        EXPECT_EQ(contentsOf(folder_ / file), "mine");
        if (file.find('/') != std::string::npos) {
            EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "other files are written";
        }
        words.emplace_back("--overwrite");
        EXPECT_EQ(runProgram(words, folder_.path()).exit_code, 0);
        EXPECT_NE(contentsOf(folder_ / file), "mine");
    }
}

TEST_F(Submit, WrongUsageSubmitsNothing) {
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"submit", "my job.yaml"},
                                               {"submit", "my job.yaml", "--to", "farmville"},
                                               {"submit", "absent.yaml", "--to", "opencue"},
                                               {"submit", "my job.yaml", "--to", "opencue", "--", "--wait"},
                                               {"submit", "my job.yaml", "--to", "opencue", "--frames", "1:5"},
                                               {"submit", "my job.yaml", "--to", "opencue", "--set", "surface.radus=1"},
                                               {"submit", "my job.yaml", "--to", "openjd", "--program", "{{x}}"}})
        EXPECT_EQ(runProgram(words, folder_.path()).exit_code, 2) << words.back();
    EXPECT_EQ(runProgram({"submit", "my job.yaml", "--to", "openjd", "-o", "t.yaml"}, folder_.path()).exit_code, 0);
    EXPECT_TRUE(YAML::LoadFile(folder_ / "t.yaml")["steps"].IsSequence());
}

}  // namespace
}  // namespace betamesh
