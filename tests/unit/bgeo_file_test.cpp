#include "io/bgeo.h"

#include "io/file_info.h"
#include "io/gzip.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "support/file_checks.h"
#include "support/file_samples.h"
#include "support/temporary_folder.h"

#include <random>
#include <set>

namespace betamesh {

namespace {

using namespace std::string_literals;

std::string int32(std::uint32_t n) {
    return {static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8), static_cast<char>(n)};
}
std::string int16(std::uint32_t n) { return int32(n).substr(2); }
std::string real(float x) { return int32(std::bit_cast<std::uint32_t>(x)); }
std::string words(const std::string& name) { return int16(static_cast<std::uint32_t>(name.size())) + name; }
std::string point(float x, float y, float z) { return real(x) + real(y) + real(z) + real(1); }

std::string header(std::uint32_t points, std::uint32_t prims, std::uint32_t point_attributes,
                   std::uint32_t vertex_attributes = 0, std::uint32_t prim_attributes = 0) {
    return "BgeoV" + int32(5) + int32(points) + int32(prims) + int32(0) + int32(0) + int32(point_attributes) +
           int32(vertex_attributes) + int32(prim_attributes) + int32(0);
}

FileContents parse(const std::string& bytes) { return parseBgeo({bytesOf(bytes), "t.bgeo"}); }

const std::filesystem::path kData = std::filesystem::path(BETAMESH_SHARED) / "data";

}  // namespace

TEST(BgeoFile, ParticlesSurviveARoundTrip) {
    expectParticlesComeBack("a.bgeo");
    expectParticlesComeBack("a.bgeo.gz");
}

TEST(BgeoFile, MeshesSurviveARoundTripWithShortAndLongIndices) {
    const TemporaryFolder folder;
    for (const std::size_t n : {1U, 3U, 65535U, 65536U, 70000U})
        for (int mask = 0; mask < 4; ++mask) {
            SCOPED_TRACE(n);
            Mesh mesh = sampleMesh(n, mask & 1, mask & 2);
            writeMesh(folder / "a.bgeo", mesh);
            if (mesh.velocity.empty()) mesh.velocity.resize(n, Vec3(0, 0, 0));
            expectSame(readMesh(folder / "a.bgeo"), mesh);
        }
}

TEST(BgeoFile, ComponentsSurviveARoundTripWithShortAndLongIndices) {
    const TemporaryFolder folder;
    for (const char* name : {"a.bgeo", "a.bgeo.gz"})
        for (const std::size_t n : {1U, 3U, 65535U, 70000U}) {
            SCOPED_TRACE(n);
            const Mesh mesh = withComponents(sampleMesh(n, true, true));
            writeMesh(folder / name, mesh);
            expectSame(readMesh(folder / name), mesh);
        }
    writeMesh(folder / "b.bgeo", withComponents({}));
    EXPECT_TRUE(readMesh(folder / "b.bgeo").component);
}

TEST(BgeoFile, EmptyFilesDeclareTheUsualAttributes) {
    const TemporaryFolder folder;
    writeMesh(folder / "m.bgeo", {});
    writeParticles(folder / "p.bgeo", {});
    EXPECT_EQ(inspectFile(folder / "m.bgeo").attributes.at(1).name, "v");
    const FileInfo info = inspectFile(folder / "p.bgeo");
    ASSERT_EQ(info.attributes.size(), 3U);
    EXPECT_EQ(info.attributes[1].type, "vector");
    EXPECT_EQ(info.attributes[2].type, "int");
    EXPECT_EQ(readParticles(folder / "p.bgeo").size(), 0U);
    EXPECT_EQ(readMesh(folder / "m.bgeo").position.size(), 0U);
}

TEST(BgeoFile, SpheresStoreTheirRadiusAsPscale) {
    const TemporaryFolder folder;
    Spheres spheres;
    spheres.position = {{1, 2, 3}};
    spheres.velocity = {{4, 5, 6}};
    spheres.radius = {0.5F};
    writeSpheres(folder / "s.bgeo", spheres);
    const Particles read = readParticles(folder / "s.bgeo");
    EXPECT_EQ(read.velocity[0], Vec3f(4, 5, 6));
    ASSERT_EQ(read.attributes.size(), 1U);
    EXPECT_EQ(read.attributes[0].name, "pscale");
    EXPECT_EQ(read.attributes[0].real, spheres.radius);
}

TEST(BgeoFile, WritesExactlyTheseBytes) {
    Mesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    const std::string none = real(0) + real(0) + real(0);
    const std::string expected = header(3, 1, 1) + words("v") + int16(3) + int32(5) + none + point(0, 0, 0) + none +
                                 point(1, 0, 0) + none + point(0, 1, 0) + none + int32(0xffffffff) + int16(1) +
                                 int32(1) + int32(3) + "<" + int16(0) + int16(2) + int16(1) + "\0\xff"s;
    EXPECT_EQ(bytesOf([&](ByteWriter& out) { encodeBgeo(out, mesh, "a.bgeo"); }), bytesOf(expected));
}

TEST(BgeoFile, ReadsComponentsAmongOtherPrimitiveAttributes) {
    const std::string quad = int32(4) + "<" + int16(0) + int16(1) + int16(2) + int16(3);
    const auto bytes = [&](const std::string& name, std::uint32_t size, std::uint32_t type) {
        return header(4, 2, 0, 0, 2) + point(0, 0, 0) + point(1, 0, 0) + point(1, 1, 0) + point(0, 1, 0) + words("Cd") +
               int16(1) + int32(0) + real(0) + words(name) + int16(size) + int32(type) + real(0) +
               (size == 2 ? real(0) : "") + int32(1) + quad + real(3) + int32(11) + (size == 2 ? real(0) : "") +
               int32(1) + quad + real(4) + int32(0xffffffff) + (size == 2 ? real(0) : "") + "\0\xff"s;
    };
    EXPECT_EQ(parse(bytes("component", 1, 1)).component, (std::vector<std::int32_t>{11, 11, -1, -1}));
    EXPECT_FALSE(parse(bytes("component", 1, 0)).component);
    EXPECT_FALSE(parse(bytes("component", 2, 1)).component);
    EXPECT_FALSE(parse(bytes("piece", 1, 1)).component);
}

TEST(BgeoFile, ReadsEveryAttributeTypeAndSkipsStrings) {
    const std::string bytes = header(2, 0, 5) + words("name") + int16(1) + int32(4) + int32(2) + words("left") +
                              words("") + words("vel") + int16(3) + int32(0) + real(0) + real(0) + real(0) +
                              words("id") + int16(1) + int32(1) + int32(0) + words("uv") + int16(2) + int32(0) +
                              real(0) + real(0) + words("k") + int16(2) + int32(1) + int32(0) + int32(0) +
                              point(1, 2, 3) + int32(1) + real(7) + real(8) + real(9) + int32(0xffffffff) + real(.5F) +
                              real(.25F) + int32(4) + int32(5) +  //
                              point(4, 5, 6) + int32(0) + real(1) + real(2) + real(3) + int32(6) + real(0) + real(1) +
                              int32(0xfffffffe) + int32(7);
    const Particles p = particlesFrom(parse(bytes), {}, "t.bgeo");
    EXPECT_EQ(p.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(p.velocity, (std::vector<Vec3f>{{7, 8, 9}, {1, 2, 3}}));
    EXPECT_EQ(p.id, (std::vector<std::uint64_t>{0xffffffff, 6}));
    ASSERT_EQ(p.attributes.size(), 2U);
    EXPECT_EQ(p.attributes[0].real, (std::vector<float>{.5F, .25F, 0, 1}));
    EXPECT_EQ(p.attributes[1].integer, (std::vector<std::int32_t>{4, 5, -2, 7}));
}

TEST(BgeoFile, ReadsRunsSinglePolygonsOpenPolygonsAndParticleSystems) {
    // One vertex attribute (3 floats) and one primitive attribute (1 int) are stored between the indices.
    const std::string uv = real(0) + real(0) + real(0);
    const auto corner = [&](std::uint32_t i) { return int16(i) + uv; };
    const std::string quad = int32(4) + "<" + corner(0) + corner(1) + corner(2) + corner(3) + int32(42);
    const std::string line = int32(3) + ":" + corner(0) + corner(1) + corner(2) + int32(42);
    const std::string system = int32(2) + corner(3) + corner(4) + int32(42);
    const std::string bytes = header(5, 5, 0, 1, 1) + point(0, 0, 0) + point(1, 0, 0) + point(1, 1, 0) +
                              point(0, 1, 0) + point(0, 0, 1) + words("uv") + int16(3) + int32(0) + uv +
                              words("piece") + int16(1) + int32(1) + int32(0) + int32(1) + quad + int32(0xffffffff) +
                              int16(3) + int32(1) + quad + line + quad + int32(0x8000) + system + "\0\xff"s;
    const FileContents contents = parse(bytes);
    const std::vector<Triangle> fan{{0, 3, 2}, {0, 2, 1}};  // reversed, because Houdini's polygons are clockwise
    EXPECT_EQ(contents.triangles, (std::vector<Triangle>{fan[0], fan[1], fan[0], fan[1], fan[0], fan[1]}));
    EXPECT_EQ(contents.edges, (std::vector<Edge>{{0, 1}, {1, 2}}));
    EXPECT_TRUE(contents.declares_faces);
}

TEST(BgeoFile, ParticlesAreReadFromFilesWithUnknownPrimitives) {
    const TemporaryFolder folder;
    const std::string bytes = header(1, 1, 0) + point(1, 2, 3) + int32(0x10) + "whatever";
    std::ofstream(folder / "a.bgeo", std::ios::binary) << bytes;
    EXPECT_EQ(readParticles(folder / "a.bgeo").size(), 1U);
    EXPECT_EQ(inspectFile(folder / "a.bgeo").kind, FileKind::particles);
    expectError([&] { readMesh(folder / "a.bgeo"); }, {"a.bgeo", "type 16", "polygons"});
}

TEST(BgeoFile, ErrorsSayWhatIsWrongAndWhere) {
    expectError([] { parse("nonsense"); }, {"t.bgeo", "'BgeoV'"});
    expectError([] { parse(""); }, {"t.bgeo", "'BgeoV'"});
    expectError([] { parse("BgeoV" + int32(4)); }, {"version is 4", "only version 5"});
    expectError([] { parse(header(0xffffffff, 0, 0)); }, {"number of points is -1"});
    expectError([] { parse(header(2, 0, 0) + point(1, 2, 3)); }, {"byte 41", "points", "truncated"});
    expectError([] { parse(header(0x7fffffff, 0, 0) + point(1, 2, 3)); }, {"2147483647", "truncated"});
    expectError([] { parse(header(1, 0, 1) + words("m") + int16(1) + int32(3)); }, {"'m'", "type 3"});
    expectError([] { parse(header(1, 0, 1) + int16(60000) + "m"); }, {"attribute name", "60000"});
    expectError([] { parse(header(1, 0, 1) + words("m") + int16(1) + int32(4) + int32(0x7fffffff)); }, {"string"});
    expectError([] { parse(header(1, 1, 0) + point(0, 0, 0) + int32(1) + int32(1) + "<" + int16(1)); },
                {"corner 1", "only 1 points"});
    expectError([] { parse(header(1, 1, 0) + point(0, 0, 0) + int32(1) + int32(1) + "x" + int16(0)); }, {"closed"});
    expectError([] { parse(header(1, 1, 0) + point(0, 0, 0) + int32(0xffffffff) + int16(2) + int32(1)); }, {"a run"});
    expectError([] { parse(header(1, 1, 0) + point(0, 0, 0) + int32(1) + int32(0x7fffffff) + "<"); }, {"polygon"});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    expectError([&] { particlesFrom(parse(header(1, 0, 0) + point(nan, 0, 0)), {}, "t.bgeo"); },
                {"t.bgeo", "particle 0", "position"});
}

TEST(BgeoFile, NewerFormatsAreRejectedWithAdvice) {
    for (const std::string& start : {"\x7fNSJb\x01"s, "[\n\t\"fileversion\""s, "scb\0rest"s})
        expectError([&] { parse(start + std::string(100, 'x')); },
                    {"t.bgeo", "Houdini 12", ".vdb", ".ply", "bhclassic"});
    const TemporaryFolder folder;
    std::ofstream(folder / "a.bgeo.sc") << "????";
    expectError([&] { readParticles(folder / "a.bgeo.sc"); }, {"a.bgeo.sc", "blosc"});
    expectError([&] { writeMesh(folder / "b.bgeo.sc", {}); }, {"b.bgeo.sc", ".bgeo.gz"});
}

TEST(BgeoFile, GzipIsRecognisedByItsMagicNumberAndDamageIsReported) {
    const Bytes plain = bytesOf([](ByteWriter& out) { encodeBgeo(out, sampleMesh(300, true, true), "a"); });
    const Bytes packed = gzip(plain);
    EXPECT_EQ(packed, gzip(plain));
    EXPECT_EQ(gunzip(packed, "a"), plain);
    EXPECT_EQ(parseBgeo({packed, "t.bgeo"}).format, "bgeo V5, gzip");
    Bytes two = packed;
    two.insert(two.end(), packed.begin(), packed.end());
    EXPECT_EQ(gunzip(two, "a").size(), 2 * plain.size());

    const std::span<const std::byte> span(packed);
    expectError([&] { parseBgeo({span.first(packed.size() / 2), "t.bgeo"}); }, {"t.bgeo", "gzip", "truncated"});
    Bytes damaged = packed;
    damaged[packed.size() - 6] ^= std::byte{1};  // in the checksum
    expectError([&] { parseBgeo({damaged, "t.bgeo"}); }, {"t.bgeo", "gzip", "damaged"});
    expectError([&] { parseBgeo({gzip(packed), "t.bgeo"}); }, {"t.bgeo", "twice"});
}

TEST(BgeoFile, GzipBytesDoNotDependOnHowTheInputIsDivided) {
    Bytes plain(std::size_t{37} << 20);  // more than is compressed at once
    for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = static_cast<std::byte>(i * i / 977 % 251);
    const Bytes packed = gzip(plain);
    EXPECT_LT(packed.size(), plain.size());
    EXPECT_TRUE(gunzip(packed, "a") == plain);
    Bytes again;
    GzipWriter writer([&](std::span<const std::byte> piece) { again.insert(again.end(), piece.begin(), piece.end()); });
    for (std::span<const std::byte> left(plain); !left.empty();) {
        const std::size_t count = std::min(left.size(), left.size() % 3000017 + 1);
        writer.write(left.first(count));
        left = left.subspan(count);
    }
    writer.finish();
    EXPECT_TRUE(again == packed);
    EXPECT_EQ(gunzip(gzip({}), "a").size(), 0U);
}

TEST(BgeoFile, AGzipMemberMayStartAtTheEndOfAReadBuffer) {
    constexpr std::size_t kReadBuffer = std::size_t{1} << 18;
    std::minstd_rand random;
    Bytes noise(kReadBuffer);  // incompressible
    for (std::byte& b : noise) b = static_cast<std::byte>(random() >> 8);
    const std::size_t overhead = gzip(noise).size() - noise.size();
    std::set<std::size_t> ends;
    for (std::size_t size = kReadBuffer - overhead - 2; size <= kReadBuffer - overhead + 2; ++size) {
        Bytes two = gzip(std::span(noise).first(size));
        ends.insert(two.size());
        const Bytes second = gzip(std::span(noise).first(5));
        two.insert(two.end(), second.begin(), second.end());
        EXPECT_EQ(gunzip(two, "a").size(), size + 5);
    }
    EXPECT_TRUE(ends.contains(kReadBuffer - 1) && ends.contains(kReadBuffer));
}

TEST(BgeoFile, GzipBombsAreRejected) {
    const Bytes bomb = gzip(Bytes(std::size_t{300} << 20));
    expectError([&] { gunzip(bomb, "t.bgeo"); }, {"t.bgeo", "decompress"});
}

TEST(BgeoFile, ReadsRealFramesOfSeveralWriters) {
    if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no real frames in " << kData;
    struct Expected {
        const char* file;
        std::size_t particles;
        bool has_velocity;
        std::size_t attributes;
    };
    for (const Expected& e : {Expected{"sph_dam3d/sph_dam3d.0024.bgeo", 104017, true, 0},
                              Expected{"sph_dam2d/sph_dam2d.0020.bgeo", 3481, true, 0},
                              Expected{"flip_rotcube/flip_rotcube.0010.bgeo", 175616, true, 0},
                              Expected{"splashsurf/hilbert_46843_particles.bgeo", 46843, false, 0},
                              Expected{"splashsurf/dam_break_frame_9_6859_particles.bgeo", 6859, true, 1},
                              Expected{"splashsurf/octocat_32614_particles.bgeo", 32614, false, 0}}) {
        SCOPED_TRACE(e.file);
        const Particles p = readParticles(kData / e.file);
        EXPECT_EQ(p.size(), e.particles);
        EXPECT_EQ(p.velocity.size(), e.has_velocity ? e.particles : 0);
        EXPECT_EQ(p.id.size(), e.has_velocity ? e.particles : 0);
        EXPECT_EQ(p.attributes.size(), e.attributes);
        EXPECT_EQ(inspectFile(kData / e.file).format, "bgeo V5, gzip");
    }
    const Particles dam = readParticles(kData / "sph_dam3d/sph_dam3d.0024.bgeo");
    EXPECT_EQ(dam.id.front(), 0U);
    EXPECT_EQ(dam.id.back(), 104016U);
    EXPECT_EQ(dam.velocity.front(), Vec3f(0.009765625F, 0.0078125F, -0.0078125F));
}

}  // namespace betamesh
