#include "io/obj.h"

#include "io/file_info.h"
#include "io/mesh_file.h"
#include "support/file_checks.h"
#include "support/file_samples.h"
#include "support/temporary_folder.h"

namespace betamesh {

namespace {

Mesh meshOfObj(std::string_view text) { return meshFrom(parseObj(bytesOf(text), "t.obj"), "t.obj"); }

}  // namespace

TEST(ObjFile, PositionsAndFacesSurviveARoundTrip) {
    const TemporaryFolder folder;
    for (const std::size_t n : {0U, 1U, 3U, 5000U}) {
        Mesh mesh = sampleMesh(n, true, true);
        writeMesh(folder / "a.obj", mesh);
        mesh.velocity.clear();
        mesh.attributes.clear();
        Mesh read = readMesh(folder / "a.obj");
        EXPECT_EQ(read.attributes.size(), n > 0 ? 1U : 0U);
        read.attributes.clear();
        expectSame(read, mesh);
    }
}

TEST(ObjFile, NormalsOfVerticesAreRead) {
    const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 .6 .8\nvn 1 0 0\n";
    for (const char* face : {"f 1//1 2//2 3//3\n", "vt 0 0\nf 1/1/1 2/1/2 3/1/3\n", "f -3//-3 2//-2 -1//3\n"}) {
        const Mesh mesh = meshOfObj(start + face);
        ASSERT_EQ(mesh.attributes.size(), 1U) << face;
        EXPECT_EQ(mesh.attributes[0].name, "N");
        EXPECT_EQ(mesh.attributes[0].components, 3U);
        EXPECT_EQ(mesh.attributes[0].real, (std::vector<float>{0, 0, 1, 0, 0.6F, 0.8F, 1, 0, 0}));
    }
    const TemporaryFolder folder;
    const Mesh mesh = meshOfObj(start + "f 1//1 2//2 3//3\n");
    writeMesh(folder / "a.obj", mesh);
    expectSame(readMesh(folder / "a.obj"), mesh);
    for (const char* face :
         {"f 1//1 2//1 3//1\n", "f 1 2 3\n", "f 1/1 2/2 3/3\n", "f 1//1 2//2 3//\n", "vn 0 0 1\nf 1//1 2//2 3//3\n",
          "v 0 0 1\nvn -1.#IND 0 1\nf 1//1 2//2 3//3\n", "v 0 0 1\nvn 0 1\nf 1//1 2//2 3//3\n"}) {
        const FileContents contents = parseObj(bytesOf(start + face), "t.obj");
        EXPECT_TRUE(contents.attributes.empty()) << face;
        EXPECT_EQ(contents.passed_over, std::vector<std::string>{"normals (vn) that are not one per vertex"}) << face;
    }
}

TEST(ObjFile, TellsWhatItDoesNotRead) {
    const auto passedOver = [](const std::string& text) { return parseObj(bytesOf(text), "t.obj").passed_over; };
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    EXPECT_TRUE(passedOver("# comment\n#v 1\n\n \ns off\ns 0\no component_1\n" + triangle).empty());
    for (const auto& [line, what] :
         {std::pair("vt 0 0\nvt 0 1", "texture coordinates (vt)"),
          {"usemtl a", "materials (mtllib, usemtl)"},
          {"mtllib a.mtl", "materials (mtllib, usemtl)"},
          {"g a b", "groups (g)"},
          {"s 1", "smoothing groups (s)"},
          {"o thing", "objects (o)"},
          {"p 1", "point elements (p)"},
          {"v 0 0 0 1 .5 0", "colours of vertices"},
          {"v 0 0 0 1", "weights of vertices"},
          {"o component_1\nf 1 2 3", "objects (o)"},
          {"vp 1\ncstype x", "lines of other kinds than v, vn, vt, f, l, p, o, g, s, mtllib and usemtl"}})
        EXPECT_EQ(passedOver(triangle + line + "\n"), std::vector<std::string>{what}) << line;
}

TEST(ObjFile, ComponentsBecomeObjects) {
    const TemporaryFolder folder;
    const Mesh mesh = withComponents(sampleMesh(1000, true, false));
    writeMesh(folder / "a.obj", mesh);
    const Mesh read = readMesh(folder / "a.obj");
    EXPECT_EQ(read.position, mesh.position);
    ASSERT_TRUE(read.component);
    EXPECT_TRUE(std::is_sorted(read.component->begin(), read.component->end()));
    std::vector<Triangle> expected;
    for (std::int32_t component = 0; component < 5; ++component)
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            if ((*mesh.component)[i] == component) expected.push_back(mesh.triangles[i]);
    EXPECT_EQ(read.triangles, expected);
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ((*read.component)[i], (7 * expected[i][0]) % 5);
    const std::string text = contentsOf(folder / "a.obj");
    for (const char* line : {"\no component_0\nf ", "\no component_4\nf "}) {
        ASSERT_NE(text.find(line), std::string::npos) << line;
        EXPECT_EQ(text.find(line), text.rfind(line)) << line;
    }

    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    EXPECT_EQ(meshOfObj(vertices + "o component_7\nf 1 2 3 4\no component_-2 \nf 1 2 3\n").component,
              (std::vector<std::int32_t>{7, 7, -2}));
    for (const char* other : {"f 1 2 3\no component_1\nf 1 2 4\n", "o component_1\nf 1 2 3\no thing\nf 1 2 4\n",
                              "o component_x\nf 1 2 3\n", "o component_99999999999\nf 1 2 3\n", "o\nf 1 2 3\n"})
        EXPECT_FALSE(meshOfObj(vertices + other).component) << other;
}

TEST(ObjFile, ReadsFilesOfOtherWriters) {
    const Mesh mesh = meshOfObj(
        "# comment\r\nmtllib a.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\r\n  v\t1 +1 0\r\nv 0 1e0 -0\r\n"
        "vt 0 0\nvn 0 0 1\ns off\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -4//1 -3//1 -2//1\nf 1/1 2/1 3\nl 1 2 3\nf 2 3 4");
    EXPECT_EQ(mesh.position.size(), 4U);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 2}, {1, 2, 3}}));
}

TEST(ObjFile, ErrorsSayWhatIsWrongAndInWhichLine) {
    expectError([] { meshOfObj("v 0 0\n"); }, {"t.obj", "line 1", "three numbers"});
    expectError([] { meshOfObj("v 0 0 0x\n"); }, {"line 1"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1\n"); }, {"line 2", "2 corners"});
    expectError([] { meshOfObj("v 0 0 0\nf 0 1 1\n"); }, {"line 2", "vertex indices"});
    expectError([] { meshOfObj("v 0 0 0\nf -2 1 1\n"); }, {"line 2", "vertex indices"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1 99999999999999999999\n"); }, {"line 2"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1 7\n"); }, {"t.obj", "vertex 7", "only 1 vertices"});
    expectError([] { meshOfObj("v 0 0 inf\n"); }, {"t.obj", "vertex 0", "finite"});
    expectError([] { meshOfObj(std::string_view("v 0 0 0\0", 8)); }, {"t.obj", "zero bytes"});
}

TEST(ObjFile, FileInfoCountsPointsAndEdgesAndSpheresAreRejected) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 2 3\nl 1 2\n";
    const FileInfo info = inspectFile(folder / "a.obj");
    EXPECT_EQ(info.points, 2U);
    EXPECT_EQ(info.edges, 1U);
    EXPECT_EQ(info.upper, Vec3f(1, 2, 3));
    expectError([&] { writeSpheres(folder / "s.obj", {}); }, {"s.obj", "radius"});
}

}  // namespace betamesh
