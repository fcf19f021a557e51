// Jobs that are killed, changed, run twice at a time and resumed: the files are always those of one undisturbed run.

#include "base/random.h"
#include "support/job_folder.h"

#include <algorithm>
#include <csignal>
#include <set>

namespace betamesh {
namespace {

class Resume : public JobFolder {
protected:
    /// The status of each frame with `--skip-existing`.
    std::map<int, std::string> actions(std::vector<std::string> further = {}) {
        further.insert(further.end(), {"--skip-existing", "--json"});
        const Outcome outcome = mesh(further);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        std::map<int, std::string> status;
        for (const Json& line : jsonLines(outcome.out)) status[line["frame"]] = line["status"];
        return status;
    }
    /// Exactly the frames of `expected` are meshed again.
    void expectAgain(const std::set<int>& expected, const std::vector<std::string>& further = {}) {
        const Outcome planned = [&] {
            std::vector<std::string> words = further;
            words.insert(words.end(), {"--skip-existing", "--dry-run", "--json"});
            return mesh(words);
        }();
        for (const Json& line : jsonLines(planned.out)) {
            EXPECT_EQ(line["action"] == "mesh", expected.contains(line["frame"])) << line;
            EXPECT_EQ(line.contains("why"), expected.contains(line["frame"]) && exists(line["output"])) << line;
        }
        for (const auto& [frame, status] : actions(further))
            EXPECT_EQ(status, expected.contains(frame) ? "ok" : "skipped") << frame;
        for (const auto& [frame, status] : actions(further)) EXPECT_EQ(status, "skipped") << frame;
    }
};

TEST_F(Resume, FramesAreMeshedAgainExactlyIfTheirManifestDoesNotMatch) {
    writeFrames(1, 4);
    ASSERT_EQ(mesh().exit_code, 0);
    const auto before = meshesIn("out");
    expectAgain({});
    expectAgain({}, {"-j", "1", "--frames-in-flight", "2", "--io-retries", "3", "--on-missing", "empty"});
    expectAgain({}, {"--retries", "7"});  // of float predicates, which are not used

    // The input: its time alone does not count, its content does.
    fs::last_write_time(folder_ / "in/a.0002.ply", fs::file_time_type::clock::now() + std::chrono::hours(1));
    expectAgain({});
    const std::string other = contentsOf(folder_ / "in/a.0004.ply");
    write(folder_ / "in/a.0003.ply", other);
    expectAgain({3});
    EXPECT_EQ(meshesIn("out").at("a.0003.ply"), before.at("a.0004.ply"));
    std::string changed = other;
    changed.back() = static_cast<char>(changed.back() ^ 1);  // as long as before, and a moment later
    write(folder_ / "in/a.0004.ply", changed);
    expectAgain({4});

    // What was written.
    fs::remove(folder_ / "out/a.0001.ply.json");
    expectAgain({1});
    write(folder_ / "out/a.0002.ply.json", contentsOf(folder_ / "out/a.0002.ply.json").substr(0, 300));
    expectAgain({2});
    fs::resize_file(folder_ / "out/a.0001.ply", 100);
    fs::remove(folder_ / "out/a.0002.ply");
    expectAgain({1, 2});
    Json older = manifest(3);
    older["origin"]["version"] = "0.0.1";
    write(folder_ / "out/a.0003.ply.json", older.dump());
    expectAgain({3});
    EXPECT_EQ(meshesIn("out").at("a.0001.ply"), before.at("a.0001.ply"));

    // The configuration, also where only what is measured in the first frame changes.
    expectAgain({1, 2, 3, 4}, {"--passes", "2"});
    expectAgain({1, 2, 3, 4}, {"--radius", "1.4dx"});
    writeFrames(1, 1, 600);
    expectAgain({1, 2, 3, 4});

    // Inputs that are gone do not take their meshes with them.
    for (int frame = 1; frame <= 4; ++frame) fs::remove(folder_ / numbered("in/a", frame, ".ply"));
    for (const auto& [frame, status] : actions({"--frames", "1-4"})) EXPECT_EQ(status, "skipped") << frame;
}

TEST_F(Resume, AnEmptyMeshOfAMissingFrameIsReplacedWhenTheFrameArrives) {
    writeFrames(1, 2);
    fs::rename(folder_ / "in/a.0002.ply", folder_ / "late.ply");
    ASSERT_EQ(mesh({"--frames", "1-2", "--on-missing", "empty"}).exit_code, 0);
    const auto statusOf = [&](int frame) { return actions({"--frames", "1-2", "--on-missing", "empty"}).at(frame); };
    EXPECT_EQ(statusOf(2), "skipped");
    fs::rename(folder_ / "late.ply", folder_ / "in/a.0002.ply");
    EXPECT_EQ(statusOf(2), "ok");
    EXPECT_EQ(statusOf(2), "skipped");
}

TEST_F(Resume, FilesBesideAnOutputThatNoRunOfItWroteAreKept) {
    Sample sample({"drop", 600, 1, 24});
    writeFrame(1, sample.frame(1));
    const std::string foreign = contentsOf(folder_ / "in/a.0001.ply");
    fs::create_directory(folder_ / "out");
    for (const char* name : {"out/a.0001.spheres.ply", "out/a.0001.ply.json"})
        for (const char* droplets : {"mesh", "points"}) {
            write(folder_ / name, foreign);
            const Outcome refused = mesh({"--droplets", droplets});
            EXPECT_EQ(refused.exit_code, 2) << name << droplets;
            EXPECT_NE(refused.err.find(std::string(name) + " already exists"), std::string::npos) << refused.err;
            EXPECT_EQ(contentsOf(folder_ / name), foreign);
            EXPECT_FALSE(exists("out/a.0001.ply"));
            fs::remove(folder_ / name);
        }

    // Spheres are removed only by the output that wrote them, also where others would have them in the same place.
    const std::string spheres = "out/a.0001.spheres.ply";
    ASSERT_EQ(mesh({"--droplets", "points"}, "out/a.####.obj").exit_code, 0);
    const std::string before = contentsOf(folder_ / spheres);
    EXPECT_EQ(mesh({"--droplets", "points"}).exit_code, 2);
    const Outcome replaced = mesh({"--droplets", "mesh", "--overwrite"});
    EXPECT_EQ(replaced.exit_code, 0);
    EXPECT_NE(replaced.err.find(spheres + ": is kept"), std::string::npos) << replaced.err;
    EXPECT_EQ(contentsOf(folder_ / spheres), before);
    EXPECT_EQ(mesh({"--droplets", "mesh", "--overwrite"}, "out/a.####.obj").exit_code, 0);
    EXPECT_FALSE(exists(spheres));

    // What an earlier run left does not hinder the next one.
    ASSERT_EQ(mesh({"--droplets", "points", "--overwrite"}).exit_code, 0);
    fs::remove(folder_ / "out/a.0001.ply");
    EXPECT_EQ(mesh({"--droplets", "points"}).exit_code, 0);
    fs::remove(folder_ / "out/a.0001.ply");
    fs::remove(folder_ / "out/a.0001.ply.json");
    EXPECT_EQ(mesh({"--droplets", "points", "--skip-existing"}).exit_code, 0);
    EXPECT_EQ(contentsOf(folder_ / spheres), before);
}

/// A process may be killed after it has written its last manifest and before it removes its lock.
TEST_F(Resume, NoHiddenFilesRemainBesideFinishedFrames) {
    writeFrames(1, 2);
    ASSERT_EQ(mesh().exit_code, 0);
    write(folder_ / "out/.a.0002.ply.betamesh-lock", "");
    for (const auto& [frame, status] : actions()) EXPECT_EQ(status, "skipped") << frame;
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Resume, AJobKilledAtAnyMomentIsCompletedToTheSameBytes) {
    constexpr int kFrames = 12, kKillsARound = 5, kRounds = kSanitized ? 2 : 10, kMostAttempts = 50;
    Sample sample({"drop", 1500, 1, 24});
    for (int frame = 1; frame <= kFrames; ++frame) writeFrame(frame, sample.frame(frame));
    const std::vector<std::string> words{"mesh",       "in/a.####.ply", "out/a.####.ply",     "--skip-existing",
                                         "--droplets", "points",        "--frames-in-flight", "3"};
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(runProgram(words, folder_.path()).exit_code, 0);
    const auto whole_run = std::chrono::steady_clock::now() - begin;
    const auto undisturbed = meshesIn("out");
    ASSERT_EQ(undisturbed.size(), 2U * kFrames);  // meshes and spheres

    int killed = 0;
    for (int round = 0; round < kRounds; ++round) {
        SCOPED_TRACE(round);
        fs::remove_all(folder_ / "out");
        Random random(static_cast<std::uint64_t>(round));
        for (int kills = 0, attempts = 0; kills < kKillsARound && attempts < kMostAttempts; ++attempts) {
            RunningProgram program(words, folder_.path());
            if (attempts > 0) std::this_thread::sleep_for(whole_run * random.between(0, 0.5));  // the first at once
            program.send(SIGKILL);
            if (program.wait().exit_code != -SIGKILL) {  // it had ended already: start over
                fs::remove_all(folder_ / "out");
                continue;
            }
            ++kills, ++killed;
            for (int frame = 1; frame <= kFrames; ++frame) {
                // Files are complete, and if there is a manifest, all files of the frame exist.
                for (const std::string& name : {numbered("a", frame, ".ply"), numbered("a", frame, ".spheres.ply")}) {
                    if (exists("out/" + name)) {
                        EXPECT_TRUE(contentsOf(folder_ / ("out/" + name)) == undisturbed.at(name)) << name;
                    } else {
                        EXPECT_FALSE(exists(numbered("out/a", frame, ".ply.json"))) << name;
                    }
                }
            }
        }
        ASSERT_EQ(runProgram(words, folder_.path()).exit_code, 0);
        EXPECT_TRUE(meshesIn("out") == undisturbed);
        EXPECT_EQ(hiddenFiles("out"), 0U);
        for (int frame = 1; frame <= kFrames; ++frame) EXPECT_EQ(manifest(frame)["status"], "ok");
    }
    EXPECT_EQ(killed, kRounds * kKillsARound);
}

/// Stops all threads of a process. A signal takes effect some time after it was sent.
void stop(pid_t process) {
    kill(process, SIGSTOP);
    const auto isRunning = [](const fs::directory_entry& task) {
        const std::string text = contentsOf(task.path() / "stat");
        const std::size_t state = text.rfind(") ") + 2;
        return text.size() > state && text[state] != 'T' && text[state] != 'Z' && text[state] != 'X';
    };
    std::error_code ended;
    for (int attempt = 0; attempt < 5000; ++attempt) {
        const fs::directory_iterator tasks("/proc/" + std::to_string(process) + "/task", ended);
        if (ended || std::none_of(begin(tasks), end(tasks), isRunning)) return;
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
}

TEST_F(Resume, TemporaryFilesOfAKilledProcessAreRemoved) {
    writeFrames(1, 24, 3000);
    const auto stopWhen = [](RunningProgram& program, const auto& isSo) {
        for (int attempt = 0; attempt < 50000; ++attempt) {
            const pid_t worker = program.worker();
            if (worker > 0) stop(worker);
            if (isSo()) return worker;
            if (worker > 0) kill(worker, SIGCONT);
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        return pid_t{-1};
    };
    const auto hasHalfWritten = [&] {
        for (const auto& entry : fs::directory_iterator(folder_ / "out"))
            if (entry.path().extension() == ".betamesh-tmp") return true;
        return false;
    };
    fs::create_directory(folder_ / "out");
    RunningProgram other({"mesh", "in/a.####.ply", "out/a.####.ply"}, folder_.path());
    ASSERT_GT(stopWhen(other, hasHalfWritten), 0);
    RunningProgram program({"mesh", "in/a.####.ply", "out/b.####.ply"}, folder_.path());
    const pid_t worker = stopWhen(program, [&] { return exists("out/b.0001.ply") || exists("out/b.0002.ply"); });
    ASSERT_GT(worker, 0);
    ASSERT_TRUE(hasHalfWritten());
    other.send(SIGKILL);
    other.wait();
    kill(worker, SIGCONT);
    EXPECT_EQ(program.wait().exit_code, 0);
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Resume, IfTwoProcessesWriteAFrameOneCompleteSetOfFilesWins) {
    constexpr int kFrames = 6;
    Sample sample({"drop", 600, 1, 24});
    for (int frame = 1; frame <= kFrames; ++frame) writeFrame(frame, sample.frame(frame));
    const auto words = [](const std::string& output, const std::string& passes, const std::string& droplets) {
        return std::vector<std::string>{
            "mesh",       "in/a.####.ply", output + "/a.####.ply", "--passes",           passes,
            "--droplets", droplets,        "--overwrite",          "--frames-in-flight", "3"};
    };
    const auto one = words("out", "1", "points"), two = words("out", "2", "mesh");  // only the first has spheres
    std::map<std::string, std::map<std::string, std::string>> expected;             // by configuration
    for (const auto& alone : {words("one", "1", "points"), words("two", "2", "mesh")}) {
        ASSERT_EQ(runProgram(alone, folder_.path()).exit_code, 0);
        const std::string folder = alone[2].substr(0, 3);
        const Json manifest = Json::parse(contentsOf(folder_ / (folder + "/a.0001.ply.json")));
        expected[manifest["origin"]["configuration"]] = meshesIn(folder);
    }
    ASSERT_EQ(expected.size(), 2U);
    for (int trial = 0; trial < (kSanitized ? 3 : 10); ++trial) {
        RunningProgram first(one, folder_.path());
        RunningProgram second(two, folder_.path());
        EXPECT_EQ(first.wait().exit_code, 0);
        EXPECT_EQ(second.wait().exit_code, 0);
        for (int frame = 1; frame <= kFrames; ++frame) {
            SCOPED_TRACE(std::to_string(trial) + ", frame " + std::to_string(frame));
            const auto& files = expected.at(manifest(frame)["origin"]["configuration"]);
            for (const std::string& name : {numbered("a", frame, ".ply"), numbered("a", frame, ".spheres.ply")}) {
                ASSERT_EQ(exists("out/" + name), files.contains(name)) << name;
                if (!files.contains(name)) continue;
                EXPECT_TRUE(contentsOf(folder_ / ("out/" + name)) == files.at(name)) << name;
            }
        }
        EXPECT_EQ(hiddenFiles("out"), 0U);
    }
}

}  // namespace
}  // namespace betamesh
