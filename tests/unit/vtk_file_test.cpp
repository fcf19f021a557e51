// VTK files: what is written comes back; files as other programs write them, in every encoding.

#include "io/vtk.h"

#include "io/output_file.h"
#include "support/file_checks.h"

namespace betamesh {
namespace {

FileContents parsedXml(const std::string& text, const ReadOptions& options = {}) {
    const Bytes bytes = bytesOf(text);
    return parseVtkXml({bytes, "a.vtu"}, options);
}

FileContents parsedLegacy(const std::string& text, const ReadOptions& options = {}) {
    const Bytes bytes = bytesOf(text);
    return parseVtk({bytes, "a.vtk"}, options);
}

TEST(VtkFile, ParticlesComeBackBitForBit) {
    for (const std::size_t n : {0U, 1U, 2U, 1000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            Particles particles = sampleParticles(n, mask & 1, mask & 2, mask & 4);
            if (!particles.id.empty()) particles.id[0] = (std::uint64_t{1} << 60) + 1;
            const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeVtp(out, particles, "a.vtp"); });
            if (n == 0) particles.attributes.clear();
            expectSame(particlesFrom(parseVtkXml({bytes, "a.vtp"}), {}, "a.vtp"), particles);
        }
}

TEST(VtkFile, MeshesComeBackBitForBit) {
    ReadOptions options;
    options.id.clear();
    for (const std::size_t n : {3U, 100U})
        for (int mask = 0; mask < 4; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " vertices, mask " + std::to_string(mask));
            Mesh mesh = sampleMesh(n, true, mask & 1);
            if (mask & 2) mesh = withComponents(mesh);
            const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeVtp(out, mesh, "a.vtp"); });
            const Mesh expected = withNormals(mesh);
            expectSame(meshFrom(parseVtkXml({bytes, "a.vtp"}, options), "a.vtp"), expected);
            const Mesh again = meshFrom(parseVtkXml({bytes, "a.vtp"}, options), "a.vtp");
            const Bytes second = bytesOf([&](ByteWriter& out) { encodeVtp(out, again, "a.vtp"); });
            expectSame(meshFrom(parseVtkXml({second, "a.vtp"}, options), "a.vtp"), expected);
        }
}

TEST(VtkFile, CurvesComeBack) {
    Curves curves;
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(5, 5, 0), Vec3(6, 5, 0), Vec3(5, 6, 0)})
        curves.position.push_back(p);
    curves.velocity.assign(6, Vec3(1, 2, 0));
    curves.edges = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}};
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeVtp(out, curves, "a.vtp"); });
    const Curves read = curvesFrom(parseVtkXml({bytes, "a.vtp"}), "a.vtp");
    EXPECT_EQ(read.position, curves.position);
    EXPECT_EQ(read.velocity, curves.velocity);
    EXPECT_EQ(read.edges, curves.edges);
}

TEST(VtkFile, NormalsOfTheMeshAreTheActiveNormalsOfVtk) {
    Mesh mesh = sampleMesh(3, true, false);
    mesh.attributes.push_back({"N", 3, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {}});
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeVtp(out, mesh, "a.vtp"); });
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_NE(text.find("Normals=\"Normals\""), std::string::npos);
    EXPECT_NE(text.find("Name=\"Normals\""), std::string::npos);
    expectSame(meshFrom(parseVtkXml({bytes, "a.vtp"}), "a.vtp"), mesh);  // not replaced by computed ones
}

// One small cloud in every encoding that XML has.
TEST(VtkFile, EveryEncodingOfXmlGivesTheSame) {
    const auto file = [](const std::string& head, const std::string& points, const std::string& ids,
                         const std::string& tail) {
        return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"" + head +
               "><UnstructuredGrid><Piece NumberOfPoints=\"2\" NumberOfCells=\"0\"><Points>"
               "<DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" " +
               points + "</DataArray></Points><PointData><DataArray type=\"Int32\" Name=\"id\" " + ids +
               "</DataArray></PointData></Piece></UnstructuredGrid>" + tail + "</VTKFile>";
    };
    // 0 1 2 3 4 5 as floats; 7 9 as integers.
    const std::string ascii = file("", "format=\"ascii\">0 1e0 2\n3 4 +5", "format=\"ascii\"> 7 9 ", "");
    const std::string base64 = file(
        "", "format=\"binary\"> GAAAAAAAAAAAAIA/AAAAQAAAQEAAAIBAAACgQA== ", "format=\"binary\">CAAAAAcAAAAJAAAA", "");
    const std::string floats = raw("\0\0\0\0\0\0\200?\0\0\0@\0\0@@\0\0\200@\0\0\240@");
    const std::string raw_data = raw("_\30\0\0\0") + floats + raw("\10\0\0\0\7\0\0\0\11\0\0\0");
    const std::string appended = file("", "format=\"appended\" offset=\"0\">", "format=\"appended\" offset=\"28\">",
                                      "<AppendedData encoding=\"raw\">" + raw_data + "</AppendedData>");
    const std::string appended64 = file(
        "", "format=\"appended\" offset=\"0\">", "format=\"appended\" offset=\"40\">",
        "<AppendedData encoding=\"base64\">_GAAAAAAAAAAAAIA/AAAAQAAAQEAAAIBAAACgQA==CAAAAAcAAAAJAAAA</AppendedData>");
    for (const std::string& text : {ascii, base64, appended, appended64}) {
        const FileContents contents = parsedXml(text);
        EXPECT_EQ(contents.position, (std::vector<Vec3f>{{0, 1, 2}, {3, 4, 5}}));
        EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{7, 9}));
    }
}

TEST(VtkFile, PiecesOfXmlAreJoined) {
    const auto piece = [](const std::string& x) {
        return "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData><DataArray type=\"Float64\" Name=\"a b\" "
               "format=\"ascii\">1 2 " +
               x +
               "</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
               "0 0 " +
               x +
               " 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" "
               "format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3"
               "</DataArray></Polys></Piece>";
    };
    const FileContents contents =
        parsedXml("<VTKFile type=\"PolyData\"><PolyData>" + piece("7") + piece("8") + "</PolyData></VTKFile>");
    ASSERT_EQ(contents.position.size(), 6U);
    EXPECT_EQ(contents.position[3], Vec3f(0, 0, 8));
    EXPECT_EQ(contents.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
    ASSERT_EQ(contents.attributes.size(), 1U);
    EXPECT_EQ(contents.attributes[0].name, "a_b");
    EXPECT_EQ(contents.attributes[0].real, (std::vector<float>{1, 2, 7, 1, 2, 8}));
}

TEST(VtkFile, LegacyVersionsAndSections) {
    const std::string points = "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0\n0 1 0\n";
    const std::string data =
        "CELL_DATA 1\nSCALARS c int\nLOOKUP_TABLE default\n4\n"
        "POINT_DATA 3\nSCALARS density double 1\nLOOKUP_TABLE t\n1 2 3\nLOOKUP_TABLE t 2\n0 0 0 1 1 1 1 1\n"
        "VECTORS v float\n1 2 3 4 5 6 7 8 9\nMETADATA\nINFORMATION 0\n\nCOLOR_SCALARS Cd 3\n0 0 0 .5 .5 .5 1 1 1\n"
        "FIELD f 2\nid 1 3 vtkIdType\n5 6 7\nother%20name 2 3 short\n1 2 3 4 5 6\n";
    const std::string old_cells = "POLYGONS 1 4\n3 0 1 2\n",
                      new_cells = "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n";
    for (const auto& [version, cells] : {std::pair("3.0", old_cells), {"4.2", old_cells}, {"5.1", new_cells}}) {
        SCOPED_TRACE(version);
        const FileContents contents =
            parsedLegacy("# vtk DataFile Version " + std::string(version) + "\ntitle\nASCII\n" + points + cells + data);
        EXPECT_EQ(contents.position, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
        EXPECT_EQ(contents.triangles, (std::vector<Triangle>{{0, 1, 2}}));
        EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{5, 6, 7}));
        std::vector<std::string> names;
        for (const Attribute& a : contents.attributes) names.push_back(a.name);
        EXPECT_EQ(names, (std::vector<std::string>{"density", "v", "Cd", "other_name"}));
        EXPECT_EQ(contents.attributes[3].integer, (std::vector<std::int32_t>{1, 2, 3, 4, 5, 6}));
    }
}

TEST(VtkFile, LegacyBinaryIsBigEndian) {
    const FileContents contents = parsedLegacy(
        "# vtk DataFile Version 4.1\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n" +
        raw("\77\200\0\0@\0\0\0@@\0\0") + "\nCELLS 1 2\n" + raw("\0\0\0\1\0\0\0\0") + "\nCELL_TYPES 1\n" +
        raw("\0\0\0\1") + "\nPOINT_DATA 1\nSCALARS id unsigned_int 1\nLOOKUP_TABLE d\n" + raw("\0\0\1\0") + "\n");
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}}));
    EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{256}));
}

TEST(VtkFile, ErrorsSayWhatIsWrong) {
    const auto refusedLegacy = [](const std::string& text, const std::vector<std::string>& words) {
        expectError([&] { parsedLegacy(text); }, words);
    };
    const std::string head = "# vtk DataFile Version 4.1\nt\nASCII\n";
    refusedLegacy("ply", {"a.vtk", "# vtk DataFile Version"});
    refusedLegacy(head + "DATASET STRUCTURED_POINTS\n", {"STRUCTURED_POINTS", "POLYDATA"});
    refusedLegacy(head + "DATASET POLYDATA\n", {"without POINTS"});
    refusedLegacy(head + "DATASET POLYDATA\nPOINTS 2 float\n1 2 3 4 x", {"POINTS has 4 numbers, expected 6"});
    refusedLegacy(head + "DATASET POLYDATA\nPOINTS 2 string\n", {"'string'"});
    refusedLegacy(head + "DATASET POLYDATA\nPOINTS 1 float\n1 2 3\nPOLYGONS 1 4\n3 0 0 7\n", {"cell 0", "corner 7"});
    refusedLegacy(head + "DATASET POLYDATA\nPOINTS 1 float\n1 2 3\nNONSENSE\n", {"NONSENSE"});
    const auto refusedXml = [](const std::string& text, const std::vector<std::string>& words) {
        expectError([&] { parsedXml(text); }, words);
    };
    refusedXml("<a>", {"XML"});
    refusedXml("<a/>", {"VTKFile"});
    refusedXml("<VTKFile type=\"ImageData\"/>", {"ImageData", "PolyData"});
    refusedXml("<VTKFile type=\"PolyData\" compressor=\"vtkLZ4DataCompressor\"/>", {"vtkLZ4DataCompressor"});
    refusedXml(
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"><Points><DataArray type=\"Float32\" "
        "NumberOfComponents=\"3\" format=\"ascii\">1 2</DataArray></Points></Piece></PolyData></VTKFile>",
        {"2 numbers, expected 3 for each of 1"});
    const Bytes bytes = bytesOf([](ByteWriter& out) { encodeVtp(out, sampleParticles(5, true, true, true), "a.vtp"); });
    const std::string whole(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_EQ(parsedXml(whole).position.size(), 5U);
    for (const char* end : {"</VTKFile", "</AppendedData"})  // all arrays are complete
        refusedXml(whole.substr(0, whole.rfind(end)), {"without </VTKFile>", "truncated"});
}

// Counts and velocities as the files' own programs have them.
TEST(VtkFile, RealFiles) {
    const std::filesystem::path folder = std::string(BETAMESH_SHARED) + "/data/formats";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real files beside the project";
    const auto particlesOf = [&](const std::string& name) {
        const std::string file = folder / name;
        return particlesFrom(name.ends_with(".vtk") ? parseVtk(openFile(file)) : parseVtkXml(openFile(file)), {}, file);
    };
    const Particles bunny = particlesOf("splashsurf__bunny_frame_14_7705_particles.vtk");
    EXPECT_EQ(bunny.size(), 7706U);
    EXPECT_EQ(bunny.velocity.size(), 7706U);
    EXPECT_EQ(bunny.id.size(), 7706U);
    const Particles legacy = particlesOf("splashsurf__cube_8_particles.vtk"),
                    xml = particlesOf("splashsurf__cube_8_particles.vtu");
    EXPECT_EQ(legacy.position, xml.position);
    const Particles packed = particlesOf("splashsurf__fluid_250_particles.vtu"),
                    encoded = particlesOf("splashsurf__fluid_encoded_250_particles.vtu");
    EXPECT_EQ(packed.position, encoded.position);
    EXPECT_EQ(packed.velocity, encoded.velocity);
    EXPECT_EQ(packed.velocity.size(), 250U);
    expectSame(packed.attributes, encoded.attributes);
}

}  // namespace
}  // namespace betamesh
