#include "io/ply.h"

#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "support/file_checks.h"
#include "support/file_samples.h"
#include "support/temporary_folder.h"

namespace betamesh {

namespace {

ParticleInput named(const std::string& velocity, const std::string& id) {
    ParticleInput input;
    input.velocity = velocity;
    input.id = id;
    return input;
}

Particles particlesOfPly(std::string_view text, const ParticleInput& input = {}) {
    ReadOptions options;
    options.faces = false;
    if (!input.id.empty()) options.id = input.id;
    return particlesFrom(parsePly({bytesOf(text), "t.ply"}, options), input, "t.ply");
}

Mesh meshOfPly(std::string_view text) {
    ReadOptions options;
    options.id.clear();
    return meshFrom(parsePly({bytesOf(text), "t.ply"}, options), "t.ply");
}

const std::string kTriangle =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

}  // namespace

TEST(PlyFile, ParticlesSurviveARoundTrip) { expectParticlesComeBack("a.ply"); }

TEST(PlyFile, MeshesSurviveARoundTripAndAlwaysHaveVelocity) {
    const TemporaryFolder folder;
    for (const std::size_t n : {1U, 3U, 1000U})
        for (int mask = 0; mask < 4; ++mask) {
            Mesh mesh = sampleMesh(n, mask & 1, mask & 2);
            writeMesh(folder / "a.ply", mesh);
            if (mesh.velocity.empty()) mesh.velocity.resize(n, Vec3(0, 0, 0));
            expectSame(readMesh(folder / "a.ply"), mesh);
        }
}

TEST(PlyFile, NormalsHaveTheNamesThatOtherProgramsRead) {
    const TemporaryFolder folder;
    Mesh mesh = sampleMesh(5, true, true);
    mesh.attributes = {{"N", 3, std::vector<float>(15, 0.5F), {}}};
    writeMesh(folder / "a.ply", mesh);
    EXPECT_NE(contentsOf(folder / "a.ply").find("property float nx\nproperty float ny\nproperty float nz\n"),
              std::string::npos);
    expectSame(readMesh(folder / "a.ply"), mesh);
    mesh.attributes.push_back({"nx", 1, std::vector<float>(5, 1.0F), {}});
    EXPECT_THROW(writeMesh(folder / "b.ply", mesh), Error);
}

TEST(PlyFile, ComponentsSurviveARoundTrip) {
    const TemporaryFolder folder;
    for (const std::size_t n : {1U, 3U, 1000U}) {
        const Mesh mesh = withComponents(sampleMesh(n, true, true));
        writeMesh(folder / "a.ply", mesh);
        EXPECT_NE(contentsOf(folder / "a.ply").find("property int component\n"), std::string::npos);
        expectSame(readMesh(folder / "a.ply"), mesh);
        EXPECT_EQ(readParticles(folder / "a.ply").size(), n);
        EXPECT_EQ(inspectFile(folder / "a.ply").triangles, mesh.triangles.size());
    }
    writeMesh(folder / "b.ply", withComponents({}));
    EXPECT_TRUE(readMesh(folder / "b.ply").component);
    Mesh mesh = withComponents(sampleMesh(10, true, false));
    mesh.component->pop_back();
    expectError([&] { writeMesh(folder / "c.ply", mesh); }, {"c.ply", "component has 7 rows", "8 triangles"});
}

TEST(PlyFile, ReadsComponentsOfPolygonsAndIgnoresOtherProperties) {
    const auto text = [](const std::string& property, const std::string& faces) {
        return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 2\nproperty " +
               property + "\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 1 1 0 0 1 0\n" + faces;
    };
    const std::string faces = "-5 4 0 1 2 3 7 3 0 1 2\n";
    const Mesh mesh = meshOfPly(text("int component", faces));
    EXPECT_EQ(mesh.triangles.size(), 3U);
    EXPECT_EQ(mesh.component, (std::vector<std::int32_t>{-5, -5, 7}));
    EXPECT_FALSE(meshOfPly(text("float component", faces)).component);
    EXPECT_FALSE(meshOfPly(text("uint component", "4294967295 3 0 1 2 0 3 0 1 2\n")).component);
    EXPECT_FALSE(meshOfPly(text("list uchar int component", "2 1 1 3 0 1 2 0 3 0 1 2\n")).component);
    EXPECT_FALSE(meshOfPly(text("int part", faces)).component);
}

TEST(PlyFile, EmptyFilesDeclareTheUsualProperties) {
    const TemporaryFolder folder;
    Mesh none;
    none.attributes.push_back({"density", 1, {}, {}});
    writeMesh(folder / "a.ply", none);
    const std::string text = contentsOf(folder / "a.ply");
    for (const char* line : {"element vertex 0\n", "property float vx\n", "property float density\n",
                             "element face 0\nproperty list uchar int vertex_indices\n"})
        EXPECT_NE(text.find(line), std::string::npos) << line;
    EXPECT_TRUE(readMesh(folder / "a.ply").position.empty());
    EXPECT_EQ(inspectFile(folder / "a.ply").kind, FileKind::mesh);

    writeParticles(folder / "b.ply", {});
    EXPECT_EQ(readParticles(folder / "b.ply").size(), 0U);
    const FileInfo info = inspectFile(folder / "b.ply");
    EXPECT_EQ(info.kind, FileKind::particles);
    ASSERT_EQ(info.attributes.size(), 7U);
    EXPECT_EQ(info.attributes[6].name, "id");
}

TEST(PlyFile, SpheresHaveARadiusVelocityAndId) {
    const TemporaryFolder folder;
    Spheres spheres;
    spheres.position = {{1, 2, 3}, {4, 5, 6}};
    spheres.radius = {0.5F, 0.25F};
    spheres.id = {9, 8};
    writeSpheres(folder / "s.ply", spheres);
    const Particles read = readParticles(folder / "s.ply");
    EXPECT_EQ(read.id, spheres.id);
    EXPECT_EQ(read.velocity, std::vector<Vec3f>(2, Vec3f(0, 0, 0)));
    ASSERT_EQ(read.attributes.size(), 1U);
    EXPECT_EQ(read.attributes[0].name, "radius");
    EXPECT_EQ(read.attributes[0].real, spheres.radius);
}

TEST(PlyFile, BytesAreReproducible) {
    const Mesh mesh = sampleMesh(500, true, true);
    const auto encode = [&](ByteWriter& out) { encodePly(out, mesh, "a.ply"); };
    EXPECT_EQ(bytesOf(encode), bytesOf(encode));
}

TEST(PlyFile, ReadsAscii) {
    const Particles p = particlesOfPly(
        "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info x\r\nelement vertex 2\r\nproperty uchar red\r\n"
        "property double z\r\nproperty float y\r\nproperty short x\r\nproperty list uchar float extra\r\n"
        "property int id\r\nend_header\r\n"
        "255 +1.5 2.5e0 -3  2 9 9  7\r\n0\t.5 -0 4 0\n8\n");
    EXPECT_EQ(p.position, (std::vector<Vec3f>{{-3, 2.5F, 1.5F}, {4, -0.0F, 0.5F}}));
    EXPECT_EQ(p.id, (std::vector<std::uint64_t>{7, 8}));
    ASSERT_EQ(p.attributes.size(), 1U);
    EXPECT_EQ(p.attributes[0].integer, (std::vector<std::int32_t>{255, 0}));
}

TEST(PlyFile, NumbersOfTextThatAreTooLargeAreNamedWithTheirLine) {
    const auto vertices = [](const std::string& type, const std::string& rows) {
        return "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
               "z\nproperty " +
               type + "\nend_header\n" + rows;
    };
    for (const char* type : {"float heat", "double heat"}) {
        const FileContents contents = parsePly({bytesOf(vertices(type, "1 2 3 inf\n4 5 6 -1e39\n")), "t.ply"});
        ASSERT_EQ(contents.lost_numbers.size(), 1U) << type;
        EXPECT_EQ(contents.lost_numbers[0].attribute, "heat");
        EXPECT_EQ(contents.lost_numbers[0].particle, 1U);
        EXPECT_EQ(describe(contents.lost_numbers[0]), "-1e+39 (line 10), which is too large for single precision");
    }
    const auto refused = [&](const std::string& type, const std::string& rows, const std::vector<std::string>& words) {
        expectError([&] { particlesOfPly(vertices(type, rows)); }, words);
    };
    refused("int id", "1 2 3 4\n4 1e39 6 5\n", {"particle 1: position", "'y' is 1e+39 (line 10)"});
    EXPECT_EQ(particlesOfPly(vertices("uint64 id", "1 2 3 18446744073709551615 4 5 6 7\n")).id,
              (std::vector<std::uint64_t>{std::uint64_t(-1), 7}));
    refused("int64 id", "1 2 3\n4 4 5 6 9223372036854775808", {"t.ply: line 10: ", "'9223372036854775808'"});
}

TEST(PlyFile, ReadsBothByteOrdersAndEveryType) {
    const std::string header =
        "element vertex 1\nproperty int8 a\nproperty uint8 b\nproperty int16 c\nproperty uint16 d\n"
        "property int32 e\nproperty uint32 f\nproperty float32 x\nproperty float64 y\nproperty float z\nend_header\n";
    const Particles big = particlesOfPly("ply\nformat binary_big_endian 1.0\n" + header +
                                         raw("\xff\xff\xff\xfe\xff\xfe\xff\xff\xff\xfd\xff\xff\xff\xfc"
                                             "\x3f\x80\x00\x00\x40\x00\x00\x00\x00\x00\x00\x00\x40\x40\x00\x00"));
    const Particles little = particlesOfPly("ply\nformat binary_little_endian 1.0\n" + header +
                                            raw("\xff\xff\xfe\xff\xfe\xff\xfd\xff\xff\xff\xfc\xff\xff\xff"
                                                "\x00\x00\x80\x3f\x00\x00\x00\x00\x00\x00\x00\x40\x00\x00\x40\x40"));
    expectSame(big, little);
    EXPECT_EQ(big.position[0], Vec3f(1, 2, 3));
    ASSERT_EQ(big.attributes.size(), 6U);
    EXPECT_EQ(big.attributes[0].integer[0], -1);
    EXPECT_EQ(big.attributes[1].integer[0], 255);
    EXPECT_EQ(big.attributes[2].integer[0], -2);
    EXPECT_EQ(big.attributes[3].integer[0], 65534);
    EXPECT_EQ(big.attributes[4].integer[0], -3);
    EXPECT_EQ(big.attributes[5].real[0], 4294967292.0F);  // does not fit in a signed 32-bit integer
}

TEST(PlyFile, FindsVelocityByItsUsualNamesAndByAGivenName) {
    const auto text = [](const std::string& stem) {
        return "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
               "property float " +
               stem + "x\nproperty float " + stem + "y\nproperty float " + stem + "z\nend_header\n0 0 0 1 2 3\n";
    };
    for (const char* stem : {"v", "velocity_", "vel_", "v_"})
        EXPECT_EQ(particlesOfPly(text(stem)).velocity, (std::vector<Vec3f>{{1, 2, 3}})) << stem;
    EXPECT_TRUE(particlesOfPly(text("flow_")).velocity.empty());
    EXPECT_EQ(particlesOfPly(text("flow_"), named("flow", "")).velocity.size(), 1U);
    EXPECT_EQ(particlesOfPly(text("q")).attributes.size(), 3U);
    EXPECT_EQ(particlesOfPly(text("n")).attributes.size(), 1U);
    expectError([&] { particlesOfPly(text("v"), named("speed", "")); }, {"t.ply", "'speed'", "'vx'"});
    expectError([&] { particlesOfPly(text("v"), named("", "number")); }, {"t.ply", "'number'"});
}

TEST(PlyFile, PolygonsBecomeFansAndOtherElementsAreSkipped) {
    const Mesh mesh = meshOfPly(
        "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar int numbers\nelement vertex 5\n"
        "property float x\nproperty float y\nproperty float z\nelement face 2\nproperty uchar red\n"
        "property list uchar uint vertex_index\nproperty list int float uv\nelement edge 1\nproperty int vertex1\n"
        "property int vertex2\nend_header\n"
        "2 5 6\n0 0 0 1 0 0 1 1 0 0 1 0 0 0 1\n9 4 0 1 2 3 2 .1 .2\n9 3 0 1 4 0\n0 1\n");
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}}));
}

TEST(PlyFile, FacesAndEdgesMayComeBeforeVertices) {
    const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    const std::string header = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n";
    const Mesh mesh = meshOfPly(header + vertices + "3 0 2 1\n0 0 0 1 0 0 1 1 0\n");
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 1}}));
    EXPECT_EQ(mesh.position[2], Vec3(1, 1, 0));
    expectError([&] { meshOfPly(header + vertices + "3 0 3 1\n0 0 0 1 0 0 1 1 0\n"); }, {"face 0", "corner 3"});
}

TEST(PlyFile, FileInfoCountsPointsAndTriangles) {
    const TemporaryFolder folder;
    const Mesh mesh = sampleMesh(10, true, false);
    writeMesh(folder / "a.ply", mesh);
    const FileInfo info = inspectFile(folder / "a.ply");
    EXPECT_EQ(info.kind, FileKind::mesh);
    EXPECT_EQ(info.format, "ply binary_little_endian");
    EXPECT_EQ(info.points, 10U);
    EXPECT_EQ(info.triangles, 8U);
    EXPECT_EQ(info.lower.x, -7.7F);
    EXPECT_EQ(info.bytes, std::filesystem::file_size(folder / "a.ply"));
}

TEST(PlyFile, ErrorsSayWhatIsWrongAndWhere) {
    expectError([] { meshOfPly("plx\n"); }, {"t.ply", "'ply'"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\n"); }, {"t.ply", "end_header"});
    expectError([] { meshOfPly("ply\nformat text 1.0\nend_header\n"); }, {"line 2", "'text'", "ascii"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\nelement vertex -1\n"); }, {"line 3", "'-1'"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n"); }, {"line 4", "'quad'"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\nproperty float x\n"); },
                {"line 3", "not preceded by an element"});
    const std::string vertex = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n";
    for (const char* again : {"float x", "int x", "list uchar float x"})
        expectError([&] { meshOfPly(vertex + "property " + again + "\n"); }, {"line 5", "'x'", "twice"});
    expectError([&] { meshOfPly(vertex + "element vertex 1\n"); }, {"line 5", "'vertex'", "twice"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\nend_header\n"); }, {"'vertex'"});
    expectError([] { meshOfPly("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n"); }, {"'y'"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 0 1 1 0 3 0 1 3\n"); }, {"t.ply", "face 0", "corner 3"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 0 1 1 0 3 0 1 -1\n"); }, {"corner -1"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 nan 1 1 0 3 0 1 2\n"); }, {"t.ply", "vertex 1", "finite"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 x 1 1 0 3 0 1 2\n"); }, {"'x'", "not a number"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 0 1 1 0 3 0 1\n"); }, {"the file ends"});
    expectError([] { meshOfPly(kTriangle + "0 0 0 1 0 0 1 1 0 300 0 1 2\n"); }, {"'300'", "uchar"});
}

TEST(PlyFile, AbsurdCountsAreRejectedBeforeMemoryIsAllocated) {
    for (const char* format : {"ascii", "binary_little_endian"})
        for (const char* count : {"4000000000", "18446744073709551615"}) {
            const std::string text = "ply\nformat " + std::string(format) + " 1.0\nelement vertex " + count +
                                     "\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
            expectError([&] { particlesOfPly(text); }, {"t.ply", count, "truncated"});
        }
}

TEST(PlyFile, AttributesThatCannotBeWrittenAreErrors) {
    const TemporaryFolder folder;
    Particles p = sampleParticles(3, true, true, false);
    for (const char* name : {"", "two words", "x", "vx", "id"}) {
        p.attributes = {{name, 1, {1, 2, 3}, {}}};
        expectError([&] { bytesOf([&](ByteWriter& out) { encodePly(out, p, "a.ply"); }); }, {"a.ply", name});
    }
    p.attributes = {{"a", 2, {1, 2, 3}, {}}};
    expectError([&] { writeParticles(folder / "a.ply", p); }, {"a.ply", "'a'"});
    p.attributes.clear();
    p.id[1] = 1ULL << 32;
    expectError([&] { writeParticles(folder / "a.ply", p); }, {"particle 1", "4294967296", ".vdb"});
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PlyFile, IdsKeepTheirNumbers) {
    const TemporaryFolder folder;
    Particles p = sampleParticles(3, true, true, false);
    for (const auto& [ids, type] : {std::pair<std::vector<std::int64_t>, const char*>{{7, 0xfffffff0, 1}, "uint id"},
                                    {{-1, 5, -2147483648}, "int id"}}) {
        p.id.assign(ids.begin(), ids.end());
        writeParticles(folder / "a.ply", p);
        EXPECT_NE(contentsOf(folder / "a.ply").find(std::string("property ") + type), std::string::npos);
        EXPECT_EQ(readParticles(folder / "a.ply").id, p.id);
    }
    p.id = {std::uint64_t(-1), 0xfffffff0U, 1};
    expectError([&] { writeParticles(folder / "b.ply", p); }, {"particle 0", "id -1 is negative"});
    Spheres spheres;
    spheres.position.assign(3, Vec3(0, 0, 0));
    spheres.radius.assign(3, 1.0F);
    spheres.id = p.id;
    std::string warning;
    WriteOptions options;
    const WarningHandler warn = [&](const std::string& text) { warning = text; };
    options.warn = &warn;
    writeSpheres(folder / "s.ply", spheres, options);
    EXPECT_TRUE(readParticles(folder / "s.ply").id.empty());
    EXPECT_NE(warning.find("the ids of the spheres are negative or need more than 32 bits"), std::string::npos);
}

TEST(PlyFile, ErrorsOfUnknownExtensionsListTheKnownOnes) {
    expectError([] { readParticles("a.fbx"); }, {"a.fbx", ".bgeo", ".ply", ".vdb"});
    expectError([] { requireParticleExtension("a.obj"); }, {"a.obj", ".vdb"});
    expectError([] { requireMeshExtension("a.csv"); }, {"a.csv", "not a format for meshes", ".obj"});
    EXPECT_NO_THROW(requireMeshExtension("dir.x/A.0001.PLY"));
    EXPECT_NO_THROW(requireMeshExtension("a.bgeo.gz"));
    expectError([] { readParticles("no/such/file.ply"); }, {"no/such/file.ply", "No such file"});
    expectError([] { readParticles("/tmp/.ply"); }, {"/tmp/.ply"});
}

}  // namespace betamesh
