// What a job prints and logs: JSON, log files, progress.

#include "support/job_folder.h"

#include <set>

namespace betamesh {
namespace {

using Job = JobFolder;

TEST_F(Job, JsonPrintsOneObjectPerFrameAndNothingElseOnStdout) {
    writeFrames(1, 4);
    writeFrameWithNaN(5);
    for (const char* progress : {"auto", "bar", "none", "openjd", "tractor"}) {
        SCOPED_TRACE(progress);
        const Outcome outcome = mesh({"--json", "-v", "--overwrite", "--frames", "1-6", "--progress", progress});
        EXPECT_EQ(outcome.exit_code, 1);
        std::set<int> frames;
        for (const Json& line : jsonLines(outcome.out)) {
            ASSERT_TRUE(line.is_object()) << outcome.out;
            frames.insert(line["frame"].get<int>());
            for (const char* key : {"input",
                                    "output",
                                    "status",
                                    "particles",
                                    "radius",
                                    "spacing",
                                    "skin",
                                    "predicates",
                                    "perturbation_retries",
                                    "alpha_triangles",
                                    "double_sided_triangles",
                                    "degenerate_edges",
                                    "isolated_particles",
                                    "vertices",
                                    "triangles",
                                    "components",
                                    "euler",
                                    "volume",
                                    "area",
                                    "peak_bytes",
                                    "warnings"}) {
                EXPECT_TRUE(line.contains(key)) << key;
            }
            for (const char* key : {"read", "structure", "tessellate", "smooth", "velocity", "write", "total"}) {
                EXPECT_TRUE(line["seconds"].contains(key)) << key;
            }
            EXPECT_EQ(line["status"] == "failed", line["frame"] >= 5);
            EXPECT_EQ(line.contains("error"), line["frame"] >= 5);
            EXPECT_GT(line["peak_bytes"].get<std::uint64_t>(), 1'000'000U);
        }
        EXPECT_EQ(frames, (std::set<int>{1, 2, 3, 4, 5, 6}));
    }
}

TEST_F(Job, ALogFileContainsAllMessagesAndDetails) {
    writeFrames(1, 3);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "-q"}).exit_code, 0);
    const std::string once = contentsOf(folder_ / "logs/job.log");
    EXPECT_EQ(count(once, "debug: frame "), 3U) << once;
    EXPECT_EQ(count(once, "info: 3 of 3 frames written"), 1U);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "--frames", "1-4", "--overwrite"}).exit_code, 1);
    const std::string twice = contentsOf(folder_ / "logs/job.log");
    EXPECT_TRUE(twice.starts_with(once));
    EXPECT_EQ(count(twice, "error: frame 4: in/a.0004.ply"), 1U) << twice;
    write(folder_ / "file", "");
    EXPECT_EQ(mesh({"--log-file", "file/job.log"}).exit_code, 2);

    // A full log file is renamed.
    fs::resize_file(folder_ / "logs/job.log", 9'999'900);
    EXPECT_EQ(mesh({"--log-file", "logs/job.log", "--overwrite"}).exit_code, 0);
    EXPECT_TRUE(exists("logs/job.1.log"));
    EXPECT_LT(fs::file_size(folder_ / "logs/job.log"), 100'000U);
}

TEST_F(Job, FramesOfWhichNoneIsThereAreAnsweredWithThoseThatAre) {
    writeFrames(1, 2, 1);
    const Outcome outcome = mesh({"--frames", "5-6", "--radius", "1"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(count(outcome.err, "'in/a.####.ply': none of the frames 5-6 is there, only 1-2"), 1U) << outcome.err;
    const Outcome some = mesh({"--frames", "2-3", "--radius", "1"});
    EXPECT_EQ(some.err.find("none of the frames"), std::string::npos) << some.err;
    EXPECT_NE(some.err.find("frame 2: 1 particle, "), std::string::npos) << some.err;
}

TEST_F(Job, ProgressForMachinesCountsToTheEnd) {
    writeFrames(1, 4);
    for (const bool json : {false, true}) {
        std::vector<std::string> words{"--progress", "json", "--frames", "1-5", "--overwrite", "-q"};
        if (json) words.push_back("--json");
        const Outcome outcome = mesh(words);
        EXPECT_EQ(outcome.exit_code, 1);
        std::size_t ended = 0;
        for (const Json& line : jsonLines(json ? outcome.err : outcome.out)) {
            if (!line.is_object()) continue;  // errors among them
            EXPECT_EQ(line["ended"], ++ended);
            EXPECT_EQ(line["frames"], 5);
            EXPECT_GE(line["seconds_left"].get<double>(), 0);
            EXPECT_EQ(line["seconds_left"] == 0, ended == 5);
            if (ended < 5) continue;
            EXPECT_EQ(line["failed"], 1);
            EXPECT_GT(line["particles"].get<int>(), 4 * 300);
        }
        EXPECT_EQ(ended, 5U);
    }
}

TEST_F(Job, ProgressIsPrintedAsEachFarmEngineExpects) {
    writeFrames(1, 4);
    const Outcome openjd = mesh({"--progress", "openjd", "--frames", "1-5"});
    EXPECT_EQ(openjd.exit_code, 1);
    EXPECT_NE(openjd.out.find("openjd_progress: 20\nopenjd_status: "), std::string::npos) << openjd.out;
    EXPECT_NE(openjd.out.find("openjd_progress: 100\n"), std::string::npos);
    EXPECT_EQ(count(openjd.out, "openjd_fail: "), 1U);
    const Outcome tractor = mesh({"--progress", "tractor", "--overwrite"});
    EXPECT_EQ(tractor.out, "TR_PROGRESS 025%\nTR_PROGRESS 050%\nTR_PROGRESS 075%\nTR_PROGRESS 100%\n");
    const Outcome quiet = mesh({"-q", "--overwrite"});
    EXPECT_EQ(quiet.out + quiet.err, "");
}

}  // namespace
}  // namespace betamesh
