// Signals that end a job.

#include "io/mesh_file.h"
#include "support/clouds.h"
#include "support/job_folder.h"

#include <chrono>
#include <csignal>
#include <thread>

namespace betamesh {
namespace {

using Job = JobFolder;

TEST_F(Job, SignalsEndAJobWithTheirExitCodeAndNoPartialFiles) {
    Sample sample({"jitter", 8000, 1, 24});
    fs::create_directories(folder_ / "in");
    writeFrame(1, sample.frame(1));
    const int last = 2000;
    for (int frame = 2; frame <= last; ++frame) {
        fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / numbered("in/a", frame, ".ply"));
    }
    for (const int signal : {SIGTERM, SIGINT}) {
        SCOPED_TRACE(signal);
        fs::remove_all(folder_ / "out");
        RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--frames-in-flight", "3"}, folder_.path());
        ASSERT_TRUE(within(kSecondsToStart, [&] { return written(3); }));
        program.send(signal);
        const Outcome outcome = program.wait();
        EXPECT_EQ(outcome.exit_code, 128 + signal) << outcome.err;
        EXPECT_EQ(hiddenFiles("out"), 0U);
        int finished = 0;
        for (int frame = 1; frame <= last; ++frame) {
            EXPECT_TRUE(written(frame) || absent(frame)) << frame;
            if (!written(frame)) continue;
            ++finished;
            EXPECT_EQ(manifest(frame)["status"], "ok");
            EXPECT_FALSE(readMesh(folder_ / numbered("out/a", frame, ".ply")).triangles.empty());
        }
        EXPECT_GE(finished, 1);  // frame 3 at least; those before it may have been under way
        EXPECT_LT(finished, last);
    }
}

TEST_F(Job, ASignalInterruptsALongStage) {
    // Every ball reaches every other, and all are exposed: many minutes of work.
    writeFrame(1, spiralOnSphere(100000, 1));
    RunningProgram program({"mesh", "in/a.####.ply", "out/a.####.ply", "--radius", "1", "--spacing", "1"},
                           folder_.path());
    ASSERT_TRUE(within(kSecondsToStart, [&] { return exists("out"); }));  // made when the job begins
    std::this_thread::sleep_for(std::chrono::seconds(1));
    program.send(SIGTERM);
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(25));  // farms kill after 30 and more
    EXPECT_EQ(outcome.exit_code, 128 + SIGTERM) << outcome.err;
    EXPECT_TRUE(absent(1));
    EXPECT_EQ(hiddenFiles("out"), 0U);
}

}  // namespace
}  // namespace betamesh
