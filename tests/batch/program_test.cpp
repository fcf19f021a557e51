// The commands besides the batch job, and how the program uses the resources it is granted.

#include "support/program.h"
#include "io/particle_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace betamesh {
namespace {

using Json = nlohmann::json;

TEST(Program, PrintsItsVersionAndHelp) {
    const TemporaryFolder folder;
    const Outcome version = runProgram({"--version"}, folder.path());
    EXPECT_EQ(version.exit_code, 0);
    EXPECT_TRUE(version.out.starts_with("betamesh ")) << version.out;
    for (const char* command : {"mesh", "run", "sample", "info", "check", "render", "compare", "config"}) {
        for (const char* option : {"--help", "--help-all"}) {
            const Outcome help = runProgram({command, option}, folder.path());
            EXPECT_EQ(help.exit_code, 0);
            EXPECT_NE(help.out.find("Usage:"), std::string::npos);
            std::istringstream lines(help.out);
            for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120U) << line;
        }
    }
}

TEST(Program, SamplesAreTheSameEveryTimeAndOverwrittenOnlyOnRequest) {
    const TemporaryFolder folder;
    const std::vector<std::string> words{"sample", "drop", "a/d.####.ply", "--particles", "500", "--frames", "2-4x2"};
    ASSERT_EQ(runProgram(words, folder.path()).exit_code, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "a/d.0002.ply"));
    EXPECT_FALSE(std::filesystem::exists(folder / "a/d.0003.ply"));
    const Particles particles = readParticles(folder / "a/d.0004.ply");
    EXPECT_EQ(particles.velocity.size(), particles.size());
    EXPECT_EQ(particles.id.size(), particles.size());
    const std::string bytes = contentsOf(folder / "a/d.0004.ply");

    EXPECT_EQ(runProgram(words, folder.path()).exit_code, 2);
    std::vector<std::string> again = words;
    again.push_back("--overwrite");
    EXPECT_EQ(runProgram(again, folder.path()).exit_code, 0);
    EXPECT_EQ(contentsOf(folder / "a/d.0004.ply"), bytes);
    again.back() = "--skip-existing";
    EXPECT_EQ(runProgram(again, folder.path()).exit_code, 0);

    EXPECT_EQ(runProgram({"sample", "nothing", "x.####.ply"}, folder.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"sample", "drop", "x.ply", "--frames", "1-2"}, folder.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"sample", "drop", "x.####.xyz"}, folder.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"sample", "drop", "x.0003.ply", "--particles", "500"}, folder.path()).exit_code, 0);
}

TEST(Program, InfoShowsWhatAFileContains) {
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "jitter", "a.vdb", "--particles", "500"}, folder.path()).exit_code, 0);
    ASSERT_EQ(runProgram({"mesh", "a.vdb", "a.ply"}, folder.path()).exit_code, 0);
    const Outcome outcome = runProgram({"info", "--json", "a.vdb", "a.ply"}, folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::istringstream lines(outcome.out);
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    const Json particles = Json::parse(line);
    EXPECT_EQ(particles["kind"], "particles");
    EXPECT_EQ(particles["points"].get<std::size_t>(), readParticles(folder / "a.vdb").size());
    EXPECT_GT(particles["spacing"].get<double>(), 0);
    EXPECT_FALSE(particles["attributes"].empty());
    ASSERT_TRUE(std::getline(lines, line));
    const Json mesh = Json::parse(line);
    EXPECT_EQ(mesh["kind"], "mesh");
    EXPECT_GT(mesh["triangles"].get<std::size_t>(), 0U);
    EXPECT_NE(runProgram({"info", "a.vdb"}, folder.path()).out.find("spacing"), std::string::npos);

    write(folder / "broken.ply", "no");
    const Outcome broken = runProgram({"info", "broken.ply", "a.ply"}, folder.path());
    EXPECT_EQ(broken.exit_code, 1);
    EXPECT_NE(broken.out.find("a.ply"), std::string::npos);
    for (const char* absent : {"absent.ply", "absent.json", "absent.vdb", "absent"})
        EXPECT_NE(runProgram({"info", absent}, folder.path())
                      .err.find(std::string(absent) + ": cannot be read: No such file or directory"),
                  std::string::npos)
            << absent;
}

TEST(Program, ConfigCheckAcceptsTheOutputOfConfigPrint) {
    const TemporaryFolder folder;
    const Outcome defaults = runProgram({"config", "print"}, folder.path());
    EXPECT_EQ(defaults.exit_code, 0);
    write(folder / "job.yaml", defaults.out);
    EXPECT_EQ(runProgram({"config", "check", "job.yaml"}, folder.path()).exit_code, 0);
    EXPECT_EQ(runProgram({"config", "print", "job.yaml"}, folder.path()).out, defaults.out);
    const Outcome changed = runProgram({"config", "print", "job.yaml", "--set", "smoothing.passes=4"}, folder.path());
    EXPECT_NE(changed.out.find("passes: 4"), std::string::npos);
    EXPECT_EQ(runProgram({"config", "check", "absent.yaml"}, folder.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"config"}, folder.path()).exit_code, 2);
}

TEST(Program, UsesTheThreadsThatAFarmGrants) {
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "jitter", "a.####.ply", "--particles", "100"}, folder.path()).exit_code, 0);
    for (const char* grant : {"SLURM_CPUS_PER_TASK=1", "CUE_THREADS=1"}) {
        const Outcome outcome =
            runProgram({"mesh", "a.####.ply", "m.####.ply", "-v", "--overwrite"}, folder.path(), {grant});
        EXPECT_NE(outcome.err.find(" 1 threads"), std::string::npos) << outcome.err;
    }
}

TEST(Program, UsesTheMemoryThatAFarmGrants) {
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "jitter", "a.0001.ply", "--particles", "100"}, folder.path()).exit_code, 0);
    const Outcome outcome =
        runProgram({"mesh", "a.####.ply", "m.####.ply", "-v"}, folder.path(), {"SLURM_MEM_PER_NODE=1000"});
    EXPECT_NE(outcome.err.find(" in 800 MiB"), std::string::npos) << outcome.err;  // four fifths of it
}

/// A control group (version 1 or 2), removed with this object.
class ControlGroup {
public:
    /// file, value: a limit of the controller.
    ControlGroup(const std::string& controller, const std::vector<std::pair<std::string, std::string>>& limits) {
        const std::string name = "betamesh-test-" + std::to_string(getpid());
        for (const std::string& root : {"/sys/fs/cgroup/" + controller, std::string("/sys/fs/cgroup")}) {
            std::error_code error;
            if (!std::filesystem::create_directory(root + '/' + name, error)) continue;
            folder_ = root + '/' + name;
            for (const auto& [file, value] : limits) {
                if (!std::filesystem::exists(folder_ + '/' + file)) continue;
                std::ofstream(folder_ + '/' + file) << value << std::flush;
                ++limits_;
            }
            if (limits_ > 0) return;
            remove();
        }
    }
    ~ControlGroup() { remove(); }
    ControlGroup(const ControlGroup&) = delete;
    ControlGroup& operator=(const ControlGroup&) = delete;

    bool works() const { return limits_ > 0; }
    /// Runs a shell command in the group.
    bool run(const std::string& command) const {
        return std::system(("echo $$ > " + folder_ + "/cgroup.procs && " + command).c_str()) == 0;
    }

private:
    void remove() {
        std::error_code ignored;
        if (!folder_.empty()) std::filesystem::remove(folder_, ignored);
        folder_.clear();
    }

    std::string folder_;
    int limits_ = 0;
};

TEST(Program, KeepsToTheLimitsOfItsControlGroup) {
    const ControlGroup processors("cpu", {{"cpu.max", "100000 100000"}, {"cpu.cfs_quota_us", "100000"}});
    if (!processors.works()) GTEST_SKIP() << "no control group can be made here";
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "jitter", "a.0001.ply", "--particles", "100"}, folder.path()).exit_code, 0);
    const std::string command = std::string(BETAMESH_PROGRAM) + " mesh " + folder / "a.0001.ply" + " " +
                                folder / "m.ply" + " --overwrite -v 2> " + folder / "said";
    ASSERT_TRUE(processors.run(command));
    EXPECT_NE(contentsOf(folder / "said").find(" 1 threads"), std::string::npos) << contentsOf(folder / "said");
    const ControlGroup memory("memory", {{"memory.max", "1048576000"}, {"memory.limit_in_bytes", "1048576000"}});
    if (!memory.works()) GTEST_SKIP() << "no control group for memory can be made here";
    ASSERT_TRUE(memory.run(command));
    EXPECT_NE(contentsOf(folder / "said").find(" in 800 MiB"), std::string::npos) << contentsOf(folder / "said");
}

TEST(Program, AFullStdoutIsAnError) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "/dev/full does not exist here";
    const TemporaryFolder folder;
    const std::string command = std::string(BETAMESH_PROGRAM) + " config print > /dev/full 2> /dev/null";
    EXPECT_NE(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace betamesh
