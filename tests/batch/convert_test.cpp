// `betamesh convert`, and what commands say about the formats of files.

#include "io/extension.h"
#include "io/mesh_file.h"
#include "support/file_checks.h"
#include "support/job_folder.h"

namespace betamesh {
namespace {

class Convert : public JobFolder {
protected:
    Outcome convert(const std::string& from, const std::string& to, const std::vector<std::string>& further = {}) {
        std::vector<std::string> words{"convert", from, to};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path());
    }
};

TEST_F(Convert, AChainOfFormatsGivesTheSameBytes) {
    writeFrame(1, sampleParticles(500, true, true, true));
    const std::string first = contentsOf(folder_ / "in/a.0001.ply");
    std::string from = "in/a.0001.ply";
    for (const std::string to : {"b.bgeo", "b.bgeo.sc", "b.vtp", "b.csv", "b.bhclassic", "b.bgeo.gz", "b.ply"}) {
        const Outcome outcome = convert(from, to);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
        from = to;
    }
    EXPECT_EQ(contentsOf(folder_ / "b.ply"), first);

    const Mesh mesh = withComponents(sampleMesh(300, true, true));
    writeMesh(folder_ / "m.ply", mesh);
    from = "m.ply";
    for (const std::string to : {"n.bgeo", "n.bgeo.sc", "n.bhclassic", "n.ply"}) {
        ASSERT_EQ(convert(from, to).exit_code, 0) << to;
        from = to;
    }
    EXPECT_EQ(contentsOf(folder_ / "n.ply"), contentsOf(folder_ / "m.ply"));
    ASSERT_EQ(convert("m.ply", "n.vtp").exit_code, 0);
    ASSERT_EQ(convert("n.vtp", "o.bgeo").exit_code, 0);
    EXPECT_EQ(readMesh(folder_ / "o.bgeo").position, mesh.position);
    EXPECT_EQ(readMesh(folder_ / "o.bgeo").velocity, mesh.velocity);
    EXPECT_EQ(readMesh(folder_ / "o.bgeo").component, mesh.component);
}

TEST_F(Convert, FilesWithoutParticlesBecomeAnyFormat) {
    Particles nothing;
    nothing.attributes = {{"temp", 1, {}, {}}};
    writeParticles(folder_ / "a.ply", nothing);
    std::istringstream extensions(extensionsFor(FileKind::particles, Access::write));
    for (std::string extension; extensions >> extension;) {
        const Outcome outcome = convert("a.ply", "b" + extension);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(readParticles(folder_ / ("b" + extension)).size(), 0U);
    }
}

TEST_F(Convert, ASequenceIsConvertedFrameByFrame) {
    writeFrames(1, 4, 50);
    ASSERT_EQ(convert("in/a.####.ply", "out/b.%04d.csv", {"--frames", "2-3"}).exit_code, 0);
    EXPECT_FALSE(exists("out/b.0001.csv"));
    EXPECT_EQ(readParticles(folder_ / "out/b.0003.csv").position, readParticles(folder_ / "in/a.0003.ply").position);
    const Outcome again = convert("in/a.####.ply", "out/b.%04d.csv");
    EXPECT_EQ(again.exit_code, 2);
    EXPECT_NE(again.err.find("out/b.0002.csv already exists. Use --overwrite"), std::string::npos) << again.err;
    EXPECT_FALSE(exists("out/b.0001.csv"));
    EXPECT_EQ(convert("in/a.####.ply", "out/b.%04d.csv", {"--overwrite"}).exit_code, 0);
    EXPECT_TRUE(exists("out/b.0004.csv"));
    // A frame that cannot be read fails; the others are written.
    write(folder_ / "in/a.0002.ply", "ply\nnonsense");
    EXPECT_EQ(convert("in/a.####.ply", "out/c.####.vtp").exit_code, 1);
    EXPECT_TRUE(exists("out/c.0001.vtp") && !exists("out/c.0002.vtp") && exists("out/c.0003.vtp"));
    EXPECT_EQ(hiddenFiles("out"), 0U);
    EXPECT_EQ(convert("in/a.####.ply", "one.vtp").exit_code, 2);
    EXPECT_EQ(convert("in/a.0001.ply", "in/a.0001.ply", {"--overwrite"}).exit_code, 2);
}

TEST_F(Convert, WhatTheFormatCannotHoldIsNamedOnce) {
    Particles particles = sampleParticles(5, true, true, false);
    for (const int frame : {1, 2}) {
        particles.id[0] = 1ULL << 40;
        fs::create_directories(folder_ / "in");
        writeParticles(folder_ / numbered("in/p", frame, ".vtp"), particles);
    }
    const Outcome ids = convert("in/p.####.vtp", "p.####.ply");
    EXPECT_EQ(ids.exit_code, 0);
    EXPECT_EQ(count(ids.err, "ids need more than 32 bits"), 1U) << ids.err;
    EXPECT_TRUE(readParticles(folder_ / "p.0001.ply").id.empty());
    EXPECT_EQ(convert("in/p.0001.vtp", "p.vdb").err.find("ids"), std::string::npos);

    writeMesh(folder_ / "m.ply", withComponents(sampleMesh(10, true, true)));
    const Outcome stl = convert("m.ply", "m.stl");
    EXPECT_EQ(stl.exit_code, 0) << stl.err;
    EXPECT_NE(stl.err.find("without velocity, attributes and components"), std::string::npos) << stl.err;
    EXPECT_NE(convert("m.ply", "m.obj").err.find("without velocity and attributes"), std::string::npos);
    const Outcome refused = convert("m.ply", "m.csv");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("m.ply: contains a mesh. m.csv: '.csv' is not a format for meshes. Use one of"),
              std::string::npos)
        << refused.err;
    EXPECT_EQ(convert("m.ply", "m.prt").exit_code, 2);

    write(folder_ / "text.geo", R"(["pointcount",1,"attributes",["pointattributes",[
[["type","numeric","name","P"],["size",3,"storage","fpreal64","values",["size",3,"storage","fpreal64","tuples",[[1,2,3]]]]],
[["type","string","name","material"],["size",1,"storage","int32","strings",["a"],"indices",["arrays",[[0]]]]]],"globalattributes",[
[["type","numeric","name","frame"],["size",1,"storage","int32","values",["arrays",[[7]]]]]]]])");
    const Outcome text = convert("text.geo", "text.ply");
    EXPECT_EQ(text.exit_code, 0) << text.err;
    EXPECT_NE(text.err.find("left out: material (string)"), std::string::npos) << text.err;
    EXPECT_NE(text.err.find("not read: detail attribute 'frame'"), std::string::npos) << text.err;
    EXPECT_NE(text.err.find("rounded to 32 bits: P"), std::string::npos) << text.err;
}

TEST_F(Convert, AWrongExtensionIsToldAndTheContentsConverted) {
    writeFrames(1, 1, 20);
    fs::copy_file(folder_ / "in/a.0001.ply", folder_ / "x.bgeo");
    const Outcome converted = convert("x.bgeo", "y.csv");
    EXPECT_EQ(converted.exit_code, 0) << converted.err;
    EXPECT_NE(converted.err.find("contains PLY"), std::string::npos) << converted.err;
    const Outcome meshed = runProgram({"mesh", "x.bgeo", "m.ply", "--radius", "1"}, folder_.path());
    EXPECT_EQ(meshed.exit_code, 1);
    EXPECT_NE(meshed.err.find("x.bgeo: contains PLY, not Houdini geometry. Rename it so that it ends in .ply."),
              std::string::npos)
        << meshed.err;
    const auto info = jsonLines(runProgram({"info", "--json", "x.bgeo"}, folder_.path()).out);
    ASSERT_EQ(info.size(), 1U);
    EXPECT_NE(info[0]["note"].get<std::string>().find("contains PLY"), std::string::npos);
}

TEST_F(Convert, JobsReadAndWriteTheNewFormatsAndWarnOncePerJob) {
    writeFrames(1, 2, 60);
    ASSERT_EQ(convert("in/a.####.ply", "csv/a.####.csv").exit_code, 0);
    const std::vector<std::string> options{"--radius", "1.5dx", "--components"};
    ASSERT_EQ(mesh(options).exit_code, 0);
    std::vector<std::string> words{"mesh", "csv/a.####.csv", "v/a.####.ply"};
    words.insert(words.end(), options.begin(), options.end());
    ASSERT_EQ(runProgram(words, folder_.path()).exit_code, 0);
    EXPECT_EQ(contentsOf(folder_ / "v/a.0002.ply"), contentsOf(folder_ / "out/a.0002.ply"));
    const std::vector<std::pair<std::string, std::string>> outputs{
        {"out/b.####.stl", "without velocity and components"},
        {"out/b.####.obj", "without velocity, which"},
        {"out/b.####.bgeo", "write .bhclassic"},
        {"out/b.####.bhclassic", ""},
        {"out/b.####.vtp", ""}};
    for (const auto& [output, warning] : outputs) {
        const Outcome outcome = mesh(options, output);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(count(outcome.err, "warning"), warning.empty() ? 0U : 1U) << outcome.err;
        EXPECT_NE(outcome.err.find(warning), std::string::npos) << outcome.err;
    }
    const Mesh written = readMesh(folder_ / "out/b.0001.vtp");
    EXPECT_EQ(written.position, readMesh(folder_ / "out/a.0001.ply").position);
    EXPECT_EQ(written.attributes.back().name, "N");
    ASSERT_EQ(runProgram({"check", "out/b.0001.vtp"}, folder_.path()).exit_code, 0);
    EXPECT_EQ(runProgram({"check", "out/b.0001.stl"}, folder_.path()).exit_code, 2);
}

}  // namespace
}  // namespace betamesh
