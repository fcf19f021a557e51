// Faults of disks, servers, simulations and libraries during a job. Each is reported with the name of its file, all
// other frames are written, and no file is left incomplete.

#include "base/random.h"
#include "io/mesh_file.h"
#include "support/job_folder.h"

#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <set>
#include <stdexcept>

namespace betamesh {
namespace {

class Faults : public JobFolder {
protected:
    static constexpr int kFrames = 6;

    void SetUp() override { writeFrames(1, kFrames); }

    /// Expects that these frames failed with an error each, and that all others are complete.
    void expectOnlyThese(const std::set<int>& failed, const Outcome& outcome) {
        EXPECT_EQ(outcome.exit_code, failed.empty() ? 0 : 1) << outcome.err;
        for (int frame = 1; frame <= kFrames; ++frame) {
            SCOPED_TRACE(frame);
            EXPECT_TRUE(failed.contains(frame) ? absent(frame) : written(frame)) << outcome.err;
            if (failed.contains(frame)) {
                EXPECT_NE(outcome.err.find("frame " + std::to_string(frame) + ": "), std::string::npos) << outcome.err;
            } else {
                EXPECT_EQ(manifest(frame)["status"], "ok");
            }
        }
        EXPECT_EQ(hiddenFiles("out"), 0U);
    }

    /// The environment in which opening this file never ends.
    static std::vector<std::string> stallingAt(const std::string& file) {
        return {"LD_PRELOAD=" BETAMESH_FAULT_SHIM, "BETAMESH_FAULT=open:stall:" + file};
    }

    /// The environment in which a signal ends the program at this call on this file.
    static std::vector<std::string> endingAt(int signal, const std::string& file, const std::string& call = "open") {
        return {"LD_PRELOAD=" BETAMESH_FAULT_SHIM,
                "BETAMESH_FAULT=" + call + ":-" + std::to_string(signal) + ':' + file};
    }
};

TEST_F(Faults, BrokenInputsInTheMiddleFailAlone) {
    fs::resize_file(folder_ / "in/a.0002.ply", fs::file_size(folder_ / "in/a.0002.ply") - 7);
    write(folder_ / "in/a.0003.ply", "");
    writeFrameWithNaN(4);
    fs::remove(folder_ / "in/a.0005.ply");
    const Outcome outcome = mesh({"--frames", "1-6"});
    expectOnlyThese({2, 3, 4, 5}, outcome);
    for (const int frame : {2, 3, 4, 5})
        EXPECT_NE(outcome.err.find(numbered("in/a", frame, ".ply") + ": "), std::string::npos) << outcome.err;
}

TEST_F(Faults, InputsThatVanishAfterPlanningFailAlone) {
    const int last = 100;
    for (int frame = kFrames + 1; frame <= last; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "2"}, folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(1); }));
    fs::remove(folder_ / numbered("in/a", last, ".ply"));
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("frame 100: in/a.0100.ply: cannot be read"), std::string::npos) << outcome.err;
    for (int frame = 1; frame < last; ++frame) EXPECT_TRUE(written(frame)) << frame;
    EXPECT_TRUE(absent(last));
}

TEST_F(Faults, CallsThatFailAreNamedTriedAgainAndHarmNoOtherFrame) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    struct Fault {
        const char* call;
        int error;
        const char* name;
        int of_one_attempt = 1;  ///< number of such calls per attempt
    };
    for (const Fault& fault :
         {Fault{"write", ENOSPC, "a.0003.ply"}, Fault{"write", EIO, "a.0003.ply"}, Fault{"fsync", EIO, "a.0003.ply"},
          Fault{"rename", EDQUOT, "a.0003.ply"}, Fault{"open", EACCES, "in/a.0003.ply"},
          Fault{"open", EROFS, "out/.a.0003.ply", 2}, Fault{"read", EIO, "in/a.0003.ply"},
          Fault{"read", ESTALE, "in/a.0003.ply"}, Fault{"write", ENOSPC, "a.0003.ply.json"}}) {
        SCOPED_TRACE(std::string(fault.call) + ' ' + fault.name + ' ' + std::strerror(fault.error));
        const std::string setting =
            std::string("BETAMESH_FAULT=") + fault.call + ':' + std::to_string(fault.error) + ':' + fault.name;
        const auto run = [&](const std::string& times, const std::string& retries) {
            fs::remove_all(folder_ / "out");
            return runProgram({"mesh", "in/a.####.ply", "out/a.####.ply", "--io-retries", retries}, folder_.path(),
                              {"LD_PRELOAD=" BETAMESH_FAULT_SHIM, setting + times});
        };
        const Outcome always = run("", "1");
        EXPECT_NE(always.err.find(std::strerror(fault.error)), std::string::npos) << always.err;
        if (std::string(fault.name)
                .ends_with(".json")) {  // the mesh exists, but without a report it counts as incomplete
            EXPECT_EQ(always.exit_code, 1);
            EXPECT_TRUE(exists("out/a.0003.ply") && !exists("out/a.0003.ply.json"));
        } else {
            expectOnlyThese({3}, always);
        }
        const std::string once = ':' + std::to_string(fault.of_one_attempt);
        expectOnlyThese({}, run(once, "1"));
        EXPECT_EQ(run(once, "0").exit_code, 1);
    }
}

TEST_F(Faults, WithoutAThreadForWritingTheThreadOfTheFrameWrites) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    for (const int thread : {6, 7, 8}) {  // before: four of OpenVDB's log, one that waits for signals
        SCOPED_TRACE(thread);
        fs::remove_all(folder_ / "out");
        expectOnlyThese(
            {}, runProgram({"mesh", "in/a.####.ply", "out/a.####.ply", "-j", "1", "--io-retries", "0"}, folder_.path(),
                           {"LD_PRELOAD=" BETAMESH_FAULT_SHIM, "BETAMESH_FAULT=thread:" + std::to_string(EAGAIN) +
                                                                   ":thread/" + std::to_string(thread) + '/'}));
    }
}

/// Libraries crash, systems run out of memory.
TEST_F(Faults, AFrameThatEndsItsProcessFailsAlone) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    struct End {
        int signal;
        const char* call;  ///< at which the process ends
        std::string name;
        int frame;
    };
    for (const End& end : {End{SIGSEGV, "open", "in/a.0003.ply", 3}, End{SIGKILL, "open", "in/a.0003.ply", 3},
                           End{SIGABRT, "read", "in/a.0001.ply", 1},    // while the spacing is measured
                           End{SIGFPE, "write", "out/.a.0001.ply", 1},  // while it is written, after it was measured
                           End{SIGBUS, "rename", "out/a.0006.ply", 6}}) {
        SCOPED_TRACE(std::string(end.call) + ' ' + end.name);
        fs::remove_all(folder_ / "out");
        const Outcome outcome =
            runProgram({"mesh", "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "3", "-j", "2", "--json"},
                       folder_.path(), endingAt(end.signal, end.name, end.call));
        EXPECT_EQ(outcome.exit_code, end.signal == SIGKILL ? 33 : 1) << outcome.err;
        std::set<int> told;
        for (const Json& line : jsonLines(outcome.out)) {
            EXPECT_TRUE(told.insert(line["frame"].get<int>()).second) << line;
            EXPECT_EQ(line["status"], line["frame"] == end.frame ? "failed" : "ok") << line;
        }
        EXPECT_EQ(told.size(), static_cast<std::size_t>(kFrames)) << outcome.err;
        const bool measured = end.call != std::string("read");
        EXPECT_EQ(count(outcome.err, "(measured in frames 1, 4 and 6,") > 0, measured) << outcome.err;
        EXPECT_EQ(count(outcome.err, "(measured in frames 2, 4 and 6,") == 0, measured) << outcome.err;
        EXPECT_NE(outcome.err.find(numbered("in/a", end.frame, ".ply: ") + "the process that worked on it was ended"),
                  std::string::npos)
            << outcome.err;
        EXPECT_NE(outcome.err.find("5 of 6 frames written, 0 skipped, 1 failed"), std::string::npos) << outcome.err;
        for (int frame = 1; frame <= kFrames; ++frame)
            EXPECT_TRUE(frame == end.frame ? absent(frame) : written(frame)) << frame;
        EXPECT_EQ(hiddenFiles("out"), 0U);
    }
}

/// Commands that inspect several files go on after one that ends their process, and report each file once.
TEST_F(Faults, AFileThatEndsItsProcessIsAnErrorOfTheCommandThatReadsIt) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    ASSERT_EQ(mesh().exit_code, 0);
    std::vector<std::string> info{"info", "--json"}, check{"check", "--json", "--particles", "in/a.####.ply"};
    for (int frame = 1; frame <= kFrames; ++frame) {
        info.push_back(numbered("in/a", frame, ".ply"));
        check.push_back(numbered("out/a", frame, ".ply"));
    }
    for (const std::vector<std::string>& words : {info, check})
        for (const int signal : {SIGABRT, SIGKILL})
            for (const int frame : {1, 4}) {
                SCOPED_TRACE(words[0] + ' ' + std::to_string(signal) + ' ' + std::to_string(frame));
                const std::string file = numbered("in/a", frame, ".ply");
                const Outcome outcome = runProgram(words, folder_.path(), endingAt(signal, file));
                EXPECT_EQ(outcome.exit_code, signal == SIGKILL ? 33 : 1) << outcome.err;
                EXPECT_EQ(count(outcome.err, "error: "), 1U) << outcome.err;
                EXPECT_EQ(count(outcome.err, file + ": the process that worked on it was ended"), 1U) << outcome.err;
                std::set<std::string> told;
                for (const Json& line : jsonLines(outcome.out))
                    EXPECT_TRUE(told.insert(line["file"].get<std::string>()).second) << line;
                EXPECT_EQ(told.size(), kFrames - (words[0] == "info" ? 1U : 0U)) << outcome.out;
            }
}

TEST_F(Faults, AFileThatEndsItsProcessIsAnErrorWhereMotionIsMeasured) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    ASSERT_EQ(mesh({"--frames", "1-4"}).exit_code, 0);
    write(folder_ / "job.yaml",
          "version: 1\ninput: {path: in/a.####.ply}\noutput: {path: b.####.ply}\nsurface: {spacing: 0.1}\n");
    const Outcome files = runProgram({"coherence", "out/a.####.ply", "--particles", "in/a.####.ply"}, folder_.path(),
                                     endingAt(SIGABRT, "in/a.0003.ply"));
    EXPECT_EQ(files.exit_code, 1);
    EXPECT_EQ(count(files.err, "out/a.0003.ply, or its particles: the process that worked on it"), 1U) << files.err;
    const Outcome steps =
        runProgram({"coherence", "--pipeline", "job.yaml", "--frame", "3", "--step", "1e-3", "--steps", "1"},
                   folder_.path(), endingAt(SIGABRT, "in/a.0003.ply"));
    EXPECT_EQ(steps.exit_code, 2);
    EXPECT_EQ(count(steps.err, "in/a.0003.ply: the process that worked on it was ended"), 1U) << steps.err;
}

TEST_F(Faults, AFrameThatEndsItsProcessHasNoPreviewAllOthersHave) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    for (const char* command : {"render", "compare"})
        for (const int frame : {1, 4}) {
            SCOPED_TRACE(command + std::string(" ") + std::to_string(frame));
            fs::remove_all(folder_ / "look");
            const std::string file = numbered("in/a", frame, ".ply");
            const std::vector<std::string> words{command,
                                                 "in/a.####.ply",
                                                 "look/a.####.png",
                                                 "--width",
                                                 "64",
                                                 "--height",
                                                 "48",
                                                 "--samples",
                                                 "1",
                                                 "--radius",
                                                 "0.1",
                                                 "--frames",
                                                 "1-4",
                                                 "--contact-sheet",
                                                 "look/sheet.png"};
            const Outcome outcome = runProgram(words, folder_.path(), endingAt(SIGABRT, file));
            EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
            EXPECT_EQ(count(outcome.err, "error: "), 1U) << outcome.err;
            EXPECT_EQ(count(outcome.err, "error: frame " + std::to_string(frame) + ": " + file), 1U) << outcome.err;
            for (int other = 1; other <= 4; ++other)
                EXPECT_EQ(exists(numbered("look/a", other, ".png")), other != frame) << other;
            EXPECT_TRUE(exists("look/sheet.png"));
            EXPECT_EQ(hiddenFiles("look"), 0U);
        }
    // If a frame cannot be measured for lack of memory, the camera would differ: the job ends.
    const Outcome outcome =
        runProgram({"render", "in/a.####.ply", "never/a.####.png"}, folder_.path(), endingAt(SIGKILL, "in/a.0001.ply"));
    EXPECT_EQ(outcome.exit_code, 33);
    EXPECT_NE(outcome.err.find("while spacing and camera were measured in frame 1"), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("never"));
}

/// Every frame is read before the first is meshed, to place the camera.
TEST_F(Faults, AFrameThatEndsItsProcessWhilePreviewsArePlannedFailsAlone) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    const Outcome outcome =
        runProgram({"mesh", "in/a.####.ply", "out/a.####.ply", "--set", "preview.path=out/a.####.png", "--set",
                    "preview.width=64", "--set", "preview.height=48"},
                   folder_.path(), endingAt(SIGABRT, "in/a.0004.ply"));
    expectOnlyThese({4}, outcome);
}

/// A server that is down never answers.
TEST_F(Faults, AFrameThatTakesTooLongFailsAlone) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    const std::string seconds = "4";
    const Outcome outcome = runProgram(
        {"mesh", "in/a.####.ply", "out/a.####.ply", "--timeout", seconds, "--frames-in-flight", "2", "-j", "2"},
        folder_.path(), stallingAt("in/a.0003.ply"));
    expectOnlyThese({3}, outcome);
    EXPECT_NE(outcome.err.find("frame 3: in/a.0003.ply: took longer than " + seconds + " s (run.timeout)"),
              std::string::npos)
        << outcome.err;

    // Another file could give another spacing, so the job ends.
    fs::remove_all(folder_ / "out");
    const Outcome unplanned = runProgram({"mesh", "in/a.####.ply", "out/a.####.ply", "--timeout", "1"}, folder_.path(),
                                         stallingAt("in/a.0001.ply"));
    EXPECT_EQ(unplanned.exit_code, 1);
    EXPECT_NE(unplanned.err.find("frame 1 took longer than 1 s"), std::string::npos) << unplanned.err;
    EXPECT_FALSE(exists("out"));
}

/// Puts this process into a control group with a memory limit during the lifetime of the object.
class MemoryGroup {
public:
    explicit MemoryGroup(std::uint64_t bytes) {
        const bool second = fs::exists("/sys/fs/cgroup/cgroup.controllers");
        const fs::path root = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        folder_ = root / ("betamesh-test-" + std::to_string(getpid()));
        home_ = root / "cgroup.procs";
        std::error_code error;
        if (!fs::create_directory(folder_, error)) return;
        const bool limited = put(folder_ / (second ? "memory.max" : "memory.limit_in_bytes"), bytes);
        works_ = limited && put(folder_ / "cgroup.procs", static_cast<std::uint64_t>(getpid()));
    }
    ~MemoryGroup() {
        put(home_, static_cast<std::uint64_t>(getpid()));
        std::error_code ignored;
        fs::remove(folder_, ignored);
    }
    MemoryGroup(const MemoryGroup&) = delete;
    MemoryGroup& operator=(const MemoryGroup&) = delete;
    bool works() const { return works_; }

private:
    static bool put(const fs::path& file, std::uint64_t number) {
        std::ofstream out(file);
        out << number << std::flush;
        return out.good();
    }
    fs::path folder_, home_;
    bool works_ = false;
};

TEST_F(Faults, IfTheKernelEndsAProcessForItsMemoryTheOtherFramesAreWritten) {
    if (kSanitized) GTEST_SKIP() << "sanitizers use memory of their own";
    writeFrames(1, kFrames, 1000);
    writeFrames(3, 3, 400000);
    const Outcome outcome = [&] {
        const MemoryGroup group(std::uint64_t{100} << 20);
        return group.works() ? mesh({"--radius", "0.02", "-j", "2", "--overwrite"}) : Outcome{-1, "", ""};
    }();
    if (outcome.exit_code == -1) GTEST_SKIP() << "no control group can be made here";
    EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
    EXPECT_NE(outcome.err.find("frame 3: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("error: out of memory: 5 of 6"), std::string::npos) << outcome.err;
    for (int frame = 1; frame <= kFrames; ++frame) EXPECT_TRUE(frame == 3 ? absent(frame) : written(frame)) << frame;
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

/// OpenVDB trusts the sizes in a file. For some of these files it crashes or allocates without bound.
TEST_F(Faults, DamagedVdbFilesFailAlone) {
    if (kSanitized) GTEST_SKIP() << "sanitizers end the program where OpenVDB writes out of bounds";
    constexpr int kLast = 480, kWhole = 6;  // every sixth file is undamaged
    const char* const chosen = std::getenv("BETAMESH_FUZZ_SEED");
    const std::uint64_t seed = chosen ? std::strtoull(chosen, nullptr, 10) : 0;
    Sample sample({"jitter", 300, 1, 24});
    for (int frame = 1; frame <= kLast; ++frame) {
        const std::string file = folder_ / numbered("in/a", frame, ".vdb");
        writeParticles(file, sample.frame(1));
        if (frame % kWhole == 0) continue;
        std::string bytes = contentsOf(file);
        Random random(seed + static_cast<std::uint64_t>(frame));
        for (int change = 0; change < 2; ++change)
            bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
        write(file, bytes);
    }
    const Outcome outcome = runProgram(
        {"mesh", "in/a.####.vdb", "out/a.####.ply", "--json", "--radius", "0.2", "--io-retries", "0"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    std::set<int> told;
    for (const Json& line : jsonLines(outcome.out)) {
        const int frame = line["frame"];
        EXPECT_TRUE(told.insert(frame).second) << line;
        EXPECT_TRUE(line["status"] == "ok" || frame % kWhole != 0) << line;
        EXPECT_TRUE(line["status"] == "failed" ? absent(frame) : written(frame)) << line;
        if (line["status"] == "failed") {
            EXPECT_NE(outcome.err.find("error: frame " + std::to_string(frame) + ": "), std::string::npos) << line;
        }
    }
    EXPECT_EQ(told.size(), static_cast<std::size_t>(kLast)) << outcome.err;
    std::printf("%zu frames ended the process that worked on them\n",
                count(outcome.err, ".vdb: the process that worked on it was ended"));
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

/// A file that ends its process, found among those that do.
/// Of a .vdb file with random changes, one for each seed: the contents that end the process that reads them, as
/// `betamesh info` says of all files together. One call for many files, since starting the program takes longest.
std::vector<std::string> filesThatEndTheirProcess(const std::string& whole, std::uint64_t first_seed, std::size_t seeds,
                                                  const fs::path& folder) {
    std::vector<std::string> changed(seeds, whole), words{"info"};
    for (std::size_t i = 0; i < seeds; ++i) {
        Random random(first_seed + i);
        for (int change = 0; change < 6; ++change)
            changed[i][random.below(whole.size())] = static_cast<char>(random.below(256));
        words.push_back("damaged/" + std::to_string(i) + ".vdb");
        write(folder / words.back(), changed[i]);
    }
    const std::string told = runProgram(words, folder).err;
    std::vector<std::string> ending;
    for (std::size_t i = 0; i < seeds; ++i)
        if (told.find(words[i + 1] + ": the process that worked on it was ended") != std::string::npos)
            ending.push_back(changed[i]);
    return ending;
}

TEST_F(Faults, ADamagedVdbThatEndsItsProcessIsAnErrorOfEveryCommand) {
    if (kSanitized) GTEST_SKIP() << "sanitizers end the program where OpenVDB writes out of bounds";
    Sample sample({"jitter", 300, 1, 24});
    for (int frame = 1; frame <= 3; ++frame)
        writeParticles(folder_ / numbered("in/a", frame, ".vdb"), sample.frame(frame));
    const std::string damaged = folder_ / "in/a.0002.vdb";
    const std::string named = "in/a.0002.vdb: the process that worked on it was ended";
    const std::string whole = contentsOf(damaged);
    bool found = false;
    for (std::uint64_t seed = 1; seed <= 3000 && !found; seed += 100)
        for (const std::string& changed : filesThatEndTheirProcess(whole, seed, 100, folder_.path())) {
            write(damaged, changed);
            found = runProgram({"info", "in/a.0002.vdb"}, folder_.path()).err.find(named) != std::string::npos;
            if (found) break;
        }
    ASSERT_TRUE(found);

    const Outcome info =
        runProgram({"info", "--json", "in/a.0001.vdb", "in/a.0002.vdb", "in/a.0003.vdb"}, folder_.path());
    EXPECT_EQ(info.exit_code, 1);
    EXPECT_EQ(count(info.err, named), 1U) << info.err;
    EXPECT_EQ(jsonLines(info.out).size(), 2U) << info.out;

    for (const char* command : {"render", "compare"}) {
        fs::remove_all(folder_ / "look");
        const Outcome outcome = runProgram({command, "in/a.####.vdb", "look/a.####.png", "--width", "64", "--height",
                                            "48", "--samples", "1", "--radius", "0.2"},
                                           folder_.path());
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_EQ(count(outcome.err, "error: frame 2: " + named), 1U) << outcome.err;
        EXPECT_TRUE(exists("look/a.0001.png") && !exists("look/a.0002.png") && exists("look/a.0003.png"));
    }

    writeFrames(1, 3, 300);
    ASSERT_EQ(mesh({"--frames", "1-3", "--radius", "0.2"}).exit_code, 0);
    const Outcome check = runProgram({"check", "--json", "--particles", "in/a.####.vdb", "--tolerance", "9",
                                      "out/a.0001.ply", "out/a.0002.ply", "out/a.0003.ply"},
                                     folder_.path());
    EXPECT_EQ(check.exit_code, 1);
    EXPECT_EQ(count(check.err, named), 1U) << check.err;
    EXPECT_EQ(jsonLines(check.out).size(), 3U) << check.out;
}

TEST_F(Faults, NoProcessStaysBehindAJob) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);  // orphans become children of this process
    writeParticles(folder_ / "in/a.0001.vdb", Sample({"jitter", 300, 1, 24}).frame(1));
    EXPECT_EQ(runProgram({"mesh", "in/a.0001.vdb", "out/a.0001.ply"}, folder_.path()).exit_code, 0);
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
}

TEST_F(Faults, AWorkerThatIsKilledIsReplacedAndOneThatIsTerminatedIsNot) {
    if (kSanitized) GTEST_SKIP() << "frames that take long enough to be interrupted take minutes under sanitizers";
    writeFrames(1, kFrames, 20000);
    const std::vector<std::string> words{"mesh",     "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "3",
                                         "--radius", "0.1",           "--skip-existing"};
    {
        RunningProgram program(words, folder_.path());
        ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out"); }));
        kill(program.worker(), SIGTERM);
        EXPECT_EQ(program.wait().exit_code, 128 + SIGTERM);
        EXPECT_EQ(hiddenFiles("out"), 0U);
    }
    for (const int round : {1, 2, 3}) {
        SCOPED_TRACE(round);
        fs::remove_all(folder_ / "out");
        RunningProgram program(words, folder_.path());
        ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out"); }));
        const pid_t first = program.worker();
        kill(first, SIGKILL);
        const Outcome outcome = program.wait();
        // Depends on what was in progress at that moment.
        EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 33) << outcome.exit_code << outcome.err;
        EXPECT_EQ(hiddenFiles("out"), 0U);
        ASSERT_EQ(runProgram(words, folder_.path()).exit_code, 0);
        for (int frame = 1; frame <= kFrames; ++frame) EXPECT_TRUE(written(frame)) << frame;
    }
}

TEST_F(Faults, AFullDiskFailsTheFramesThatDoNotFitAndNoOther) {
    fs::create_directories(folder_ / "out");
    const std::string disk = folder_ / "out";
    if (mount("none", disk.c_str(), "tmpfs", 0, "size=400k") != 0)
        GTEST_SKIP() << "no small file system can be mounted here: " << std::strerror(errno);
    const Outcome outcome = mesh({"--io-retries", "0", "--frames-in-flight", "1"});
    int fitting = 0;
    for (int frame = 1; frame <= kFrames; ++frame) {
        EXPECT_TRUE(written(frame) || !exists(numbered("out/a", frame, ".ply.json"))) << frame;
        if (!written(frame)) continue;
        ++fitting;
        EXPECT_EQ(readMesh(folder_ / numbered("out/a", frame, ".ply")).triangles.size(), manifest(frame)["triangles"]);
    }
    EXPECT_EQ(hiddenFiles("out"), 0U);
    umount(disk.c_str());
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_NE(outcome.err.find("No space left on device"), std::string::npos) << outcome.err;
    EXPECT_GE(fitting, 1);
    EXPECT_LT(fitting, kFrames);
}

/// Programs started during its lifetime do not run as root, who may write everywhere.
class AnyUser {
public:
    AnyUser() { change(kNobody); }
    ~AnyUser() noexcept(false) { change(0); }
    AnyUser(const AnyUser&) = delete;
    AnyUser& operator=(const AnyUser&) = delete;

private:
    static constexpr uid_t kNobody = 65534;
    void change(uid_t user) const {
        if (root_ && setresuid(user, user, 0) != 0) throw std::runtime_error("the user cannot be changed");
    }
    const bool root_ = geteuid() == 0;
};

TEST_F(Faults, AFolderWithoutWritePermissionIsReportedFirst) {
    fs::create_directories(folder_ / "out");
    fs::permissions(folder_.path(), static_cast<fs::perms>(0755));
    ASSERT_EQ(mesh({"-q"}, "meshes/a.####.ply").exit_code, 0);
    fs::permissions(folder_ / "out", static_cast<fs::perms>(0555));
    for (const std::vector<std::string>& words : {std::vector<std::string>{"mesh", "in/a.####.ply", "out/a.####.ply"},
                                                  {"convert", "in/a.####.ply", "out/a.####.csv"},
                                                  {"coherence", "meshes/a.####.ply", "--plot", "out/a.svg"}}) {
        SCOPED_TRACE(words[0]);
        const Outcome outcome = [&] {
            const AnyUser any_user;
            return runProgram(words, folder_.path());
        }();
        if (outcome.exit_code == 127) {
            fs::permissions(folder_ / "out", fs::perms::owner_all);
            GTEST_SKIP() << "other users may not run the program here";
        }
        EXPECT_EQ(outcome.exit_code, 2);
        EXPECT_EQ(outcome.out, "");
        EXPECT_NE(outcome.err.find("'out': no files can be written in this folder"), std::string::npos) << outcome.err;
        EXPECT_EQ(count(outcome.err, " error: "), 1U) << outcome.err;  // before any frame is read
        EXPECT_NE(outcome.err.find(std::strerror(EACCES)), std::string::npos) << outcome.err;
    }
    fs::permissions(folder_ / "out", fs::perms::owner_all);
}

/// A read that never returns, as from a server that is down.
TEST_F(Faults, ASignalEndsAJobWithAStalledInput) {
    if (kSanitized) GTEST_SKIP() << "sanitizers are to be loaded before any other library";
    for (const int stalled : {1, 3}) {  // while the spacing is measured, while frames are meshed
        SCOPED_TRACE(stalled);
        writeFrames(1, kFrames);
        fs::remove_all(folder_ / "out");
        RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "2", "-j", "2"},
                               folder_.path(), stallingAt(numbered("in/a", stalled, ".ply")));
        ASSERT_TRUE(within(kSecondsToStart, [&] { return stalled == 1 || written(kFrames); }));
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        const auto begin = std::chrono::steady_clock::now();
        program.send(SIGTERM);
        const Outcome outcome = program.wait();
        EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
        EXPECT_EQ(outcome.exit_code, 128 + SIGTERM) << outcome.err;
        for (int frame = 1; frame <= kFrames; ++frame)
            EXPECT_TRUE(stalled == 1 || frame == stalled ? absent(frame) : written(frame)) << frame;
    }
}

}  // namespace
}  // namespace betamesh
