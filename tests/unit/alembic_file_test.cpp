// Alembic files: what is written comes back; archives of other structure, built here; damage.

#include "io/alembic.h"
#include "io/file_info.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "support/alembic_archive.h"
#include "support/file_checks.h"

#include <algorithm>
#include <fstream>

namespace betamesh {
namespace {

FileContents parsed(const Bytes& bytes, const ReadOptions& options = {}) { return parseAbc(bytes, "a.abc", options); }

TEST(AlembicFile, ParticlesComeBackBitForBit) {
    for (const std::size_t n : {0U, 1U, 2U, 1000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            Particles particles = sampleParticles(n, mask & 1, mask & 2, mask & 4);
            if (!particles.id.empty()) particles.id[0] = (std::uint64_t{1} << 60) + 1;
            const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, particles, "a.abc"); });
            if (n == 0) particles.attributes.clear();
            expectSame(particlesFrom(parsed(bytes), {}, "a.abc"), particles);
        }
}

TEST(AlembicFile, MeshesComeBackBitForBit) {
    ReadOptions options;
    options.id.clear();
    for (const std::size_t n : {3U, 100U})
        for (int mask = 0; mask < 4; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " vertices, mask " + std::to_string(mask));
            Mesh mesh = sampleMesh(n, true, mask & 1);
            if (mask & 2) mesh = withComponents(mesh);
            const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, mesh, "a.abc"); });
            const Mesh expected = withNormals(mesh);
            const Mesh read = meshFrom(parsed(bytes, options), "a.abc");
            expectSame(read, expected);
            EXPECT_EQ(bytesOf([&](ByteWriter& out) { encodeAbc(out, read, "a.abc"); }), bytes);
        }
}

TEST(AlembicFile, AnEmptyMeshDeclaresWhatItsNeighboursHave) {
    Mesh mesh;
    mesh.component.emplace();
    mesh.attributes.push_back({"Cd", 3, {}, {}});
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, mesh, "a.abc"); });
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (const char* name : {"P", ".faceIndices", ".faceCounts", ".velocities", "N", "Cd", "component"})
        EXPECT_NE(text.find(static_cast<char>(std::string_view(name).size()) + std::string(name)), std::string::npos)
            << name;
    const FileContents contents = parsed(bytes);
    EXPECT_EQ(contents.kind(), FileKind::mesh);
    EXPECT_TRUE(contents.position.empty());
    EXPECT_TRUE(contents.triangles.empty());
}

TEST(AlembicFile, SmallIntegersKeepTheirType) {
    Particles particles = sampleParticles(5, true, true, false);
    particles.attributes = {{"a", 1, {}, {1, 2, 3, 4, 255}, IntegerType::uint8},
                            {"b", 2, {}, {-1, 2, 3, 4, 5, 6, 7, 8, 9, -32768}, IntegerType::int16},
                            {"c", 1, {}, {1, 2, 3, 4, 256}, IntegerType::uint8}};
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, particles, "a.abc"); });
    const FileContents contents = parsed(bytes);
    expectSame(contents.attributes.empty()
                   ? std::vector<Attribute>{}
                   : std::vector<Attribute>(contents.attributes.end() - 3, contents.attributes.end()),
               particles.attributes);
    const auto typeOf = [&](const std::string& name) {
        for (const AttributeInfo& info : contents.declared)
            if (info.name == name) return info.type;
        return std::string();
    };
    EXPECT_EQ(typeOf("a"), "uint8_t");
    EXPECT_EQ(typeOf("b"), "int16_t");
    EXPECT_EQ(typeOf("c"), "int32_t");  // 256 does not fit
}

TEST(AlembicFile, TimeIsThatOfTheFrame) {
    const Mesh mesh = sampleMesh(3, true, false);
    WriteOptions options;
    options.frame = -36;
    options.frames_per_second = 48;
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, mesh, "a.abc", options); });
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::string expected(16, '\0');
    const double step = 1.0 / 48, time = -36 * step;
    std::memcpy(expected.data(), &step, 8);
    std::memcpy(expected.data() + 8, &time, 8);
    expected.insert(8, raw("\1\0\0\0"));
    EXPECT_NE(text.find(expected), std::string::npos);
}

TEST(AlembicFile, DifferentArraysHaveDifferentDigests) {
    Mesh mesh = sampleMesh(4, true, false);
    const auto digestOfPositions = [&] {
        const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeAbc(out, mesh, "a.abc"); });
        const float x = static_cast<float>(mesh.position[0].x);
        Bytes number(4);
        std::memcpy(number.data(), &x, 4);
        const auto at = std::search(bytes.begin() + 100, bytes.end(), number.begin(), number.end());
        EXPECT_NE(at, bytes.end());
        return Bytes(at - 16, at);
    };
    const Bytes first = digestOfPositions();
    EXPECT_EQ(digestOfPositions(), first);
    mesh.position[3].z += 1;
    EXPECT_NE(digestOfPositions(), first);
}

TEST(AlembicFile, NamesThatAlembicDoesNotAllowAreErrors) {
    Particles particles = sampleParticles(1, true, true, false);
    particles.attributes.push_back({"a/b", 1, {1}, {}});
    expectError([&] { bytesOf([&](ByteWriter& out) { encodeAbc(out, particles, "a.abc"); }); },
                {"a.abc", "'a/b'", "Rename"});
}

// Archives that the writer does not make.

void expectRows(const std::vector<Vec3>& rows, const std::vector<Vec3>& expected) {
    ASSERT_EQ(rows.size(), expected.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(rows[i][k], expected[i][k], 1e-6) << i;
}

TEST(AlembicFile, StaticTransformsAreApplied) {
    // Rotate by 90 degrees about z after scaling, then translate; the outer transform adds 100 in x.
    const std::string operations = "\x10\x60" + std::string(1, '\0');
    const FileContents contents = parsed(transformedMesh(operations, numbers({1, 2, 3, 90, 2, 3, 4})));
    const Mesh mesh = meshFrom(contents, "a.abc");
    expectRows(mesh.position, {{101, 2, 3}, {101, 4, 3}, {98, 2, 3}, {101, 2, 7}});
    expectRows(mesh.velocity, {{0, 0, 0}, {0, 2, 0}, {-3, 0, 0}, {0, 0, 4}});
    ASSERT_EQ(mesh.attributes.size(), 1U);
    const std::vector<float>& n = mesh.attributes[0].real;
    expectRows({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[9], n[10], n[11]}},
               {{0, 1, 0}, {-1, 0, 0}, {-0.8 / 3 / std::hypot(0.3, 0.8 / 3), 0.3 / std::hypot(0.3, 0.8 / 3), 0}});
    EXPECT_EQ(mesh.triangles[0], (Triangle{0, 2, 1}));
    // A mirror turns the triangles.
    const Bytes mirrored = transformedMesh(std::string(1, '\0'), numbers({-1, 1, 1}));
    EXPECT_EQ(parsed(mirrored).triangles[0], (Triangle{0, 1, 2}));
    // A transform that does not inherit ignores those above.
    const Bytes alone =
        transformedMesh("\x30", numbers({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}), false, false);
    expectRows(meshFrom(parsed(alone), "a.abc").position, {{5, 6, 7}, {6, 6, 7}, {5, 7, 7}, {5, 6, 8}});
    expectError(
        [&] {
            parsed(transformedMesh("\x10", numbers({1, 2, 3}), true));
        },
        {"transform '/outer/inner' moves", "one frame per file"});
    expectError([&] { parsed(transformedMesh("\x10", numbers({1, 2}))); }, {"'/outer/inner' has too few numbers"});
    expectError([&] { parsed(transformedMesh("\x70", numbers({1, 2}))); }, {"'/outer/inner' has an unknown operation"});
}

TEST(AlembicFile, OfSeveralSamplesTheFirstIsReadWithAWarning) {
    const TemporaryFolder folder;
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1");
    const OgawaChild shape = archive.object(".geom", tetrahedron(archive, {kTetrahedron, kTetrahedron, kTetrahedron}));
    const Bytes bytes = archive.bytes(archive.object("", {}, {{"drop", {mesh, shape}}}));
    const FileContents contents = parsed(bytes);
    EXPECT_EQ(contents.triangles.size(), 4U);
    ASSERT_EQ(contents.warnings.size(), 1U);
    EXPECT_NE(contents.warnings[0].find("'/drop' has 3 time samples, of which the first is read and 2 left out"),
              std::string::npos)
        << contents.warnings[0];
    std::ofstream(folder / "a.abc", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const FileInfo info = inspectFile(folder / "a.abc");
    EXPECT_EQ(info.triangles, 4U);
    EXPECT_EQ(info.format, "alembic ogawa, first of 3 samples");
}

TEST(AlembicFile, TheSampleOfAFrameIsTheLatestUntilThen) {
    const TemporaryFolder folder;
    const auto sampling = [](double cycle, const std::vector<double>& times) {
        return packed<std::uint32_t>({9}) + numbers({cycle}) +
               packed<std::uint32_t>({static_cast<std::uint32_t>(times.size())}) + packed(times);
    };
    const auto point = [](double x) { return numbers({x, 0, 0}); };
    const std::uint32_t flags = flagsOf(kArray, AlembicType::float64, 3) | kHasTimeSampling;
    const std::string start = sampling(1, {0});
    // Samples of the frames 3 to 7. Those that are the same as the one before are not stored.
    for (const bool has_range : {false, true}) {
        TestArchive archive;
        const int points = archive.addMetadata("schema=AbcGeom_Points_v1");
        TestArchive::Properties cloud;
        if (has_range)
            archive.property(cloud, "P", flags | kHasChangedRange, {point(3), point(5), point(6)}, 0, "\5\2\3");
        else
            archive.property(cloud, "P", flags, {point(3), point(4), point(5), point(6), point(7)});
        archive.property(cloud, ".velocities", flags | kConstant, {point(-1)}, 0, "\5");
        archive.property(cloud, ".pointIds", flagsOf(kArray, AlembicType::uint64, 1), {packed<std::uint64_t>({9})});
        const OgawaChild drops = archive.object(".geom", cloud);
        const OgawaChild top = archive.object("", {}, {{"drops", {points, drops}}});
        const Bytes bytes = archive.bytes(top, start + sampling(1.0 / 24, {3.0 / 24}));
        writeFile(folder / "a.abc", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
        EXPECT_EQ(sampleTimes(folder / "a.abc", {}), (std::vector<double>{3, 4, 5, 6, 7}));
        const std::vector<float> expected =
            has_range ? std::vector<float>{3, 3, 5, 6, 6} : std::vector<float>{3, 4, 5, 6, 7};
        ParticleInput input;
        for (int frame = 2; frame <= 8; ++frame) {
            input.frame = frame;
            const auto [particles, summary] = readSummarised(folder / "a.abc", input);
            EXPECT_EQ(particles.position.at(0).x, expected[static_cast<std::size_t>(std::clamp(frame, 3, 7) - 3)]);
            EXPECT_EQ(particles.velocity.at(0).x, -1);
            EXPECT_EQ(particles.id, std::vector<std::uint64_t>{9});
            EXPECT_EQ(summary.warnings.empty(), frame >= 3 && frame <= 7) << frame;
        }
        input.frame = 5.5;
        EXPECT_EQ(readParticles(folder / "a.abc", input).position.at(0).x, 5);
        EXPECT_EQ(readParticles(folder / "a.abc").position.at(0).x, 3);
    }
    // Times without cycle, and times within frames.
    TestArchive archive;
    const int points = archive.addMetadata("schema=AbcGeom_Points_v1");
    TestArchive::Properties cloud;
    archive.property(cloud, "P", flags, {point(1), point(2), point(4)});
    const OgawaChild drops = archive.object(".geom", cloud);
    const OgawaChild top = archive.object("", {}, {{"drops", {points, drops}}});
    const std::string acyclic = sampling(1e300, {1.0 / 25, 2.5 / 25, 4.0 / 25}), rate = sampling(1.0 / 25, {0});
    const Bytes bytes = archive.bytes(top, start + acyclic + rate);
    writeFile(folder / "b.abc", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    EXPECT_EQ(sampleTimes(folder / "b.abc", {}), (std::vector<double>{1, 2.5, 4}));
    // Without a frame rate there are no frames.
    const Bytes unknown = archive.bytes(top, start + acyclic);
    writeFile(folder / "c.abc", std::string(reinterpret_cast<const char*>(unknown.data()), unknown.size()));
    EXPECT_TRUE(sampleTimes(folder / "c.abc", {}).empty());
    EXPECT_EQ(readParticles(folder / "c.abc").position.at(0).x, 1);
}

TEST(AlembicFile, AMeshIsReadAtAFrame) {
    const TemporaryFolder folder;
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1");
    TestArchive::Properties animated;
    const std::string moved = packed<float>({5, 0, 0, 6, 0, 0, 5, 1, 0, 5, 0, 1});
    archive.property(animated, "P", flagsOf(kArray, AlembicType::float32, 3) | kHasTimeSampling,
                     {kTetrahedron, kTetrahedron, moved});
    archive.property(animated, ".faceIndices", flagsOf(kArray, AlembicType::int32, 1),
                     {packed<std::int32_t>({0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2})});
    archive.property(animated, ".faceCounts", flagsOf(kArray, AlembicType::int32, 1),
                     {packed<std::int32_t>({3, 3, 3, 3})});
    const OgawaChild shape = archive.object(".geom", animated);
    const std::string sampling = packed<std::uint32_t>({9}) + numbers({1.0 / 24}) + packed<std::uint32_t>({1});
    const Bytes bytes = archive.bytes(archive.object("", {}, {{"drop", {mesh, shape}}}),
                                      packed<std::uint32_t>({9}) + numbers({1}) + packed<std::uint32_t>({1}) +
                                          numbers({0}) + sampling + numbers({10.0 / 24}));
    const std::filesystem::path file = folder / "a.abc";
    writeFile(file, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    EXPECT_EQ(sampleTimes(file, {}, FileKind::mesh), (std::vector<double>{10, 11, 12}));
    EXPECT_EQ(readMesh(file).position.at(0).x, 0);
    EXPECT_EQ(readMesh(file, 11).position.at(0).x, 0);
    EXPECT_EQ(readMesh(file, 12).position.at(0).x, 5);
    EXPECT_EQ(readMesh(file, 12).triangles, readMesh(file).triangles);
    EXPECT_EQ(inspectFile(file).times, (std::vector<double>{10, 11, 12}));
}

TEST(AlembicFile, SeveralObjectsAreNeverJoinedInSilence) {
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1"),
              points = archive.addMetadata("schema=AbcGeom_Points_v1"),
              camera = archive.addMetadata("schema=AbcGeom_Camera_v1");
    const auto drops = [&](float x) {
        TestArchive::Properties geometry;
        archive.property(geometry, "P", flagsOf(kArray, AlembicType::float32, 3), {packed<float>({x, 0, 0})});
        return archive.object(".geom", geometry);
    };
    const OgawaChild shape = archive.object(".geom", tetrahedron(archive, {kTetrahedron}));
    const Bytes bytes = archive.bytes(archive.object("", {},
                                                     {{"a", {points, drops(1)}},
                                                      {"b", {points, drops(2)}},
                                                      {"m", {mesh, shape}},
                                                      {"n", {camera, archive.object("", {})}}}));
    EXPECT_EQ(parsed(bytes).triangles.size(), 4U);  // the only mesh
    ReadOptions options;
    options.faces = false;
    expectError([&] { parsed(bytes, options); }, {"'/a', '/b'", "input.grid"});
    options.grids = {"/b"};
    const FileContents contents = parsed(bytes, options);
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{2, 0, 0}}));
    ASSERT_EQ(contents.grids.size(), 4U);
    EXPECT_FALSE(contents.grids[0].is_read);
    EXPECT_TRUE(contents.grids[1].is_read);
    EXPECT_EQ(contents.grids[3].type, "AbcGeom_Camera_v1");
    options.grids = {"a", "b"};
    EXPECT_EQ(parsed(bytes, options).position, (std::vector<Vec3f>{{1, 0, 0}, {2, 0, 0}}));
    options.grids = {"c"};
    expectError([&] { parsed(bytes, options); }, {"no object 'c'", "'/a', '/b'"});
}

TEST(AlembicFile, AttributesOfOtherProgramsAreReadOrNamed) {
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1"), corner = archive.addMetadata("geoScope=fvr"),
              vertex = archive.addMetadata("geoScope=vtx");
    TestArchive::Properties geometry = tetrahedron(archive, {kTetrahedron}), parameters, indexed;
    archive.property(geometry, "uv", flagsOf(kArray, AlembicType::float32, 2), {packed<float>({1, 2})}, corner);
    archive.property(indexed, ".vals", flagsOf(kArray, AlembicType::float64, 2), {numbers({1, 2, 3, 4})});
    archive.property(indexed, ".indices", flagsOf(kArray, AlembicType::uint32, 1),
                     {packed<std::uint32_t>({1, 0, 0, 1})});
    archive.compound(parameters, "heat", indexed, vertex);
    archive.property(parameters, "name", flagsOf(kArray, AlembicType::string, 1), {raw("a\0b\0c\0d\0")}, vertex);
    archive.property(parameters, "half", flagsOf(kArray, AlembicType::float16, 1), {"12345678"}, vertex);
    archive.property(parameters, "big", flagsOf(kArray, AlembicType::uint64, 1), {packed<std::uint64_t>({1, 2, 3, 4})},
                     vertex);
    archive.compound(geometry, ".arbGeomParams", parameters);
    const OgawaChild shape = archive.object(".geom", geometry);
    const FileContents contents = parsed(archive.bytes(archive.object("", {}, {{"a", {mesh, shape}}})));
    expectSame(contents.attributes, {{"heat", 2, {3, 4, 1, 2, 1, 2, 3, 4}, {}}, {"big", 1, {}, {1, 2, 3, 4}}});
    EXPECT_EQ(contents.passed_over, (std::vector<std::string>{"'uv', not of points", "'half' of type float16_t"}));
    EXPECT_TRUE(std::any_of(contents.declared.begin(), contents.declared.end(),
                            [](const AttributeInfo& info) { return info.name == "name" && info.type == "string"; }));
}

TEST(AlembicFile, WidthsOfOtherProgramsAreDiameters) {
    for (const auto& [widths, radius] :
         {std::pair<std::vector<float>, std::vector<float>>{{1, 3}, {0.5F, 1.5F}}, {{4}, {2, 2}}, {{1, 2, 3}, {}}}) {
        TestArchive archive;
        const int points = archive.addMetadata("schema=AbcGeom_Points_v1");
        TestArchive::Properties geometry;
        archive.property(geometry, "P", flagsOf(kArray, AlembicType::float32, 3), {packed<float>({0, 0, 0, 1, 0, 0})});
        archive.property(geometry, ".widths", flagsOf(kArray, AlembicType::float32, 1), {packed(widths)});
        const OgawaChild shape = archive.object(".geom", geometry);
        const FileContents contents = parsed(archive.bytes(archive.object("", {}, {{"a", {points, shape}}})));
        if (radius.empty())
            EXPECT_EQ(contents.passed_over, (std::vector<std::string>{"'.widths', not one per point"}));
        else
            expectSame(contents.attributes, {{"pscale", 1, radius, {}}});
    }
}

TEST(AlembicFile, DamageIsAnError) {
    const Bytes whole =
        bytesOf([&](ByteWriter& out) { encodeAbc(out, withComponents(sampleMesh(10, true, true)), "a.abc"); });
    Bytes open = whole;
    open[5] = std::byte{0};
    expectError([&] { parsed(open); }, {"a.abc", "not complete", "interrupted"});
    Bytes version = whole;
    version[7] = std::byte{2};
    expectError([&] { parsed(version); }, {"version 2 of the Ogawa container is unknown"});
    expectError([&] { parsed(Bytes(whole.begin(), whole.end() - 8)); }, {"truncated or damaged"});
    expectError([&] { parsed(bytesOf("Ogawa\xff")); }, {"too short"});
    TestArchive archive;  // a group whose child is itself
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1");
    const OgawaChild ring = 16 + 8 + 32;  // after the header and the first data, of 32 bytes
    OgawaWriter& file = archive.file;
    file.data(std::string(32, '\0'));
    std::string header = packed<std::uint32_t>({1}) + "a";
    header += static_cast<char>(mesh);
    const OgawaChild headers = (ring + 8 + 3 * 8) | kOgawaDataBit;
    ASSERT_EQ(file.group({kEmptyGroup, ring, headers}), ring);
    ASSERT_EQ(file.data(header + std::string(32, '\0')), headers);
    expectError([&] { parsed(archive.bytes(ring)); }, {"a group is used twice"});
}

TEST(AlembicFile, ASmallFileCannotAskForMuchWork) {
    TestArchive archive;
    const int points = archive.addMetadata("schema=AbcGeom_Points_v1"), vertex = archive.addMetadata("geoScope=vtx");
    TestArchive::Properties geometry, parameters;
    const std::size_t n = 100000;
    archive.property(geometry, "P", flagsOf(kArray, AlembicType::float32, 3), {packed(std::vector<float>(3 * n))});
    const OgawaChild data = archive.file.data(std::string(16 + 4 * n, '\0'));
    for (int i = 0; i < 2000; ++i) {  // attributes that share their numbers
        parameters.groups.push_back(archive.file.group({data, kEmptyData}));
        parameters.headers += packed<std::uint32_t>(
            {flagsOf(kArray, AlembicType::float32, 1) | static_cast<std::uint32_t>(vertex) << kMetadataShift});
        const std::string name = "a" + std::to_string(i);
        parameters.headers += std::string(1, 1) + static_cast<char>(name.size()) + name;
    }
    archive.compound(geometry, ".arbGeomParams", parameters);
    const OgawaChild shape = archive.object(".geom", geometry);
    const Bytes bytes = archive.bytes(archive.object("", {}, {{"a", {points, shape}}}));
    expectError([&] { parsed(bytes); }, {"overlap so much that it must be damaged"});
}

}  // namespace
}  // namespace betamesh
