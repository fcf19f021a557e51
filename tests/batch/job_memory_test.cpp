// Memory limits of jobs, the estimates of memory, and what a job holds on to.

#include "support/job_folder.h"

#include <fstream>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace betamesh {
namespace {

using Job = JobFolder;

/// Whether memory limits work here: some emulators and sandboxes accept a limit and ignore it.
bool memoryLimitsWork() {
    if (kSanitized) return false;
    const pid_t child = fork();
    if (child == 0) {
        const rlimit limit{1 << 20, 1 << 20};
        if (setrlimit(RLIMIT_DATA, &limit) != 0) _exit(1);
        _exit(mmap(nullptr, 1 << 28, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(Job, AMemoryLimitThatIsTooSmallEndsWith33) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 2, 200000);                      // 6 MB each on disk, as much again in memory
    for (const char* radius : {"1.5dx", "0.02"}) {  // the first is out of memory when it measures dx
        SCOPED_TRACE(radius);
        const Outcome outcome = mesh({"--memory-limit", "1MiB", "-j", "1", "--radius", radius});
        EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
        EXPECT_NE(outcome.err.find("out of memory"), std::string::npos) << outcome.err;
        EXPECT_TRUE(absent(1) && absent(2));
    }
    // Wherever it strikes, frames are whole or absent.
    for (const int frame : {1, 2}) {
        writeParticles(folder_ / numbered("in/a", frame, ".vdb"),
                       readParticles(folder_ / numbered("in/a", frame, ".ply")));
    }
    for (const char* input : {"in/a.####.ply", "in/a.####.vdb"}) {
        for (const char* limit : {"4MiB", "16MiB", "24MiB", "32MiB", "48MiB"}) {
            SCOPED_TRACE(std::string(input) + ' ' + limit);
            fs::remove_all(folder_ / "out");
            const Outcome outcome =
                runProgram({"mesh", input, "out/a.####.ply", "--memory-limit", limit, "-j", "2"}, folder_.path());
            EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 33) << outcome.exit_code << '\n' << outcome.err;
            for (const int frame : {1, 2})
                EXPECT_TRUE(written(frame) || (outcome.exit_code == 33 && absent(frame))) << frame;
        }
    }
}

TEST_F(Job, AFrameLargerThanTheMemoryGivesTheSameBytes) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 1000000);
    const Particles particles = readParticles(folder_ / "in/a.0001.ply");
    const auto run = [&](const std::string& input, std::vector<std::string> further) {
        std::vector<std::string> words{"mesh",     input,       "out/a.0001.ply", "-v", "--overwrite", "--spacing",
                                       "0.015625", "--surface", "alpha",          "-j", "2",           "--droplets",
                                       "drop"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find(" particles are near the surface") != std::string::npos;
    };
    EXPECT_FALSE(run("in/a.0001.ply", {}));
    const auto meshes = meshesIn("out");
    const Json whole = manifest(1);
    for (const char* format : {".ply", ".bgeo", ".bgeo.gz", ".vdb"}) {
        SCOPED_TRACE(format);
        const std::string input = "in/a.0001" + std::string(format);
        if (input != "in/a.0001.ply") writeParticles(folder_ / input, particles);
        EXPECT_TRUE(run(input, {"--memory-limit", "300MiB"}));  // thought to take more than a GiB
        EXPECT_EQ(meshesIn("out"), meshes);
        for (const char* key : {"particles", "distinct_particles", "alpha_triangles", "triangles", "volume"})
            EXPECT_EQ(manifest(1)[key], whole[key]) << key;
    }
    EXPECT_TRUE(run("in/a.0001.ply", {"--memory-limit", "300MiB"}));
    EXPECT_LT(manifest(1)["peak_bytes"], whole["peak_bytes"]);
}

TEST_F(Job, TheDeprecatedScratchFolderIsWarnedOfOnce) {
    writeFrames(1, 3);
    const Outcome outcome = mesh({"--scratch", "absent"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(count(outcome.err, "run.scratch has no effect any more"), 1U) << outcome.err;
    EXPECT_FALSE(exists("absent"));
}

TEST_F(Job, AMemoryLimitThrottlesRatherThanFails) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 60000);  // takes about 50 MB, six of them more than the limit
    for (int frame = 2; frame <= 6; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    const Outcome outcome = mesh({"--memory-limit", "120MiB", "-j", "6", "--frames-in-flight", "6"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto meshes = meshesIn("out");
    ASSERT_EQ(meshes.size(), 6U);
    for (const auto& entry : meshes) EXPECT_TRUE(entry.second == meshes.begin()->second) << entry.first;
}

TEST_F(Job, LevelSetsAreCountedInTheMemoryOfFrames) {
    writeFrames(1, 1, 2000);
    const auto megabytes = [&](const std::vector<std::string>& further, const std::string& output) {
        std::vector<std::string> words{"--dry-run", "--json"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = mesh(words, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return jsonLines(outcome.out).at(0)["memory_bytes"].get<double>() / 1e6;
    };
    const double alone = megabytes({}, "out/a.####.ply");
    EXPECT_NEAR(megabytes({"--voxel", "0.5dx"}, "out/a.####.vdb"), alone + 1.06, 0.1);
    const double fine = megabytes({"--voxel", "0.05dx"}, "out/a.####.vdb");
    EXPECT_NEAR(fine, alone + 106, 10);
    EXPECT_NEAR(megabytes({"--voxel", "0.05", "--spacing", "1"}, "out/a.####.vdb"), fine, 10);
    EXPECT_NEAR(megabytes({"--voxel", "0.05dx", "--velocity-grid"}, "out/a.####.vdb"), alone + 211, 20);
    EXPECT_LT(megabytes({"--voxel", "1e-30"}, "out/a.####.vdb"), 1e19);
    // Farms are asked for as much, whichever output needs it.
    const auto submitted = [&](const std::string& outputs) {
        write(folder_ / "j.yaml", "version: 1\ninput: {path: in/a.####.ply}\noutputs: [" + outputs + "]\n");
        const Outcome outcome = runProgram({"submit", "j.yaml", "--to", "slurm", "--print"}, folder_.path());
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::size_t at = outcome.out.find("mem=");
        return at == std::string::npos ? 0 : std::stoi(outcome.out.substr(at + 4));
    };
    const int meshes = submitted("{path: out/a.####.ply}");
    EXPECT_GT(submitted("{path: out/a.####.ply}, {path: out/a.####.vdb, voxel: 0.05dx}"), meshes + 140);
}

TEST_F(Job, LevelSetsThatDoNotFitTogetherAreMadeOneAfterTheOther) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 1, 4000);
    for (int frame = 2; frame <= 6; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    const std::vector<std::string> options{"--voxel", "0.1dx", "-j", "6", "--frames-in-flight", "6", "--memory-limit"};
    std::vector<std::string> enough = options, little = options;
    enough.emplace_back("160MiB");
    const Outcome outcome = mesh(enough, "out/a.####.vdb");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto meshes = meshesIn("out");
    ASSERT_EQ(meshes.size(), 6U);
    for (const auto& entry : meshes) EXPECT_TRUE(entry.second == meshes.begin()->second) << entry.first;
    little.emplace_back("40MiB");
    little.emplace_back("--overwrite");
    const Outcome too_little = mesh(little, "out/a.####.vdb");
    EXPECT_EQ(too_little.exit_code, 33) << too_little.err;
    for (const char* words : {"frame 3: out of memory", "voxels of", "Choose larger voxels with --voxel"})
        EXPECT_NE(too_little.err.find(words), std::string::npos) << too_little.err;
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

TEST_F(Job, AFrameTooLargeForTheMemoryDoesNotLoseTheOthers) {
    if (!memoryLimitsWork()) GTEST_SKIP() << "memory cannot be limited here";
    writeFrames(1, 5, 1000);
    writeFrames(3, 3, 300000);
    const Outcome outcome = mesh({"--memory-limit", "60MiB", "-j", "2", "--radius", "0.02"});
    EXPECT_EQ(outcome.exit_code, 33) << outcome.err;
    for (const char* words : {"frame 3: out of memory", "particles are near the surface", "MiB"})
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    for (int frame = 1; frame <= 5; ++frame) EXPECT_TRUE(frame == 3 ? absent(frame) : written(frame)) << frame;
}

/// The resources of a process.
struct Holdings {
    std::uint64_t kibibytes = 0;
    std::size_t descriptors = 0;
};

Holdings holdingsOf(pid_t process) {
    const fs::path folder = "/proc/" + std::to_string(process);
    Holdings holdings;
    std::ifstream status(folder / "status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmRSS:")) holdings.kibibytes = std::stoull(line.substr(6));
    for (const auto& entry : fs::directory_iterator(folder / "fd")) holdings.descriptors += entry.exists() ? 1 : 0;
    return holdings;
}

TEST_F(Job, MemoryAndDescriptorsDoNotGrowWithTheNumberOfFrames) {
    if (kSanitized) GTEST_SKIP() << "sanitizers hold memory of their own";
    const int last = 5000;
    writeFrames(1, 1, 8);
    for (int frame = 2; frame <= last; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    RunningProgram program(
        {"mesh", "in/a.####.ply", "out/a.####.ply", "--radius", "0.1", "-q", "--frames-in-flight", "8"},
        folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(500); }));
    const Holdings early = holdingsOf(program.worker());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(4900); }));
    const Holdings late = holdingsOf(program.worker());
    EXPECT_EQ(program.wait().exit_code, 0);
    EXPECT_GT(early.kibibytes, 1000U);
    EXPECT_LT(late.kibibytes, early.kibibytes + early.kibibytes / 4);
    EXPECT_LE(late.descriptors, early.descriptors + 16);  // eight frames open three each at most, at any moment
    for (int frame = 1; frame <= last; ++frame) ASSERT_TRUE(written(frame)) << frame;
}

}  // namespace
}  // namespace betamesh
