// Text files of USD.

#include "io/usd.h"

#include "io/convert_file.h"
#include "io/extension.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/output_file.h"
#include "io/particle_file.h"
#include "io/usd_clips.h"
#include "support/file_checks.h"
#include "support/program.h"

#include <bit>
#include <cmath>
#include <limits>

namespace betamesh {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Without the normals that writers add.
Mesh withoutNormals(Mesh mesh) {
    std::erase_if(mesh.attributes, [](const Attribute& a) { return a.name == "N"; });
    return mesh;
}

FileContents parsed(const std::string& text, const ReadOptions& options = {}) {
    const Bytes bytes = bytesOf(text);
    return parseUsda({bytes, "a.usda"}, options);
}

/// A file with one prim of type Points and further lines in it.
std::string withPoints(const std::string& lines, const std::string& metadata = "") {
    return "#usda 1.0\ndef Points \"p\" " + metadata + "{\npoint3f[] points = [(1, 2, 3), (4, 5, 6)]\n" + lines + "}\n";
}

const char* const kQuads = R"(#usda 1.0
( "A comment about the layer"
    upAxis = "Z"
    customLayerData = { string s = "}" }
)
# A comment with a bracket (
def Xform "world" ( kind = "component" ) {
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Scope "inner" { rel proxyPrim = </world/quads>; def Mesh "quads" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        ) {
        float3[] extent = [(0, 0, 0), (1, 1, 1)]
        int[] faceVertexCounts = [4, 3,]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 2]
        rel material:binding = </world/material>
        uniform token orientation = "leftHanded"
        point3d[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        vector3f[] velocities = [(1, 0, 0), (1, 0, 0), (1, 0, 0), (1, 0, 0)]
        texCoord2f[] primvars:st = [(0, 0)] ( interpolation = "faceVarying" )
        float3 xformOp:scale = (2, 3, 4)
        uniform token[] xformOpOrder = ["xformOp:scale"]
        string note = """a
"quoted" } string"""
    } }
    class Mesh "left_out" { int[] faceVertexCounts = [3] }
    def Mesh "hidden" ( active = false ) { }
}
)";

TEST(UsdFile, MeshesComeBack) {
    const TemporaryFolder folder;
    for (const std::optional<int> frame : {std::optional<int>(), std::optional(7), std::optional(-12)})
        for (int mask = 0; mask < 4; ++mask) {
            Mesh mesh = sampleMesh(5000, true, mask & 1);
            if (mask & 2) mesh = withComponents(mesh);
            writeMesh(folder / "a.usda", mesh, {.frame = frame});
            expectSame(withoutNormals(readMesh(folder / "a.usda")), mesh);
        }
    Mesh mesh = sampleMesh(10, false, false);
    writeMesh(folder / "a.usda", mesh);
    EXPECT_EQ(readMesh(folder / "a.usda").velocity, std::vector<Vec3>(10, Vec3(0, 0, 0)));
}

TEST(UsdFile, ParticlesComeBack) { expectParticlesComeBack("a.usda"); }

TEST(UsdFile, EveryFloatComesBack) {
    const TemporaryFolder folder;
    Particles particles;
    Attribute values{"values", 1, {}, {}};
    for (const float x : {0.0F, -0.0F, 0x1.5c87fap-84F, 1e-45F, 3.4028235e38F, 1.17549435e-38F, 0.1F, 16777216.0F,
                          kInfinity, -kInfinity})
        values.real.push_back(x);
    std::uint32_t bits = 12345;
    for (int i = 0; i < 100000; ++i) {
        bits = bits * 1664525 + 1013904223;
        const auto x = std::bit_cast<float>(bits);
        if (std::isfinite(x)) values.real.push_back(x);
    }
    for (const float x : values.real) particles.position.push_back(std::isfinite(x) ? Vec3f(x, -x, 1) : Vec3f(0));
    particles.attributes = {values};
    writeParticles(folder / "a.usda", particles);
    const Particles back = readParticles(folder / "a.usda");
    ASSERT_EQ(back.size(), particles.size());
    for (std::size_t i = 0; i < particles.size(); ++i) {
        ASSERT_EQ(std::bit_cast<std::uint32_t>(back.attributes[0].real[i]),
                  std::bit_cast<std::uint32_t>(values.real[i]));
        ASSERT_EQ(back.position[i], particles.position[i]);
    }
    // Rounded to a double first, 7.038531e-26 becomes the float above it.
    EXPECT_NE(contentsOf(folder / "a.usda").find("7.038530691851209e-26"), std::string::npos);
}

TEST(UsdFile, AttributesHaveTheNamesOfUsd) {
    const TemporaryFolder folder;
    Particles p = sampleParticles(3, true, true, false);
    const std::vector<float> nine{1, 2, 3, 4, 5, 6, 7, 8, 9};
    p.attributes = {{"N", 3, nine, {}},           {"accel", 3, nine, {}},       {"Cd", 3, nine, {}},
                    {"pscale", 1, {1, 2, 3}, {}}, {"a.b", 1, {1, 2, 3}, {}},    {"a_b", 1, {1, 2, 3}, {}},
                    {"2d", 1, {}, {4, 5, 6}},     {"indices", 1, {}, {4, 5, 6}}};
    writeParticles(folder / "a.usda", p, {.frames_per_second = 30, .frame = 12, .meters_per_unit = 0.01});
    const std::string text = contentsOf(folder / "a.usda");
    for (const char* part :
         {"normal3f[] normals", "vector3f[] accelerations", "color3f[] primvars:displayColor", "12: [2, 4, 6]",
          "float[] primvars:a_b (", "float[] primvars:a_b_2 (", "displayName = \"a.b\"", "int[] primvars:_2d (",
          "int[] primvars:indices_ (", "int64[] ids", "vector3f[] velocities", "startTimeCode = 12", "endTimeCode = 12",
          "timeCodesPerSecond = 30", "framesPerSecond = 30", "metersPerUnit = 0.01", "upAxis = \"Y\"",
          "defaultPrim = \"geometry\""})
        EXPECT_NE(text.find(part), std::string::npos) << part;
    Particles back = readParticles(folder / "a.usda");
    const auto byName = [](const Attribute& a, const Attribute& b) { return a.name < b.name; };
    std::sort(back.attributes.begin(), back.attributes.end(), byName);
    std::sort(p.attributes.begin(), p.attributes.end(), byName);
    expectSame(back, p);
    writeParticles(folder / "z.usda", p, {.up_axis = UpAxis::z});
    EXPECT_NE(contentsOf(folder / "z.usda").find("upAxis = \"Z\""), std::string::npos);
    EXPECT_EQ(contentsOf(folder / "z.usda").find("startTimeCode"), std::string::npos);
    p.id[1] = static_cast<std::uint64_t>(-5);
    writeParticles(folder / "n.usda", p);
    EXPECT_NE(contentsOf(folder / "n.usda").find(", -5, "), std::string::npos);
    EXPECT_EQ(readParticles(folder / "n.usda").id, p.id);
}

TEST(UsdFile, OnlyAttributesThatAreNoIdentifiersGetOtherNames) {
    const TemporaryFolder folder;
    const std::vector<std::string> names{"a-b", "a_b", "component", "component_2", "displayColor"};
    Particles p = sampleParticles(3, true, true, false);
    for (const std::string& name : names) p.attributes.push_back({name, 1, {1, 2, 3}, {}});
    writeParticles(folder / "a.usda", p);
    const std::string text = contentsOf(folder / "a.usda");
    EXPECT_NE(text.find("primvars:a_b_2 (\n            displayName = \"a-b\""), std::string::npos);
    EXPECT_NE(text.find("primvars:a_b (\n            interpolation"), std::string::npos);
    EXPECT_NE(text.find("primvars:component_3 (\n            displayName = \"component\""), std::string::npos);
    EXPECT_EQ(renamingsIn("a.usda", FileKind::particles, names),
              "'a-b' is written as 'a_b_2', 'component' is written as 'component_3' (that name is not free), "
              "'displayColor' is written as 'displayColor_2' (that name is not free)");
    expectSame(readParticles(folder / "a.usda"), p);
}

TEST(UsdFile, EmptyFramesDeclareAttributes) {
    const TemporaryFolder folder;
    Mesh mesh = withComponents({});
    mesh.attributes.push_back({"Cd", 3, {}, {}});
    writeMesh(folder / "a.usda", mesh, {.frame = 3});
    const std::string text = contentsOf(folder / "a.usda");
    for (const char* part : {"point3f[] points\n", "vector3f[] velocities\n", "displayColor", "primvars:component",
                             "3: [],", "3: [(3.4028235e+38, "})
        EXPECT_NE(text.find(part), std::string::npos) << part;
    EXPECT_EQ(readMesh(folder / "a.usda").triangles.size(), 0U);
    writeParticles(folder / "b.usda", {});
    EXPECT_EQ(readParticles(folder / "b.usda").size(), 0U);
}

TEST(UsdFile, ReadsMeshesOfOtherPrograms) {
    const FileContents contents = parsed(kQuads);
    EXPECT_EQ(contents.kind(), FileKind::mesh);
    EXPECT_TRUE(contents.has_double_positions);
    const Mesh mesh = meshFrom(contents, "a.usda");
    EXPECT_EQ(mesh.position, (std::vector<Vec3>{{10, 0, 0}, {12, 0, 0}, {12, 3, 0}, {10, 3, 0}}));
    EXPECT_EQ(mesh.velocity, (std::vector<Vec3>(4, Vec3(2, 0, 0))));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{3, 2, 1}, {3, 1, 0}, {2, 1, 0}}));
    EXPECT_EQ(contents.grids.size(), 1U);
    EXPECT_EQ(contents.passed_over,
              (std::vector<std::string>{"/world/inner/quads.primvars:st (faceVarying interpolation)",
                                        "/world/inner/quads.note (string)"}));
}

TEST(UsdFile, UnitsThatAreNotAppliedAreListedAsNotRead) {
    const TemporaryFolder folder;
    const std::string up = "upAxis = \"Z\"", note = up + " (--up-axis z, input.up_axis, turns it to y)",
                      unit = "metersPerUnit = 0.01";
    write(folder / "a.usda", "#usda 1.0\n(" + up + " " + unit + ")\n" + withPoints("string note = \"a\"\n").substr(10));
    const std::vector<std::string> not_read{note, unit, "/p.note (string)"};
    EXPECT_EQ(inspectFile(folder / "a.usda").passed_over, not_read);
    ParticleInput input;
    for (const char* use : {"", "position"}) {
        std::vector<std::string> others;
        for (const InputPart& part : readSummarised(folder / "a.usda", input).summary.parts) {
            if (part.kind != InputPart::Kind::other) continue;
            others.push_back(part.name);
            EXPECT_EQ(part.use, part.name == note ? use : "");
        }
        EXPECT_EQ(others, not_read);
        input.up_axis = UpAxis::z;
    }
    EXPECT_EQ(convertFile(folder / "a.usda", folder / "b.usda", {}).warnings,
              std::vector<std::string>{"not read: /p.note (string)"});
}

TEST(UsdFile, ReadsPointsOfOtherPrograms) {
    ReadOptions options;
    const FileContents one =
        parsed(withPoints("float[] widths = [0.5] ( interpolation = \"constant\" )\n"
                          "custom float[] density = [7, 8]\nint64[] ids = [1, 9007199254740993]\n"
                          "half3[] primvars:h = [(1, 2, 3), (4, 5, 6)] ( interpolation = "
                          "\"varying\" )\ntoken visibility = \"inherited\"\n"));
    EXPECT_EQ(one.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(one.id, (std::vector<std::uint64_t>{1, 9007199254740993}));
    ASSERT_EQ(one.attributes.size(), 3U);
    EXPECT_EQ(one.attributes[0].name, "pscale");
    EXPECT_EQ(one.attributes[0].real, (std::vector<float>{0.25F, 0.25F}));
    EXPECT_EQ(one.attributes[1].real, (std::vector<float>{7, 8}));
    EXPECT_EQ(one.attributes[2].components, 3U);
    EXPECT_TRUE(one.passed_over.empty());
    const std::string matrix =
        "uniform token[] xformOpOrder = [\"xformOp:transform\"]\nnormal3f[] normals = [(0, 0, 1), (0, 1, 0)]\n"
        "float[] widths = [1, 2]\nvector3f[] velocities = [(1, 0, 0), (0, 1, 0)]\n"
        "matrix4d xformOp:transform = ( (0, 2, 0, 0), (-2, 0, 0, 0), (0, 0, 2, 0), (1, 0, 0, 1) )\n";
    const Particles turned = particlesFrom(parsed(withPoints(matrix)), {}, "a");
    EXPECT_EQ(turned.position, (std::vector<Vec3f>{{-3, 2, 6}, {-9, 8, 12}}));
    EXPECT_EQ(turned.velocity, (std::vector<Vec3f>{{0, 2, 0}, {-2, 0, 0}}));
    EXPECT_EQ(turned.attributes[0].real, (std::vector<float>{0, 0, 1, -1, 0, 0}));
    EXPECT_EQ(turned.attributes[1].real, (std::vector<float>{1, 2}));
}

TEST(UsdFile, PrimsAreChosenLikeGrids) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.usda";
    writeFile(file,
              "#usda 1.0\ndef Xform \"w\" {\ndef Points \"water\" { point3f[] points = [(1, 1, 1)] }\n"
              "def Points \"foam\" { point3f[] points = [(2, 2, 2)] } }\n"
              "def Mesh \"floor\" { point3f[] points = [(3, 3, 3)]\nint[] faceVertexCounts = []\n"
              "int[] faceVertexIndices = [] }\n");
    const auto found = readSummarised(file, {});
    EXPECT_EQ(found.particles.position, (std::vector<Vec3f>{Vec3f(1), Vec3f(2)}));
    ASSERT_EQ(found.summary.parts.size(), 4U);  // three prims and P
    EXPECT_EQ(found.summary.parts[0].name, "/w/water");
    EXPECT_EQ(found.summary.parts[0].use, "position");
    EXPECT_EQ(found.summary.parts[2].use, "");
    ParticleInput input;
    for (const auto& [name, x] : {std::pair("/w/foam", 2.0F), std::pair("water", 1.0F), std::pair("/floor", 3.0F)}) {
        input.grid = {name};
        EXPECT_EQ(readParticles(file, input).position, std::vector<Vec3f>{Vec3f(x)});
    }
    input.grid = {"spray"};
    expectError([&] { readParticles(file, input); }, {"no prim 'spray'", "/w/water (Points)", "/floor (Mesh)"});
    EXPECT_EQ(readMesh(file).position.size(), 1U);
}

TEST(UsdFile, APrimWithoutVelocityLeavesThoseOfOthersAlone) {
    const std::string water =
        "def Points \"water\" { point3f[] points = [(1, 1, 1), (2, 2, 2)]\n"
        "vector3f[] velocities = [(1, 2, 3), (4, 5, 6)]\nfloat[] primvars:temp = [7, 8] ( interpolation = \"vertex\" "
        ")\n"
        "int64[] ids = [1, 2] }\n";
    const std::string foam = "def Points \"foam\" { point3f[] points = [(9, 9, 9)] }\n";
    const std::string empty = "def Points \"spray\" { point3f[] points = [] }\n";
    const std::vector<Vec3f> of_water{{1, 2, 3}, {4, 5, 6}};
    for (const bool foam_first : {false, true}) {
        SCOPED_TRACE(foam_first);
        const FileContents contents = parsed("#usda 1.0\n" + (foam_first ? foam + water : water + foam) + empty);
        ASSERT_EQ(contents.warnings.size(), 1U);
        EXPECT_EQ(contents.warnings[0], "/foam has no velocities, unlike /water: zero is taken for them");
        EXPECT_EQ(contents.passed_over, (std::vector<std::string>{"/water.temp (/foam does not have it)",
                                                                  "/water.id (/foam does not have it)"}));
        EXPECT_TRUE(contents.id.empty());
        const Particles particles = particlesFrom(contents, {}, "a.usda");
        std::vector<Vec3f> expected = of_water;
        expected.insert(foam_first ? expected.begin() : expected.end(), Vec3f(0, 0, 0));
        EXPECT_EQ(particles.velocity, expected);
        EXPECT_TRUE(particles.attributes.empty());
    }
    // Nothing is lost or said because of prims without points, wherever they stand.
    for (const std::string& text : {empty + water, water + empty}) {
        const FileContents contents = parsed("#usda 1.0\n" + text);
        EXPECT_TRUE(contents.warnings.empty() && contents.passed_over.empty());
        EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{1, 2}));
        const Particles particles = particlesFrom(contents, {}, "a.usda");
        EXPECT_EQ(particles.velocity, of_water);
        EXPECT_EQ(particles.attributes.size(), 1U);
    }
    // Meshes alike.
    const std::string faces = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n";
    const std::string corners = "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n";
    const FileContents meshes =
        parsed("#usda 1.0\ndef Mesh \"a\" {" + corners + faces + "}\ndef Mesh \"b\" {" + corners + faces +
               "vector3f[] velocities = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n}\n");
    EXPECT_EQ(meshes.warnings.size(), 1U);
    EXPECT_EQ(meshes.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
    const Mesh mesh = meshFrom(meshes, "a.usda");
    ASSERT_EQ(mesh.velocity.size(), 6U);
    EXPECT_EQ(mesh.velocity[0], Vec3(0, 0, 0));
    EXPECT_EQ(mesh.velocity[5], Vec3(3, 0, 0));
}

TEST(UsdFile, TakesTheFrameInTheNameOrTheEarliestSample) {
    const TemporaryFolder folder;
    const std::string text =
        "#usda 1.0\ndef Points \"p\" {\npoint3f[] points.timeSamples = { 12: [(12, 0, 0)], -3: [(-3, 0, 0)], 7: [(7, "
        "0, 0)] }\nvector3f[] velocities.timeSamples = { 6: [(6, 0, 0)], 8: None, }\n}\n";
    for (const auto& [name, x, v] :
         {std::tuple("a.0012.usda", 12, 0), std::tuple("a.-003.usda", -3, 6), std::tuple("a.0007.usda", 7, 6),
          std::tuple("a.0008.usda", -3, 6), std::tuple("a.usda", -3, 6)}) {
        writeFile(folder / name, text);
        const Particles particles = readParticles(folder / name);
        EXPECT_EQ(particles.position, std::vector<Vec3f>{Vec3f(static_cast<float>(x), 0, 0)}) << name;
        EXPECT_EQ(particles.velocity.empty(), v == 0) << name;
        if (v != 0) {
            EXPECT_EQ(particles.velocity[0].x, static_cast<float>(v));
        }
    }
}

TEST(UsdFile, TakesTheSampleThatHoldsAtTheFrameThatIsAskedFor) {
    const std::string text =
        "#usda 1.0\ndef Xform \"x\" {\ndouble3 xformOp:translate.timeSamples = { 2: (0, 2, 0), 5: (0, 5, 0) }\n"
        "uniform token[] xformOpOrder = [\"xformOp:translate\"]\ndef Points \"p\" {\n"
        "point3f[] points.timeSamples = { 5: [(5, 0, 0)], 1.5: [(1.5, 0, 0)] }\n} }\n";
    const Bytes bytes = bytesOf(text);
    EXPECT_EQ(usdaSampleTimes({bytes, "a.usda"}), (std::vector<double>{1.5, 2, 5}));
    ReadOptions options;
    for (const auto& [frame, x] : {std::pair(2, 1.5F), std::pair(5, 5.0F)}) {
        options.frame = frame;
        for (const char* name : {"a.usda", "a.0005.usda", "a_v005.usda"}) {
            const FileContents contents = parseUsda({bytes, name}, options);
            EXPECT_EQ(contents.position, std::vector<Vec3f>{Vec3f(x, static_cast<float>(frame), 0)}) << name;
            EXPECT_EQ(contents.passed_over.empty(), frame == 5) << name;  // 2 is no sample of the points
        }
    }
    expectError([&] { parseUsda({bytes, "a_v005.usda"}); }, {"is animated, and has no sample at 1.5"});
    EXPECT_TRUE(usdaSampleTimes({bytesOf(withPoints("")), "a.usda"}).empty());
}

TEST(UsdFile, TheContentsOfAUsdFileTellWhetherItIsText) {
    const TemporaryFolder folder;
    const Particles particles = sampleParticles(3, true, true, false);
    writeParticles(folder / "a.usda", particles);
    writeFile(folder / "a.usd", contentsOf(folder / "a.usda"));
    expectSame(readParticles(folder / "a.usd"), particles);
    EXPECT_EQ(inspectFile(folder / "a.usd").points, 3U);
    writeFile(folder / "b.usd", "PXR-USDC");
    for (const auto& read :
         {std::function([&] { readParticles(folder / "b.usd"); }), std::function([&] { readMesh(folder / "b.usd"); }),
          std::function([&] { inspectFile(folder / "b.usd"); })})
        expectError(read, {"b.usd: contains binary USD, which cannot be read", "usdcat"});
    expectError([&] { writeMesh(folder / "c.usd", {}); }, {"Binary USD is not written", "usdcat a.usda -o a.usdc"});
}

TEST(UsdFile, IndexedPrimvarsAreLeftOut) {
    const FileContents contents = parsed(
        withPoints("float[] primvars:a = [1, 2, 3]\nint[] primvars:a:indices = [2, 0]\nfloat[] primvars:b = [4, 5]\n"));
    ASSERT_EQ(contents.attributes.size(), 1U);
    EXPECT_EQ(contents.attributes[0].name, "b");
    ASSERT_EQ(contents.passed_over.size(), 1U);
    EXPECT_NE(contents.passed_over[0].find("primvars:a (the primvar is indexed)"), std::string::npos);
}

TEST(UsdFile, DamageIsNamedByLineOrAttribute) {
    const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
        SCOPED_TRACE(text);
        expectError([&] { meshFrom(parsed(text), "a.usda"); }, parts);
    };
    refused("#usda 2.0\n", {"a.usda: line 1", "#usda 1.0"});
    refused("#usda 1.0\n\ndef Points \"p\" {\n", {"line 4", "'}' is missing"});
    refused("#usda 1.0\nbox\n", {"line 2", "'box' is not def"});
    refused(withPoints("string s = \"abc\n"), {"line 4", "a string does not end"});
    refused(withPoints("float[] a = [1, 2\n"), {"line 5", "missing before '}'"});
    refused(withPoints("float[] a\nint[] a\n"), {"line 5", "'a' is declared with two types"});
    refused(withPoints("float[] a.timeSamples = { x: 1 }\n"), {"line 4", "time of a sample"});
    refused(withPoints("float[] primvars:a = [1, 2, 3]\n"), {"/p.primvars:a has 3 numbers", "2 points"});
    refused(withPoints("float[] primvars:a = [1, (2)]\n"), {"/p.primvars:a", "no number", "after 1 numbers"});
    refused(withPoints("vector3f[] velocities = [(1, 2), (3, 4, 5)]\n"), {"velocities", "tuples of 3"});
    refused("#usda 1.0\ndef Camera \"c\" {}\n", {"no prim of type Points or Mesh", "no geometry"});
    refused("#usda 1.0\ndef BasisCurves \"c\" {}\n", {"/c (BasisCurves)"});
    refused("#usda 1.0\ndef Points \"c\" {}\n", {"/c: the prim has no points"});
    std::string deep = "#usda 1.0\n";
    for (int i = 0; i < 100000; ++i) deep += "def \"a\" {";
    refused(deep, {"prims are nested more than 100 deep"});
    refused("#usda 1.0\ndef \"a\" ( x = " + std::string(100000, '['), {"brackets are nested more than 100 deep"});
    std::string many = "";
    for (int i = 0; i < 2000; ++i) many += "int a" + std::to_string(i) + "\n";
    refused(withPoints(many), {"more than 1000 attributes"});
    const auto faces = [](const std::string& counts, const std::string& indices) {
        return "#usda 1.0\ndef Mesh \"m\" {\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
               "int[] faceVertexCounts = [" +
               counts + "]\nint[] faceVertexIndices = [" + indices + "]\n}\n";
    };
    refused(faces("3", "0, 1, 3"), {"/m: face 0 has point 3", "only 3 points"});
    refused(faces("3", "0, 1"), {"face 0 has 3 corners", "only 2"});
    refused(faces("2000000000", "0, 1, 2"), {"face 0 has 2000000000 corners"});
    refused(faces("-1", "0, 1, 2"), {"face 0 has -1 corners"});
    refused(faces("3", "0, 1, 2, 2"), {"1 faceVertexIndices belong to no face"});
}

TEST(UsdFile, WhatNeedsCompositionIsRefused) {
    const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
        SCOPED_TRACE(text);
        expectError([&] { parsed(text); }, parts);
    };
    refused("#usda 1.0\n( subLayers = [@a.usda@] )\n", {"line 2", "sublayers", "usdcat --flatten"});
    for (const char* arc : {"prepend references = @a.usda@</p>", "payload = @@@a.usda@@@", "inherits = </c>",
                            "specializes = </c>", "prepend variantSets = \"s\""})
        refused(withPoints("", "( " + std::string(arc) + " )"), {"line 2", "usdcat --flatten"});
    refused(withPoints("variantSet \"s\" = { \"a\" { } }\n"), {"variants", "usdcat --flatten"});
    refused(withPoints("", "( clips = { dictionary default = { string s = \"\" } } )"), {"value clips", "assetPaths"});
    for (const char* operation : {"xformOp:rotateX", "!invert!xformOp:translate"})
        refused(withPoints("float xformOp:rotateX = 3\nuniform token[] xformOpOrder = [\"" + std::string(operation) +
                           "\"]\n"),
                {"/p: the transform " + std::string(operation), "Only translations, scales and matrices"});
    refused(withPoints("double3 xformOp:translate.timeSamples = { 1: (1, 1, 1), 2: (2, 2, 2) }\n"
                       "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"),
            {"is animated"});
    // Prims that are not read may be composed.
    EXPECT_EQ(parsed(withPoints("") + "over \"x\" ( references = @a.usda@ ) { variantSet \"s\" = { \"a\" { } } }\n")
                  .position.size(),
              2U);
    const TemporaryFolder folder;
    writeFile(folder / "a.usdc", "PXR-USDC");
    expectError([&] { readMesh(folder / "a.usdc"); }, {"Binary USD is not read", "usdcat"});
    expectError([&] { writeMesh(folder / "b.usdc", {}); }, {"Binary USD is not written", "usdcat a.usda -o a.usdc"});
    writeFile(folder / "a.usda", "PXR-USDC");
    expectError([&] { readMesh(folder / "a.usda"); }, {"contains binary USD", "usdcat"});
}

TEST(UsdFile, AClipsLayerListsTheFilesOnDisk) {
    const TemporaryFolder folder;
    const auto file = [&](int frame, const std::string& name) { return ClipFile{frame, "./" + name, folder / name}; };
    Mesh mesh = sampleMesh(10, true, false);
    writeMesh(folder / "a.-003.usda", mesh, {.frame = -3});
    mesh.attributes.push_back({"T", 1, std::vector<float>(10, 1.0F), {}});
    writeMesh(folder / "a.0002.usda", mesh, {.frame = 2});
    writeMesh(folder / "a.123456.usda", mesh, {.frame = 123456});
    writeMesh(folder / "a.0004.usda", mesh);  // has no time samples
    writeParticles(folder / "a.0005.usda", sampleParticles(3, true, true, false), {.frame = 5});
    writeFile(folder / "a.0006.usda", "#usda 1.0\ndef Mesh \"m\" {}\n");
    const std::vector<ClipFile> files{file(-3, "a.-003.usda"),      file(2, "a.0002.usda"), file(4, "a.0004.usda"),
                                      file(5, "a.0005.usda"),       file(6, "a.0006.usda"), file(7, "a.0007.usda"),
                                      file(123456, "a.123456.usda")};
    const std::string text = usdClipsLayer(files, "./a.usda", {.frames_per_second = 25});
    for (const char* part :
         {"active = [(-3, 0), (2, 1), (123456, 2)]", "[@./a.-003.usda@, @./a.0002.usda@, @./a.123456.usda@]",
          "times = [(-3, -3), (2, -3), (2, 2), (123456, 2), (123456, 123456)]", "startTimeCode = -3",
          "endTimeCode = 123456", "timeCodesPerSecond = 25", "manifestAssetPath = @./a.usda@", "point3f[] points\n",
          "float[] primvars:T (\n            interpolation = \"vertex\"\n        )\n"})
        EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
    EXPECT_EQ(text.find(".timeSamples"), std::string::npos);
    writeFile(folder / "a.usda", text);
    EXPECT_TRUE(isUsdClipsLayer(folder / "a.usda"));
    EXPECT_FALSE(isUsdClipsLayer(folder / "a.0002.usda"));
    EXPECT_FALSE(isUsdClipsLayer(folder / "b.usda"));
    expectError([&] { readMesh(folder / "a.usda"); }, {"line ", "value clips"});
    EXPECT_EQ(usdClipsLayer({file(4, "a.0004.usda")}, "./a.usda", {}), "");
    EXPECT_EQ(usdClipsLayer({}, "./a.usda", {}), "");
    EXPECT_NE(usdClipsLayer({{2, "./@/a.usda", folder / "a.0002.usda"}}, "./a.usda", {}).find("@@@./@/a.usda@@@"),
              std::string::npos);
}

TEST(UsdFile, LayersDeclareAnAttributeOnceThoughItsTypeChanges) {
    const TemporaryFolder folder;
    Mesh mesh = sampleMesh(10, true, false);
    const Attribute whole{"age", 1, {}, std::vector<std::int32_t>(10, 1)},
        real{"age", 1, std::vector<float>(10, .5F), {}};
    std::vector<ClipFile> files;
    for (const Attribute& age : {whole, real, whole}) {
        const int frame = static_cast<int>(files.size());
        const std::string name = "a.000" + std::to_string(frame) + ".usda";
        mesh.attributes = {age};
        writeMesh(folder / name, mesh, {.frame = frame});
        files.push_back({frame, "./" + name, folder / name});
    }
    const auto count = [](const std::string& text, const std::string& part) {
        std::size_t found = 0;
        for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
        return found;
    };
    const std::string text = usdClipsLayer(files, "./a.usda", {});
    EXPECT_EQ(text.find("int[] primvars:age"), std::string::npos) << text;
    EXPECT_EQ(count(text, "float[] primvars:age"), 1U) << text;
    EXPECT_EQ(count(text, "uniform "), count(usdClipsLayer({files[0]}, "./a.usda", {}), "uniform ")) << text;
}

}  // namespace
}  // namespace betamesh
