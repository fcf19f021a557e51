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

TEST(ObjFile, PositionsAndFacesComeBackAsTheyWere) {
    const TemporaryFolder folder;
    for (const std::size_t n : {0U, 1U, 3U, 5000U}) {
        Mesh mesh = sampleMesh(n, true, true);
        writeMesh(folder / "a.obj", mesh);
        mesh.velocity.clear();
        mesh.attributes.clear();
        expectSame(readMesh(folder / "a.obj"), mesh);
    }
}

TEST(ObjFile, ReadsWhatOthersWrite) {
    const Mesh mesh = meshOfObj(
        "# comment\r\nmtllib a.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\r\n  v\t1 +1 0\r\nv 0 1e0 -0\r\n"
        "vt 0 0\nvn 0 0 1\ns off\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -4//1 -3//1 -2//1\nf 1/1 2/1 3\nl 1 2 3\nf 2 3 4");
    EXPECT_EQ(mesh.position.size(), 4U);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 2}, {1, 2, 3}}));
}

TEST(ObjFile, ErrorsNameFileLineAndExpectation) {
    expectError([] { meshOfObj("v 0 0\n"); }, {"t.obj", "line 1", "three numbers"});
    expectError([] { meshOfObj("v 0 0 0x\n"); }, {"line 1"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1\n"); }, {"line 2", "2 corners"});
    expectError([] { meshOfObj("v 0 0 0\nf 0 1 1\n"); }, {"line 2", "from 1"});
    expectError([] { meshOfObj("v 0 0 0\nf -2 1 1\n"); }, {"line 2", "from 1"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1 99999999999999999999\n"); }, {"line 2"});
    expectError([] { meshOfObj("v 0 0 0\nf 1 1 7\n"); }, {"t.obj", "vertex 7", "at most 1"});
    expectError([] { meshOfObj("v 0 0 inf\n"); }, {"t.obj", "vertex 0", "finite"});
    expectError([] { meshOfObj(std::string_view("v 0 0 0\0", 8)); }, {"t.obj", "zero bytes"});
}

TEST(ObjFile, InspectCountsAndSpheresAreRefused) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 2 3\nl 1 2\n";
    const FileInfo info = inspectFile(folder / "a.obj");
    EXPECT_EQ(info.points, 2U);
    EXPECT_EQ(info.edges, 1U);
    EXPECT_EQ(info.upper, Vec3f(1, 2, 3));
    expectError([&] { writeSpheres(folder / "s.obj", {}); }, {"s.obj", "radius"});
}

}  // namespace betamesh
