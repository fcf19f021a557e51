// The table of file formats, and what follows from it.

#include "io/extension.h"

#include "io/curve_file.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/ply.h"
#include "support/file_checks.h"

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace betamesh {
namespace {

std::vector<std::string> wordsOf(std::string_view text) {
    std::istringstream in{std::string(text)};
    return {std::istream_iterator<std::string>(in), {}};
}

std::string textOf(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string allTests() {
    const std::filesystem::path folder = std::filesystem::path(BETAMESH_SOURCE) / "tests";
    std::string text = textOf(folder / "CMakeLists.txt");
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".cpp") text += textOf(entry.path());
    return text;
}

TEST(FormatTable, RowsAreConsistent) {
    std::set<std::string> read, written;
    const std::string tests = allTests();
    for (const FileFormat& format : fileFormats()) {
        SCOPED_TRACE(format.name);
        for (const std::string& extension : wordsOf(format.read_extensions)) {
            EXPECT_EQ(extension.front(), '.');
            EXPECT_TRUE(read.insert(extension).second) << extension << " belongs to two formats";
        }
        for (const std::string& extension : wordsOf(format.write_extensions))
            EXPECT_TRUE(written.insert(extension).second) << extension << " belongs to two formats";
        EXPECT_EQ(format.read_extensions.empty(), format.read == nullptr);
        EXPECT_EQ(format.read != nullptr, format.reads_particles || format.reads_surfaces);
        EXPECT_EQ(format.write_extensions.empty(),
                  !format.write_particles && !format.write_mesh && !format.write_curves && !format.is_drawing);
        EXPECT_EQ(format.write_particles != nullptr, format.id_bits > 0);
        EXPECT_GT(format.particle_bytes, 0);
        EXPECT_FALSE(format.proof.empty());
        // The test that is named exists, either as TEST(SUITE, NAME) or as a script that CMake adds.
        const std::string name(format.test);
        const std::size_t dot = name.find('.');
        ASSERT_NE(dot, std::string::npos) << name;
        const std::string in_source = "(" + name.substr(0, dot) + ", " + name.substr(dot + 1) + ")";
        EXPECT_TRUE(tests.find(in_source) != std::string::npos ||
                    tests.find("NAME " + name + "\n") != std::string::npos)
            << name;
    }
}

// What a row promises to write is read back where the format can be read.
TEST(FormatTable, EveryFormatHoldsWhatItsRowSays) {
    const TemporaryFolder folder;
    const Particles particles = sampleParticles(20, true, true, true);
    Mesh mesh = withComponents(sampleMesh(20, true, true));
    Curves curves;
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)}) curves.position.push_back(p);
    curves.velocity.assign(3, Vec3(1, 2, 0));
    curves.edges = {{0, 1}, {1, 2}, {2, 0}};
    for (const FileFormat& format : fileFormats())
        for (const std::string& extension : wordsOf(format.write_extensions)) {
            SCOPED_TRACE(extension);
            const std::string file = folder / ("a" + extension);
            if (format.write_particles != nullptr) {
                writeParticles(file, particles);
                EXPECT_EQ(readParticles(file).size(), particles.size());
                EXPECT_EQ(readParticles(file).id.size(), particles.size());
                EXPECT_EQ(readParticles(file).attributes.size(), particles.attributes.size());
            }
            if (format.write_mesh != nullptr) writeMesh(file, mesh);
            if (format.is_volume) {
                EXPECT_EQ(inspectFile(file).volumes.size(), 1U);
            }
            if (format.write_mesh != nullptr && format.reads_surfaces) {
                const Mesh back = readMesh(file);
                EXPECT_EQ(back.triangles.size(), mesh.triangles.size());
                EXPECT_EQ(!back.velocity.empty(), format.holds_attributes);
                EXPECT_EQ(!back.attributes.empty(), format.holds_attributes || format.holds_normals);
                EXPECT_EQ(back.component.has_value(), format.holds_components);
            }
            if (format.write_curves != nullptr) {
                writeCurves(file, curves);
                EXPECT_EQ(readCurves(file).edges, curves.edges);
                EXPECT_EQ(!readCurves(file).velocity.empty(), format.holds_attributes);
            }
            if (format.write_spheres != nullptr) {
                writeSpheres(file, {{Vec3(1, 2, 3)}, {}, {0.5F}, {7}});
                ASSERT_EQ(readParticles(file).attributes.size(), 1U);
                EXPECT_EQ(readParticles(file).attributes[0].real, (std::vector<float>{0.5F}));
            }
        }
}

TEST(FormatTable, ErrorsSayWhatCanBeUsedInstead) {
    const auto refused = [](const char* file, FileKind kind, Access access, const std::vector<std::string>& parts) {
        expectError([&] { formatOf(file, kind, access); }, parts);
        EXPECT_FALSE(canHold(file, kind, access));
    };
    refused("a.stl", FileKind::mesh, Access::read, {"a.stl: .stl can be written, but not read", ".vtp"});
    refused("a.geo", FileKind::mesh, Access::write, {".geo can be read, but not written", ".bgeo.sc"});
    refused("a.vdb", FileKind::mesh, Access::read, {"'.vdb' is not a format for meshes", ".obj"});
    refused("a.obj", FileKind::particles, Access::read, {"'.obj' is not a format for particles", ".prt", ".csv"});
    refused("a.ply.gz", FileKind::particles, Access::read, {"'.gz' is not a format for particles", ".bgeo.gz"});
    refused("a", FileKind::curves, Access::write, {"no extension", ".svg"});
    EXPECT_EQ(formatOf("x/A.BGEO.SC", FileKind::mesh, Access::read).name, "Houdini geometry");
}

TEST(FormatTable, ContentsDecideWhatAFileIs) {
    const TemporaryFolder folder;
    const Particles particles = sampleParticles(9, true, true, false);
    for (const std::string extension :
         {".ply", ".bgeo", ".bgeo.gz", ".bgeo.sc", ".bhclassic", ".vdb", ".abc", ".vtp", ".usda"}) {
        SCOPED_TRACE(extension);
        const std::string right = folder / ("a" + extension), wrong = folder / "b";
        writeParticles(right, particles);
        EXPECT_EQ(inspectFile(right).note, "");
        for (const std::string other : {".prt", ".obj", ".csv", ""}) {
            std::filesystem::copy_file(right, wrong + other);
            const FileInfo info = inspectFile(wrong + other);
            EXPECT_EQ(info.points, 9U);
            EXPECT_NE(info.note.find("Rename it so that it ends in ."), std::string::npos) << info.note;
            if (other == ".csv" || other == ".prt")
                expectError([&] { readParticles(wrong + other); }, {"contains ", ", not ", "Rename it"});
            std::filesystem::remove(wrong + other);
        }
    }
    const auto refused = [&](const std::string& name, const std::string& text, const std::vector<std::string>& parts) {
        std::ofstream(folder / name, std::ios::binary) << text;
        expectError([&] { inspectFile(folder / name); }, parts);
    };
    const Bytes ply = bytesOf([&](ByteWriter& out) { encodePly(out, particles, ""); });
    const Bytes packed = gzip(ply);
    refused("packed.ply", {reinterpret_cast<const char*>(packed.data()), packed.size()},
            {"packed.ply: contains PLY compressed by gzip", "gunzip"});
    refused("a.usda", "PXR-USDC", {"binary USD", "cannot be read", "usdcat"});
    refused("b.bgeo", "\x89HDF\r\n", {"HDF5, the older container of Alembic", "cannot be read"});
    for (const char* name : {"e.ply", "e.bgeo", "e.usda", "e.vtp"})
        refused(name, "", {std::string(name) + ": empty file (0 bytes), expected "});
    expectError([&] { readParticles(folder / "e.ply"); }, {"e.ply: empty file (0 bytes), expected PLY"});
    refused("a.stl", "nothing", {".stl can be written, but not read"});
    refused("a.dat", "nothing", {"a.dat", "neither the extension nor the contents"});
}

TEST(FormatTable, MemoryEstimatesKnowEveryExtension) {
    EXPECT_LT(fileBytesPerParticle("a.bgeo.sc"), fileBytesPerParticle("a.bgeo"));
    EXPECT_GT(fileBytesPerParticle("a.geo"), fileBytesPerParticle("a.bgeo"));
    EXPECT_GT(fileBytesPerParticle("a.csv"), fileBytesPerParticle("a.ply"));
    for (const FileFormat& format : fileFormats())
        for (const std::string& extension : wordsOf(format.read_extensions)) {
            EXPECT_GE(fileBytesPerParticle("a" + extension), 10) << extension;
            EXPECT_LE(fileBytesPerParticle("a" + extension), 150) << extension;
        }
}

TEST(FormatTable, ReadmeNamesEveryExtension) {
    const std::string readme = textOf(std::filesystem::path(BETAMESH_SOURCE) / "README.md");
    for (const FileFormat& format : fileFormats())
        for (const std::string_view list : {format.read_extensions, format.write_extensions})
            for (const std::string& extension : wordsOf(list))
                EXPECT_NE(readme.find('`' + extension + '`'), std::string::npos) << extension;
}

}  // namespace
}  // namespace betamesh
