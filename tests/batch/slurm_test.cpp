// A real Slurm runs a pipeline: what is written, also after tasks were killed.

#include "support/slurm.h"
#include "support/job_folder.h"

#include <memory>

namespace betamesh {
namespace {

class OnSlurm : public JobFolder {
protected:
    static constexpr int kFrames = 24;

    static void SetUpTestSuite() { slurm_ = std::make_unique<Slurm>(); }
    static void TearDownTestSuite() { slurm_.reset(); }

    void SetUp() override {
        if (!slurm_->whyNot().empty()) GTEST_SKIP() << "no Slurm here: " << slurm_->whyNot();
        Sample sample({"dambreak", 8000, 1, 24});
        for (int frame = 1; frame <= kFrames; ++frame) writeFrame(frame, sample.frame(frame));
        write(folder_ / "job.yaml", "version: 1\ninput: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\n");
    }

    /// Submits the pipeline and returns the id of the array. expected: the exit code of `submit`.
    std::string submit(const std::vector<std::string>& further, int expected = 0) {
        std::vector<std::string> words{"submit",       "job.yaml", "--to",  "slurm",
                                       "--chunk-size", "4",        "--set", "run.threads=1"};
        words.insert(words.end(), further.begin(), further.end());
        const Outcome outcome = runProgram(words, folder_.path(), slurm_->environment());
        EXPECT_EQ(outcome.exit_code, expected) << outcome.err;
        return outcome.out.substr(0, outcome.out.find('\n'));
    }

    static std::unique_ptr<Slurm> slurm_;
};

std::unique_ptr<Slurm> OnSlurm::slurm_;

TEST_F(OnSlurm, AnArrayWithAKilledAndRequeuedTaskWritesTheSameMeshesAsALocalRun) {
    ASSERT_EQ(mesh({}, "local/a.####.ply").exit_code, 0);
    const std::string job = submit({"--", "--output=" + folder_ / "task.%a.log"});
    ASSERT_FALSE(job.empty());
    const std::string victim = job + "_2";
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(5); }));  // of the second task's four
    slurm_->command("scancel --batch --signal=KILL " + victim);
    ASSERT_TRUE(within(kSecondsToStart, [&] {
        return slurm_->command("squeue -h -t RUNNING,COMPLETING -j " + victim).find(job) == std::string::npos;
    }));
    slurm_->command("scontrol requeue " + victim);
    ASSERT_TRUE(slurm_->ended(job)) << slurm_->command("squeue");
    const std::string state = slurm_->command("scontrol -o show job " + job);
    EXPECT_EQ(count(state, "JobState=COMPLETED"), 6U) << state;
    EXPECT_NE(state.find("Restarts=1"), std::string::npos) << state;
    ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out/job.html"); })) << "no report follows";
    EXPECT_EQ(hiddenFiles("out"), 0U);
    auto meshes = meshesIn("out");
    meshes.erase("job.html");
    EXPECT_TRUE(meshes == meshesIn("local"));
    for (int frame = 1; frame <= kFrames; ++frame) EXPECT_EQ(manifest(frame)["status"], "ok");
}

TEST_F(OnSlurm, WrittenScriptsAreAcceptedAndRun) {
    submit({"-o", "scripts"});
    for (const char* name : {"job.array.sh", "job.report.sh"}) {
        const std::string told = slurm_->command("sbatch --test-only " + folder_ / "scripts" + '/' + name);
        EXPECT_NE(told.find(" to start at "), std::string::npos) << told;
    }
    const std::string told = slurm_->command("bash " + folder_ / "scripts/job.submit.sh");
    const std::size_t id = told.find_first_of("0123456789");
    ASSERT_NE(id, std::string::npos) << told;
    const std::string report_job = told.substr(id, told.find('\n', id) - id);
    const std::string state = slurm_->command("scontrol -o show job " + report_job);
    for (const char* part : {"Dependency=afterany:", "TimeLimit=01:00:00", "MinMemoryNode=1G", "job.report."})
        EXPECT_NE(state.find(part), std::string::npos) << part << ": " << state;
    ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out/job.html"); })) << slurm_->command("squeue");
    for (int frame = 1; frame <= kFrames; ++frame) EXPECT_TRUE(written(frame)) << frame;
    std::size_t logs = 0;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
        logs += entry.path().extension() == ".log" && entry.path().filename().string().starts_with("job.") ? 1 : 0;
    EXPECT_EQ(logs, 7U);  // six tasks and the report
}

TEST_F(OnSlurm, ScancelLeavesNoPartialFile) {
    const std::string job = submit({"--no-report"});
    ASSERT_TRUE(within(kSecondsToStart, [&] { return written(1); }));
    slurm_->command("scancel " + job);
    ASSERT_TRUE(slurm_->ended(job));
    EXPECT_EQ(hiddenFiles("out"), 0U);
    int finished = 0;
    for (int frame = 1; frame <= kFrames; ++frame) {
        EXPECT_TRUE(written(frame) || absent(frame)) << frame;
        finished += written(frame) ? 1 : 0;
    }
    EXPECT_GE(finished, 1);
    EXPECT_LT(finished, kFrames);
}

TEST_F(OnSlurm, AFrameThatFailsMakesTheJobFail) {
    writeFrameWithNaN(6);
    submit({"--no-report", "--", "--wait"}, 1);
    for (int frame = 1; frame <= kFrames; ++frame) EXPECT_EQ(written(frame), frame != 6) << frame;
}

TEST_F(OnSlurm, AnArrayIsNoLargerThanSlurmAccepts) {  // 100 here
    for (int frame = kFrames + 1; frame <= 250; ++frame)
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    const Outcome by_cost = runProgram({"submit", "job.yaml", "--to", "slurm", "--print", "--task-minutes", "0.001"},
                                       folder_.path(), slurm_->environment());
    EXPECT_NE(by_cost.out.find("--array=1-100\n"), std::string::npos) << by_cost.out;
    const Outcome by_frames = runProgram({"submit", "job.yaml", "--to", "slurm", "--print", "--chunk-size", "2"},
                                         folder_.path(), slurm_->environment());
    EXPECT_EQ(by_frames.exit_code, 2);
    EXPECT_NE(by_frames.err.find("MaxArraySize"), std::string::npos) << by_frames.err;
}

}  // namespace
}  // namespace betamesh
