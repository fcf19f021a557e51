// `betamesh convert`, and what commands say about the formats of files.

#include "io/extension.h"
#include "io/file_info.h"
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

TEST_F(Convert, PointGroupsStayGroups) {
    Particles particles = sampleParticles(500, true, true, false);
    Attribute group{"group:foam", 1, {}, {}};
    for (std::size_t i = 0; i < particles.size(); ++i) group.integer.push_back(i % 3 == 0);
    particles.attributes.push_back(group);
    writeParticles(folder_ / "a.bgeo", particles);
    std::string from = "a.bgeo";
    for (const std::string to : {"b.vdb", "c.bgeo", "d.vdb"}) {
        const Outcome outcome = convert(from, to);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << to << ": " << outcome.err;
        EXPECT_EQ(inspectFile(folder_ / to).groups, std::vector<std::string>{"foam"}) << to;
        ParticleInput input;
        input.group = {"foam"};
        EXPECT_EQ(readParticles(folder_ / to, input).size(), 167U) << to;
        from = to;
    }
    // Formats without groups hold them as an attribute of ones and zeros.
    ASSERT_EQ(convert("d.vdb", "e.csv").exit_code, 0);
    const Particles table = readParticles(folder_ / "e.csv");
    ASSERT_EQ(table.attributes.size(), 1U);
    EXPECT_EQ(table.attributes[0].name, "group:foam");
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
    const Outcome normals = convert("m.obj", "n.ply");
    EXPECT_EQ(normals.err.find("warning"), std::string::npos) << normals.err;
    EXPECT_EQ(readMesh(folder_ / "n.ply").attributes.at(0).name, "N");
    EXPECT_EQ(convert("m.obj", "n.obj").err.find("warning"), std::string::npos);
    write(folder_ / "paint.obj",
          "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\n");
    EXPECT_NE(convert("paint.obj", "paint.ply")
                  .err.find("paint.obj: not read: colours of vertices, texture coordinates (vt), normals (vn)"),
              std::string::npos);
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
    write(folder_ / "large.csv", "x,y,z,heat\n0,0,0,1\n1,1,1,1e39\n");
    const Outcome large = convert("large.csv", "large.ply");
    EXPECT_NE(large.err.find("numbers become infinite: 'heat' of particle 1 is 1e+39 (line 3)"), std::string::npos)
        << large.err;
}

TEST_F(Convert, FrameRateUpAxisAndUnitAreThoseOfTheInput) {
    const Particles particles = sampleParticles(4, true, true, false);
    writeParticles(folder_ / "in.usda", particles,
                   {.frames_per_second = 25, .up_axis = UpAxis::z, .meters_per_unit = 0.01});
    const std::string whole = contentsOf(folder_ / "in.usda");
    const Outcome same = convert("in.usda", "out.usda");
    EXPECT_EQ(same.exit_code, 0) << same.err;
    EXPECT_EQ(same.err.find("warning"), std::string::npos) << same.err;
    EXPECT_EQ(contentsOf(folder_ / "out.usda"), whole);
    // Another format keeps what it has a place for, and the numbers.
    ASSERT_EQ(convert("in.usda", "out.abc").exit_code, 0);
    ASSERT_EQ(convert("out.abc", "back.usda").exit_code, 0);
    EXPECT_NE(contentsOf(folder_ / "back.usda").find("timeCodesPerSecond = 25\n"), std::string::npos);
    const Outcome lost = convert("in.usda", "out.ply");
    EXPECT_NE(lost.err.find("z is up, which the output cannot store"), std::string::npos) << lost.err;
    EXPECT_NE(lost.err.find("a unit is 0.01 metres long, which the output cannot store"), std::string::npos);
    EXPECT_EQ(readParticles(folder_ / "out.ply").position, readParticles(folder_ / "in.usda").position);
    // Options win.
    const Outcome given =
        convert("in.usda", "given.usda", {"--output-fps", "30", "--output-up-axis", "y", "--meters-per-unit", "1"});
    EXPECT_EQ(given.exit_code, 0) << given.err;
    const std::string text = contentsOf(folder_ / "given.usda");
    EXPECT_NE(text.find("timeCodesPerSecond = 30\n"), std::string::npos);
    EXPECT_NE(text.find("metersPerUnit = 1\n"), std::string::npos);
    EXPECT_NE(text.find("upAxis = \"Y\""), std::string::npos);
    EXPECT_EQ(readParticles(folder_ / "given.usda").position, particles.position);
    ASSERT_EQ(convert("out.ply", "turned.ply", {"--up-axis", "z"}).exit_code, 0);
    EXPECT_EQ(readParticles(folder_ / "turned.ply").position, particles.position);
    EXPECT_EQ(convert("in.usda", "x.usda", {"--output-up-axis", "x"}).exit_code, 2);
}

TEST_F(Convert, TheLayerOfASequenceHasItsFrameRateUpAxisAndUnit) {
    for (const int frame : {1, 2})
        writeParticles(folder_ / numbered("a", frame, ".usda"), sampleParticles(4, true, true, false),
                       {.frames_per_second = 25, .frame = frame, .up_axis = UpAxis::z, .meters_per_unit = 0.01});
    ASSERT_EQ(convert("a.####.usda", "b.####.usda").exit_code, 0);
    EXPECT_EQ(contentsOf(folder_ / "b.0002.usda"), contentsOf(folder_ / "a.0002.usda"));
    const std::string layer = contentsOf(folder_ / "b.usda");
    for (const char* line : {"timeCodesPerSecond = 25\n", "metersPerUnit = 0.01\n", "upAxis = \"Z\"\n"})
        EXPECT_NE(layer.find(line), std::string::npos) << layer;
}

TEST_F(Convert, NamesThatAFormatCannotStoreAreChanged) {
    write(folder_ / "p.csv", "x,y,z,points,widths,a b,a/b,a.b.c,velocity,Points\n1,2,3,1,2,3,4,5,6,7\n");
    for (const auto& [to, names] :
         {std::pair<std::string, std::vector<std::string>>{"p.usda", {"points_", "widths_", "a_b", "a/b", "a.b.c"}},
          {"p.vdb", {"points", "widths", "a_b", "a_b_2", "a_b_c"}},
          {"p.abc", {"points", "widths", "a_b", "a_b_2", "a.b.c"}},
          {"p.vtp", {"points", "widths", "a_b", "a/b", "velocity_", "Points_"}},
          {"p.ply", {"points", "widths", "a_b", "a/b", "velocity"}}}) {
        SCOPED_TRACE(to);
        const Outcome outcome = convert("p.csv", to);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(count(outcome.err, "cannot hold some names of attributes"), to == "p.ply" ? 0U : 1U) << outcome.err;
        const Particles read = readParticles(folder_ / to);
        for (const std::string& name : names)
            EXPECT_TRUE(std::any_of(read.attributes.begin(), read.attributes.end(), [&](const Attribute& a) {
                return a.name == name;
            })) << name;
    }
}

TEST_F(Convert, NumbersThatChangeAreNamed) {
    write(folder_ / "p.ply",
          "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
          "property uint big\nproperty int id\nend_header\n0 0 0 4294967295 -1\n1 0 0 7 5\n");
    const Outcome big = convert("p.ply", "p.vdb");
    EXPECT_NE(big.err.find("whole numbers from 2^31 on become floats of single precision: big"), std::string::npos)
        << big.err;
    for (const char* name : {"p.vdb", "p.usda", "p.abc", "p.vtp", "p.csv", "p.bgeo", "q.ply"}) {
        ASSERT_EQ(convert("p.ply", name, {"--overwrite"}).exit_code, 0) << name;
        std::vector<std::uint64_t> ids = readParticles(folder_ / name).id;
        std::sort(ids.begin(), ids.end());
        EXPECT_EQ(ids, (std::vector<std::uint64_t>{5, static_cast<std::uint64_t>(-1)})) << name;
    }
    const Outcome classic = convert("p.ply", "p.bhclassic");
    EXPECT_EQ(classic.exit_code, 0);
    EXPECT_NE(classic.err.find("ids are negative or need more than 32 bits"), std::string::npos) << classic.err;
}

TEST_F(Convert, WholeNumbersThatBecomeNegativeAreNamed) {
    const auto said = [&](const std::string& first, const std::string& second) {
        write(folder_ / "p.ply",
              "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
              "property uint64 id\nproperty uint64 key\nend_header\n0 0 0 " +
                  first + "\n1 0 0 " + second + '\n');
        const Outcome outcome = convert("p.ply", "p.csv", {"--overwrite"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::string words = "whole numbers from 2^63 on become negative (2^64 less): ";
        const std::size_t at = outcome.err.find(words);
        return at == std::string::npos
                   ? std::string("nothing")
                   : outcome.err.substr(at + words.size(), outcome.err.find('\n', at) - at - words.size());
    };
    const std::string most = "18446744073709551615", half = "9223372036854775808", less = "9223372036854775807";
    EXPECT_EQ(said("1 2", "3 4"), "nothing");
    EXPECT_EQ(said("1 " + less, less + " 4"), "nothing");
    EXPECT_EQ(said("1 2", half + " 4"), "id");
    EXPECT_EQ(said(most + " 2", "3 4"), "id");
    EXPECT_EQ(said("1 " + half, "3 4"), "key");
    EXPECT_EQ(said("1 " + most, most + ' ' + half), "id, key");
    EXPECT_NE(runProgram({"mesh", "p.ply", "m.ply", "--radius", "1", "--attributes", "key"}, folder_.path())
                  .err.find("those from 2^63 on become negative (2^64 less)"),
              std::string::npos);
}

TEST_F(Convert, BadParticlesAndObjectsAreChosenByOptions) {
    writeFrameWithNaN(1);
    const Outcome refused = convert("in/a.0001.ply", "b.csv");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("--on-bad-particle drop"), std::string::npos) << refused.err;
    const Outcome dropped = convert("in/a.0001.ply", "b.csv", {"--on-bad-particle", "drop"});
    EXPECT_EQ(dropped.exit_code, 0) << dropped.err;
    EXPECT_NE(dropped.err.find("1 particle is left out"), std::string::npos) << dropped.err;
    EXPECT_EQ(readParticles(folder_ / "b.csv").size(), 19U);
}

TEST_F(Convert, ALevelSetWithoutAnInsideIsAnErrorAndAnEmptyOneAWarning) {
    write(folder_ / "open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const Outcome open = convert("open.obj", "open.vdb");
    EXPECT_EQ(open.exit_code, 1);
    EXPECT_NE(open.err.find("the mesh has no inside"), std::string::npos) << open.err;
    EXPECT_FALSE(exists("open.vdb"));
    write(folder_ / "t.obj", "v .1 .1 .1\nv .2 .1 .1\nv .1 .2 .1\nv .1 .1 .2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    const Outcome empty = convert("t.obj", "t.vdb", {"--voxel", "1"});
    EXPECT_EQ(empty.exit_code, 0);
    EXPECT_NE(empty.err.find("the level set is empty"), std::string::npos) << empty.err;
    for (const char* voxel : {"nan", "inf", "-1", "1e-400x"}) {
        const Outcome wrong = convert("t.obj", "u.vdb", {"--voxel", voxel});
        EXPECT_EQ(wrong.exit_code, 2);
        EXPECT_NE(wrong.err.find(std::string("--voxel: '") + voxel + "' is not valid. Use a number of at least 0"),
                  std::string::npos)
            << wrong.err;
    }
    const Outcome large = convert("t.obj", "u.vdb", {"--voxel", "1e-7"});
    EXPECT_EQ(large.exit_code, 33);
    EXPECT_NE(large.err.find("GB of memory"), std::string::npos) << large.err;
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
