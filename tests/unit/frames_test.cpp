#include "batch/job/frames.h"

#include "betamesh/error.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <set>

namespace betamesh {
namespace {

/// Ascending frames, each once: runs, steps and single frames, negative and positive.
std::vector<int> randomFrames(unsigned seed) {
    std::mt19937 random(seed);
    std::set<int> frames;
    for (unsigned part = 0; part < seed % 5 + 1; ++part) {
        const int first = static_cast<int>(random() % 400) - 200;
        const int step = static_cast<int>(random() % 4) + 1;
        const int count = static_cast<int>(random() % 12) + 1;
        for (int i = 0; i < count; ++i) frames.insert(first + i * step);
    }
    return {frames.begin(), frames.end()};
}

std::string messageOf(const std::string& frames) {
    try {
        parseFrames(frames);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Frames, PrintedFramesAreParsedBack) {
    for (unsigned seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        const auto frames = randomFrames(seed);
        EXPECT_EQ(parseFrames(printFrames(frames)), frames) << printFrames(frames);
    }
}

TEST(Frames, ParsesEveryDocumentedForm) {
    EXPECT_EQ(parseFrames("7"), (std::vector<int>{7}));
    EXPECT_EQ(parseFrames("1-4"), (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(parseFrames("1-8x3"), (std::vector<int>{1, 4, 7}));
    EXPECT_EQ(parseFrames("20-22,1-2,15,2"), (std::vector<int>{1, 2, 15, 20, 21, 22}));
    EXPECT_EQ(parseFrames("-5--3"), (std::vector<int>{-5, -4, -3}));
    EXPECT_EQ(parseFrames("-1-1"), (std::vector<int>{-1, 0, 1}));
    EXPECT_EQ(parseFrames("2147483646-2147483647"),
              (std::vector<int>{std::numeric_limits<int>::max() - 1, std::numeric_limits<int>::max()}));
}

TEST(Frames, RefusesInvalidTextAndNamesTheValidForms) {
    for (const char* text :
         {"",        " ",     "a",     "1-",  "-",   "1,,2",        "1,",         ",1", "5-1",   "1-10x0",
          "1-10x-2", "1-10x", "1 - 3", "1;2", "1.5", "99999999999", "1-99999999", "+3", "1-3-5", "1x2"}) {
        SCOPED_TRACE(text);
        EXPECT_NE(messageOf(text).find("Use a form such as"), std::string::npos) << messageOf(text);
    }
}

TEST(Frames, RefusesTheColonWithTheReason) {
    EXPECT_NE(messageOf("1-10:2").find("OpenJD"), std::string::npos);
    EXPECT_NE(messageOf("1-10:2").find("OpenCue"), std::string::npos);
    EXPECT_NE(messageOf("1-10:2").find("1-10x2"), std::string::npos);
}

TEST(Frames, ChunksAreAContiguousPartitionOfEvenSizes) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const auto frames = randomFrames(seed);
        const int count = static_cast<int>(seed % 17) + 1;
        std::vector<int> joined;
        std::size_t smallest = frames.size();
        std::size_t largest = 0;
        for (int index = 1; index <= count; ++index) {
            const auto chunk = chunkOf(frames, {index, count});
            joined.insert(joined.end(), chunk.begin(), chunk.end());
            smallest = std::min(smallest, chunk.size());
            largest = std::max(largest, chunk.size());
        }
        EXPECT_EQ(joined, frames);
        EXPECT_LE(largest - smallest, 1U);
    }
}

TEST(Frames, RefusesChunksThatDoNotExist) {
    for (const char* text : {"0/3", "4/3", "1", "1/0", "/", "a/b", "-1/3", "1/2/3", ""}) {
        SCOPED_TRACE(text);
        EXPECT_THROW(parseChunk(text), Error);
    }
    EXPECT_EQ(parseChunk("3/8").index, 3);
    EXPECT_EQ(parseChunk("3/8").count, 8);
}

TEST(FramePattern, KnowsEveryPlaceholder) {
    EXPECT_EQ(frameName(framePattern("sim/a.####.vdb"), 12), "sim/a.0012.vdb");
    EXPECT_EQ(frameName(framePattern("sim/a.@@.vdb"), 7), "sim/a.07.vdb");
    EXPECT_EQ(frameName(framePattern("a_%04d.ply"), 12), "a_0012.ply");
    EXPECT_EQ(frameName(framePattern("a_%d.ply"), 12), "a_12.ply");
    EXPECT_EQ(frameName(framePattern("a.$F4.bgeo.gz"), 12), "a.0012.bgeo.gz");
    EXPECT_EQ(frameName(framePattern("a.$F.bgeo"), 12), "a.12.bgeo");
    EXPECT_EQ(frameName(framePattern("C#/a.###.ply"), 1), "C#/a.001.ply");
}

TEST(FramePattern, WritesLongAndNegativeNumbersInFull) {
    EXPECT_EQ(frameName(framePattern("a.####.ply"), 123456), "a.123456.ply");
    EXPECT_EQ(frameName(framePattern("a.####.ply"), -5), "a.-005.ply");
    EXPECT_EQ(frameName(framePattern("a.%04d.ply"), -12345), "a.-12345.ply");
    EXPECT_EQ(frameName(framePattern("a.#.ply"), 10), "a.10.ply");
}

TEST(FramePattern, ANameWithoutPlaceholderIsOneFile) {
    const auto frameIn = [](const char* name) { return frameInName(name); };
    EXPECT_FALSE(framePattern("a.0012.ply").numbered);
    EXPECT_EQ(frameIn("sim/a.0012.ply"), 12);
    EXPECT_EQ(frameIn("a.0012.bgeo.gz"), 12);
    EXPECT_EQ(frameIn("a_-003.ply"), -3);
    EXPECT_EQ(frameIn("drop-3.ply"), 3);
    EXPECT_EQ(frameIn("v2_drop.ply"), 0);
    EXPECT_EQ(frameIn("drop.ply"), 0);
    for (const char* version : {"drop_v002.usda", "drop.v12.bgeo.sc", "drop-V3.ply", "v2.ply", "drop.0007_v002.ply"})
        EXPECT_EQ(frameIn(version), 0) << version;
    for (const char* frame : {"drop_v002.0012.ply", "v2_12.ply", "wav12.ply", "drop.v2.12.ply", "v2/12.ply"})
        EXPECT_EQ(frameIn(frame), 12) << frame;
}

TEST(FramePattern, AllPlaceholdersStandForTheSameNumber) {
    EXPECT_EQ(frameName(framePattern("v2/####/a.ply"), 12), "v2/0012/a.ply");
    EXPECT_EQ(frameName(framePattern("a.$F4/b.$F4.ply"), 7), "a.0007/b.0007.ply");
    EXPECT_EQ(frameName(framePattern("take@2.####.ply"), 7), "take@2.0007.ply");
    EXPECT_EQ(frameName(framePattern("100%_#1_%04d.ply"), 7), "100%_#1_0007.ply");
    EXPECT_THROW(framePattern("a.##.@@.ply"), Error);
    EXPECT_THROW(framePattern("##/a.####.ply"), Error);
}

TEST(FramePattern, ReplacesVariablesOfTheEnvironment) {
    ::setenv("BETAMESH_SHOT", "sh010", 1);
    ::unsetenv("BETAMESH_NONE");
    EXPECT_EQ(withVariables("a/$BETAMESH_SHOT/${BETAMESH_SHOT}_x.####.ply"), "a/sh010/sh010_x.####.ply");
    EXPECT_EQ(frameName(framePattern("$BETAMESH_SHOT.$F4.ply"), 3), "sh010.0003.ply");
    for (const char* plain : {"a.$F.ply", "a.$F4.ply", "$", "a$", "a$.ply", "${", "${BETAMESH_SHOT", "cost$ 5.ply", ""})
        EXPECT_EQ(withVariables(plain), plain);
    EXPECT_THROW(withVariables("$BETAMESH_NONE/a.ply"), Error);
    EXPECT_THROW(framePattern("${BETAMESH_NONE}.####.ply"), Error);
}

TEST(FramePattern, BeginsInTheHomeFolderAfterATilde) {
    const char* const known = std::getenv("HOME");
    const std::string before = known == nullptr ? "" : known;
    ::setenv("HOME", "/home/somebody", 1);
    EXPECT_EQ(withVariables("~/sim/a.####.vdb"), "/home/somebody/sim/a.####.vdb");
    EXPECT_EQ(withVariables("~"), "/home/somebody");
    EXPECT_EQ(frameName(framePattern("~/a.####.ply"), 3), "/home/somebody/a.0003.ply");
    for (const char* plain : {"./~/a.ply", "a/~/b.ply", "~a.ply", "a~", " ~/a.ply"})
        EXPECT_EQ(withVariables(plain), plain);
    EXPECT_THROW(withVariables("~other/a.ply"), Error);
    ::unsetenv("HOME");
    EXPECT_THROW(withVariables("~/a.ply"), Error);
    if (known != nullptr) ::setenv("HOME", before.c_str(), 1);
}

TEST(FramePattern, FindsOnDiskExactlyTheFilesItWrites) {
    const TemporaryFolder folder;
    const FramePattern pattern = framePattern(folder / "a.####.ply");
    const std::vector<int> frames{-12345, -5, 0, 1, 20, 9999, 10000};
    for (const int frame : frames) write(frameName(pattern, frame), "");
    for (const char* other : {"a.1.ply", "a.00001.ply", "a.0002.ply.json", ".a.0003.ply", "a.0004.spheres.ply",
                              "a.x.ply", "b.0005.ply", "a..ply", "a.+006.ply", "a.-0007.ply"}) {
        write(folder / other, "");
    }
    std::vector<int> found;
    for (const auto& [frame, file] : framesOnDisk(pattern)) {
        found.push_back(frame);
        EXPECT_EQ(file, frame == -7 ? folder / "a.-0007.ply" : frameName(pattern, frame));
    }
    EXPECT_EQ(found, (std::vector<int>{-12345, -7, -5, 0, 1, 20, 9999, 10000}));
    EXPECT_TRUE(framesOnDisk(framePattern(folder / "nowhere/a.####.ply")).empty());
}

TEST(FramePattern, FindsFramesInNumberedFolders) {
    const TemporaryFolder folder;
    for (const char* name : {"0001/a.ply", "0002/a.ply", "0003/b.ply", "4/a.ply", "x/a.ply", "0005/a.0005.ply"}) {
        std::filesystem::create_directories(std::filesystem::path(folder / name).parent_path());
        write(folder / name, "");
    }
    EXPECT_EQ(framesOnDisk(framePattern(folder / "####/a.ply")),
              (std::map<int, std::string>{{1, folder / "0001/a.ply"}, {2, folder / "0002/a.ply"}}));
    EXPECT_EQ(framesOnDisk(framePattern(folder / "####/a.####.ply")),
              (std::map<int, std::string>{{5, folder / "0005/a.0005.ply"}}));
    EXPECT_TRUE(isFrameOf(framePattern(folder / "####/a.ply"), folder / "x/../0017/a.ply"));
    EXPECT_FALSE(isFrameOf(framePattern(folder / "####/a.ply"), folder / "0017/b.ply"));
}

TEST(FramePattern, EveryFileWithANumberIsAFrameOrOneOfTheOthers) {
    const TemporaryFolder folder;
    for (const char* name : {"a.0001.ply", "a.0001.25.ply", "a.0002.5.ply", "a.2.ply", "a.-0003.ply", "a.-003.ply",
                             "a.00004.ply", "a.x.ply", "a.1.x.ply", "b.0001.ply", "a.0005.ply.json"})
        write(folder / name, "");
    const FramePattern pattern = framePattern(folder / "a.####.ply");
    EXPECT_EQ(framesOnDisk(pattern),
              (std::map<int, std::string>{{-3, folder / "a.-003.ply"}, {1, folder / "a.0001.ply"}}));
    const OtherNumbers others = otherNumbersOnDisk(pattern);
    EXPECT_EQ(others.subframes, (std::vector<std::string>{folder / "a.0001.25.ply", folder / "a.0002.5.ply"}));
    EXPECT_EQ(others.padded,
              (std::vector<std::string>{folder / "a.-0003.ply", folder / "a.00004.ply", folder / "a.2.ply"}));
}

TEST(FramePattern, OfAnInputMayBeAFolderOrAFileWhoseNameLooksLikeAPattern) {
    const TemporaryFolder folder;
    const std::string sim = folder / "sim";
    EXPECT_TRUE(inputPattern(sim).numbered == false);  // nothing there: a file that does not exist
    std::filesystem::create_directories(sim);
    EXPECT_THROW(inputPattern(sim), Error);
    for (const char* name : {"v2_a.0008.ply", "v2_a.0009.ply", "v2_a.0010.ply", "notes.txt", ".v2_a.0011.ply"})
        write(folder / (std::string("sim/") + name), "");
    EXPECT_EQ(inputPattern(sim).text, sim + "/v2_a.####.ply");
    EXPECT_EQ(framesOnDisk(inputPattern(sim)).size(), 3U);
    write(folder / "sim/b.ply", "");
    EXPECT_THROW(inputPattern(sim), Error);

    for (const char* name : {"take#1.ply", "a.####.ply", "50%04d.ply", "x@y.ply", "$HOME.ply"}) {
        write(folder / name, "");
        EXPECT_EQ(inputPattern(folder / name).text, folder / name);
        EXPECT_FALSE(inputPattern(folder / name).numbered) << name;
    }
}

}  // namespace
}  // namespace betamesh
