#include "io/houdini_geo.h"
#include "io/houdini_json.h"
#include "io/houdini_json_writer.h"
#include "io/houdini_scf.h"
#include "support/file_checks.h"
#include "support/file_samples.h"

#include <cmath>
#include <limits>

namespace betamesh {

namespace {

using namespace std::string_literals;

const std::filesystem::path kFiles = std::filesystem::path(BETAMESH_SHARED) / "data/formats";

FileContents parse(std::span<const std::byte> bytes, const ReadOptions& options = {}) {
    return parseHoudini({bytes, "t.bgeo"}, options);
}
FileContents parse(const std::string& bytes, const ReadOptions& options = {}) {
    return parse(std::as_bytes(std::span(bytes)), options);
}

template <typename Geometry>
Bytes encoded(const Geometry& geometry) {
    return bytesOf([&](ByteWriter& out) { encodeBgeoJson(out, geometry, "t.bgeo"); });
}

/// In pieces of no round size.
Bytes scf(std::span<const std::byte> plain) {
    Bytes packed;
    ScfWriter writer(
        [&](std::span<const std::byte> piece) { packed.insert(packed.end(), piece.begin(), piece.end()); });
    while (!plain.empty()) {
        const std::size_t count = std::min<std::size_t>(plain.size(), 300007);
        writer.write(plain.first(count));
        plain = plain.subspan(count);
    }
    writer.finish();
    return packed;
}

Bytes unscf(std::span<const std::byte> packed) {
    Cursor in = scfUnpacked({packed, "t.bgeo.sc"});
    Bytes plain;
    while (!in.peek(1).empty()) {
        const auto piece = std::as_bytes(std::span(in.peek(1)));
        plain.insert(plain.end(), piece.begin(), piece.end());
        in.take(piece.size(), "content");
    }
    return plain;
}

Particles readParticles(std::span<const std::byte> bytes) { return particlesFrom(parse(bytes), {}, "t.bgeo"); }
Mesh readMesh(std::span<const std::byte> bytes) {
    ReadOptions options;
    options.id.clear();
    return meshFrom(parse(bytes, options), "t.bgeo");
}

template <typename T>
std::vector<std::uint8_t> bitsOf(const std::vector<T>& rows) {
    const auto bytes = std::as_bytes(std::span(rows));
    std::vector<std::uint8_t> bits(bytes.size());
    std::transform(bytes.begin(), bytes.end(), bits.begin(),
                   [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
    return bits;
}

/// A point attribute as text; values: what follows its storage.
std::string attribute(const std::string& name, int size, const std::string& storage, const std::string& values) {
    return R"([["scope","public","type","numeric","name",")" + name + R"(","options",{}],["size",)" +
           std::to_string(size) + R"(,"storage",")" + storage + R"(","values",["size",)" + std::to_string(size) +
           R"(,"storage",")" + storage + "\"," + values + "]]]";
}

/// Points on the x axis, at 0, 1, …; sections: what follows the attributes.
std::string geometry(std::size_t points, const std::string& attributes = "", const std::string& sections = "",
                     const std::string& topology = "") {
    std::string positions;
    for (std::size_t i = 0; i < points; ++i) positions += (i > 0 ? "," : "") + std::to_string(i) + ",0,0.5";
    return R"(["fileversion","18.5.351","pointcount",)" + std::to_string(points) +
           R"(,"vertexcount",0,"primitivecount",3,"topology",["pointref",["indices",[)" + topology +
           R"(]]],"attributes",["pointattributes",[)" +
           attribute("P", 3, "fpreal32", R"("pagesize",1024,"rawpagedata",[)" + positions + "]") +
           (attributes.empty() ? "" : "," + attributes) + "]]" + (sections.empty() ? "" : "," + sections) + "]";
}

}  // namespace

TEST(HoudiniFile, ParticlesComeBackAsTheyWere) {
    for (const std::size_t n : {1U, 2U, 1000U, 5000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            const Particles particles = sampleParticles(n, mask & 1, mask & 2, mask & 4);
            const Bytes bytes = encoded(particles);
            EXPECT_EQ(bytes, encoded(particles));
            expectSame(readParticles(bytes), particles);
            expectSame(readParticles(scf(bytes)), particles);
            expectSame(readParticles(gzip(bytes)), particles);
        }
}

TEST(HoudiniFile, AwkwardNumbersComeBackBitForBit) {
    using Float = std::numeric_limits<float>;
    Particles p;
    p.position = {
        {0.0F, -0.0F, Float::denorm_min()}, {-Float::denorm_min(), Float::min(), -Float::max()}, {1e-40F, 0.1F, 3.0F}};
    p.velocity = {{Float::max(), Float::epsilon(), -0.0F}, {0, 1, 2}, {-1e-45F, 16777217.0F, 0.3F}};
    p.id = {(std::uint64_t{1} << 53) + 1, std::numeric_limits<std::uint64_t>::max(), std::uint64_t{1} << 63};
    Attribute real{"limits", 1, {Float::infinity(), -Float::infinity(), -0.0F}, {}};
    Attribute whole{
        "whole", 1, {}, {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max(), -1}};
    p.attributes = {real, whole};
    for (const Bytes& bytes : {encoded(p), scf(encoded(p))}) {
        const Particles read = readParticles(bytes);
        EXPECT_EQ(bitsOf(read.position), bitsOf(p.position));
        EXPECT_EQ(bitsOf(read.velocity), bitsOf(p.velocity));
        EXPECT_EQ(read.id, p.id);
        EXPECT_EQ(bitsOf(read.attributes.at(0).real), bitsOf(real.real));
        EXPECT_EQ(read.attributes.at(1).integer, whole.integer);
    }
}

TEST(HoudiniFile, ManyAttributesComeBack) {
    Particles p = sampleParticles(20, true, true, false);
    for (int i = 0; i < 300; ++i) {
        Attribute a{"a" + std::to_string(i), 1, {}, {}};
        a.real.assign(20, static_cast<float>(i));
        p.attributes.push_back(a);
    }
    expectSame(readParticles(encoded(p)), p);
}

TEST(HoudiniFile, MeshesAndComponentsComeBackAsTheyWere) {
    for (const std::size_t n : {1U, 3U, 4U, 300U, 70000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(n);
            Mesh mesh = sampleMesh(n, mask & 1, mask & 2);
            if (mask & 4) mesh = withComponents(mesh);
            const Bytes bytes = encoded(mesh);
            if (mesh.velocity.empty()) mesh.velocity.resize(n, Vec3(0, 0, 0));
            expectSame(readMesh(bytes), mesh);
            if (mask == 7) expectSame(readMesh(scf(bytes)), mesh);
        }
    EXPECT_TRUE(readMesh(encoded(withComponents({}))).component);
}

TEST(HoudiniFile, CurvesComeBackAsTheyWere) {
    Curves curves;
    for (int i = 0; i < 7; ++i) curves.position.emplace_back(i, 0.5 * i, 0);
    curves.velocity.assign(7, Vec3(1, 2, 3));
    curves.edges = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 6}};
    const FileContents contents = parse(encoded(curves));
    EXPECT_TRUE(contents.declares_edges);
    EXPECT_FALSE(contents.declares_faces);
    const Curves read = curvesFrom(contents, "t.bgeo");
    EXPECT_EQ(read.edges, curves.edges);
    EXPECT_EQ(read.position, curves.position);
    EXPECT_EQ(read.velocity, curves.velocity);
}

TEST(HoudiniFile, EmptyFilesDeclareWhatTheirNeighboursDo) {
    Particles p;
    p.attributes = {{"density", 1, {}, {}}};
    const FileContents contents = parse(encoded(p));
    EXPECT_EQ(contents.position.size(), 0U);
    ASSERT_EQ(contents.declared.size(), 4U);
    EXPECT_EQ(contents.declared[0].name, "P");
    EXPECT_EQ(contents.declared[1].name, "v");
    EXPECT_EQ(contents.declared[2].name, "id");
    EXPECT_EQ(contents.declared[2].type, "int32");
    EXPECT_EQ(contents.declared[3].name, "density");
    EXPECT_EQ(readParticles(scf(encoded(p))).size(), 0U);
    EXPECT_EQ(readMesh(encoded(Mesh())).position.size(), 0U);
}

TEST(HoudiniFile, PointGroupsAreAttributesOfOnesAndZeros) {
    const std::string group = R"([["name","foam","type","point"],["selection",["defaults",["size",1,"storage","int64",
                              "values",[0]],"unordered",["boolRLE",[1,false,3,true]]]]],
                              [["name","spray"],["selection",["unordered",["i8",[1,0,0,1]]]]],
                              [["name","mist"],["selection",["ordered",[2,1]]]])";
    Particles p = particlesFrom(parse(geometry(4, "", "\"pointgroups\",[" + group + "]")), {}, "t.geo");
    ASSERT_EQ(p.attributes.size(), 3U);
    EXPECT_EQ(p.attributes[0].name, "group:foam");
    EXPECT_EQ(p.attributes[0].integer, (std::vector<std::int32_t>{0, 1, 1, 1}));
    EXPECT_EQ(p.attributes[1].integer, (std::vector<std::int32_t>{1, 0, 0, 1}));
    EXPECT_EQ(p.attributes[2].integer, (std::vector<std::int32_t>{0, 1, 1, 0}));
    expectSame(readParticles(encoded(p)), p);
    const Bytes bytes = encoded(p);
    EXPECT_NE(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find("pointgroups"),
              std::string::npos);
}

TEST(HoudiniFile, ReadsPagesWithPackingAndConstantFlags) {
    // Five rows in pages of two: x and y are packed together, z alone and constant in the second and third page.
    const std::string values = R"("pagesize",2,"packing",[2,1],"constantpageflags",[[],[false,true,true]],
        "rawpagedata",[1,2, 3,4, 10,11,  5,6, 7,8, 12,  9,0, 13])";
    const FileContents contents = parse(geometry(5, attribute("a", 3, "int32", values)));
    EXPECT_EQ(contents.attributes.at(0).integer,
              (std::vector<std::int32_t>{1, 2, 10, 3, 4, 11, 5, 6, 12, 7, 8, 12, 9, 0, 13}));
    const FileContents one = parse(geometry(
        3, attribute("c", 2, "fpreal64", R"("pagesize",1024,"constantpageflags",[[true]],"rawpagedata",[7.5,8])")));
    EXPECT_EQ(one.attributes.at(0).real, (std::vector<float>{7.5F, 8, 7.5F, 8, 7.5F, 8}));
    EXPECT_EQ(one.declared.at(1).type, "fpreal64");
}

TEST(HoudiniFile, ReadsTuplesArraysAndWideIntegers) {
    const FileContents contents =
        parse(geometry(2, attribute("t", 2, "fpreal32", R"("tuples",[[1,2e0],[3.5,-4]])") + "," +
                              attribute("a", 2, "int8", R"("arrays",[[1,2],[3,4]])") + "," +
                              attribute("id", 1, "int64", R"("arrays",[[9007199254740993,-1]])") + "," +
                              attribute("big", 1, "int64", R"("arrays",[[4294967296,1]])")));
    EXPECT_EQ(contents.attributes.at(0).real, (std::vector<float>{1, 2, 3.5F, -4}));
    EXPECT_EQ(contents.attributes.at(1).integer, (std::vector<std::int32_t>{1, 3, 2, 4}));
    EXPECT_EQ(contents.attributes.at(2).real, (std::vector<float>{4294967296.0F, 1}));
    EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{9007199254740993U, std::numeric_limits<std::uint64_t>::max()}));
    EXPECT_EQ(contents.format, "houdini json text");
}

TEST(HoudiniFile, TextAttributesAndForeignSectionsArePassedOver) {
    const std::string strings =
        R"([["type","string","name","s"],["size",1,"storage","int32","strings",["a\"\u00e9\ud83d\ude00","b"],
        "indices",["size",1,"storage","int32","arrays",[[0,1]]]]])";
    const FileContents contents = parse(
        geometry(2, strings, R"("info",{"nested":[[[null,true,{"a":-1.5e-3}]]]},"sharedprimitivedata",[],"index",[])"));
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{0, 0, 0.5F}, {1, 0, 0.5F}}));
    EXPECT_TRUE(contents.attributes.empty());
    EXPECT_EQ(contents.declared.at(1).type, "string");
}

TEST(HoudiniFile, ReadsEveryTokenInBothByteOrders) {
    for (const bool big : {false, true}) {
        SCOPED_TRACE(big ? "big-endian" : "little-endian");
        const auto bytes = [&](std::uint64_t number, int size) {
            std::string text;
            for (int i = 0; i < size; ++i) text += static_cast<char>(number >> 8 * (big ? size - 1 - i : i));
            return text;
        };
        std::string document = big ? "\x7f"s + "bJSN[" : "\x7f"s + "NSJb[";
        document += "\x2b\x05\x01k"s + "\x26\x05"s + "\x11\xfe"s + "\x12" + bytes(0xfffd, 2) + "\x13" +
                    bytes(0x10000, 4) + "\x14" + bytes(std::uint64_t{1} << 40, 8) + "\x21\xff"s + "\x22" +
                    bytes(0xffff, 2) + "\x18" + bytes(0x3c00, 2) + "\x18" + bytes(0x8001, 2) + "\x19" +
                    bytes(0xc0200000, 4) + "\x1a" + bytes(0x3fe0000000000000, 8) + "\x30\x31\x10\x02\x27\x02no"s +
                    "\x2d\x05"s + "\x40\x10\x21"s + bytes(0x80000001, 4) + bytes(1, 4) +   // 33 booleans
                    "\x40\x27\x02\x01x\xf2"s + bytes(1, 2) + "y" +                         // two texts
                    "\x40\x18\xf4"s + bytes(2, 4) + bytes(0x7c00, 2) + bytes(0x3555, 2) +  // two halves
                    "\x40\x12\xf8"s + bytes(1, 8) + bytes(7, 2) + "\x7b\x27\x01z\x5b\x5d\x7d\0]"s;
        HoudiniJsonReader json(Cursor(std::as_bytes(std::span(document)), "t"));
        std::vector<std::string> texts;
        std::vector<std::int64_t> integers;
        std::vector<float> reals;
        int booleans = 0, nulls = 0;
        int element = 0;
        const auto takeReals = [&](std::span<const float> more) {
            reals.insert(reals.end(), more.begin(), more.end());
        };
        json.forElements("all", [&] {
            switch (element++) {
                case 6:
                case 7:
                case 8:
                case 9:
                case 10:  // single reals have no reader of their own
                    ASSERT_EQ(json.kind(),
                              element <= 7 ? HoudiniJsonReader::Kind::integer : HoudiniJsonReader::Kind::real);
                    return json.skip();
                case 15:
                    return json.forElements("booleans", [&] { booleans += json.boolean("b"); });
                case 16:
                    return json.forElements("texts", [&] { texts.push_back(json.text("t")); });
                case 17:
                case 18:
                    return json.forNumbers<float>("numbers", takeReals);
                default:
                    break;
            }
            switch (json.kind()) {
                case HoudiniJsonReader::Kind::text:
                    texts.push_back(json.text("t"));
                    break;
                case HoudiniJsonReader::Kind::integer:
                    integers.push_back(json.integer("i"));
                    break;
                case HoudiniJsonReader::Kind::boolean:
                    booleans += json.boolean("b");
                    break;
                case HoudiniJsonReader::Kind::null:
                    ++nulls;
                    json.skip();
                    break;
                default:
                    json.skip();
            }
        });
        EXPECT_EQ(texts, (std::vector<std::string>{"k", "no", "x", "y"}));
        EXPECT_EQ(integers, (std::vector<std::int64_t>{-2, -3, 65536, std::int64_t{1} << 40, 255}));
        EXPECT_EQ(booleans, 5);
        EXPECT_EQ(nulls, 1);
        ASSERT_EQ(reals.size(), 3U);
        EXPECT_TRUE(std::isinf(reals[0]));
        EXPECT_NEAR(reals[1], 1.0F / 3, 1e-3);
        EXPECT_EQ(reals[2], 7);
    }
}

TEST(HoudiniFile, HalfNumbersAreExact) {
    const std::string document = "\x7fNSJb\x40\x18\x06\x01\x3c\x01\x80\xff\x7b\0\x80\xff\x03\0\x04"s;
    HoudiniJsonReader json(Cursor(std::as_bytes(std::span(document)), "t"));
    std::vector<float> reals;
    json.forNumbers<float>("halves", [&](std::span<const float> more) { reals.assign(more.begin(), more.end()); });
    EXPECT_EQ(reals, (std::vector<float>{1.0F + 1.0F / 1024, -std::ldexp(1.0F, -24), 65504, -0.0F,
                                         1023 * std::ldexp(1.0F, -24), std::ldexp(1.0F, -14)}));
    EXPECT_TRUE(std::signbit(reals[3]));
}

TEST(HoudiniFile, ReadsPolygonsOfEveryKind) {
    const std::string primitives = R"("primitives",[
        [["type","p_r"],["s_v",0,"n_p",2,"r_v",[3,1,4,1]]],
        [["type","Polygon_run"],["startvertex",1,"nprimitives",1,"nvertices",[3]]],
        [["type","c_r"],["s_v",4,"n_p",1,"n_v",[3]]],
        [["type","Poly"],["vertex",[6,5,4],"closed",true]],
        [["type","run","runtype","Poly","varyingfields",["vertex"],"uniformfields",{"closed":false}],[[[0,1]],[[1,2]]]],
        [["type","Part"],["vertex",[0,1]]]])";
    const FileContents contents = parse(geometry(4, "", primitives, "0,1,2, 0,1,2,3"));
    EXPECT_EQ(contents.triangles, (std::vector<Triangle>{{0, 2, 1}, {0, 3, 2}, {0, 2, 1}, {1, 0, 2}, {3, 1, 2}}));
    EXPECT_EQ(contents.edges, (std::vector<Edge>{{1, 2}, {2, 3}, {0, 1}, {1, 2}}));
    ReadOptions points_only;
    points_only.faces = false;
    EXPECT_TRUE(parse(geometry(4, "", primitives, "0,1,2, 0,1,2,3"), points_only).triangles.empty());
}

TEST(HoudiniFile, ReadsTheComponentOfEachPolygon) {
    std::string document = geometry(
        4, "", R"("primitives",[[["type","p_r"],["s_v",0,"n_p",2,"n_v",[4,0]]],[["type","Poly"],["vertex",[0,1,2]]]])",
        "0,1,2,3");
    const std::string component =
        R"(,"primitiveattributes",[)" + attribute("component", 1, "int32", R"("arrays",[[5,6,7]])") + "]";
    const std::size_t end = document.find("]]]]],\"primitives\"");
    ASSERT_NE(end, std::string::npos);
    document.insert(end + 4, component);
    EXPECT_EQ(parse(document).component, (std::vector<std::int32_t>{5, 5, 7}));
}

TEST(HoudiniFile, PointsThatPlaceVolumesAreNoParticles) {
    const std::string volumes =
        R"("primitives",[[["type","Volume"],["vertex",0,"res",[1,1,1]]],[["type","VDB"],["vertex",1]]])";
    ReadOptions options;
    options.faces = false;
    const FileContents contents = parse(geometry(4, "", volumes, "1,3"), options);
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{0, 0, 0.5F}, {2, 0, 0.5F}}));
    expectError([&] { parse(geometry(4, "", volumes, "1,3")); }, {"primitive 0", "Volume", "polygons"});
}

TEST(HoudiniFile, PackedPrimitivesAreRefusedByName) {
    const std::string packed = R"("primitives",[[["type","PackedFragment"],["vertex",0]]])";
    ReadOptions options;
    options.faces = false;
    expectError([&] { parse(geometry(1, "", packed, "0"), options); }, {"t.bgeo", "PackedFragment", "Unpack"});
    options.skip_unknown_faces = true;
    EXPECT_EQ(parse(geometry(1, "", packed, "0"), options).position.size(), 1U);
}

TEST(HoudiniFile, ErrorsNameFileByteAndExpectation) {
    expectError([] { parse("nonsense"); }, {"t.bgeo", "BgeoV"});
    expectError([] { parse("PGEOMETRY V5"); }, {"t.bgeo", "classic", "text"});
    expectError([] { parse("[\"pointcount\""); }, {"t.bgeo", "byte 13", "ends"});
    expectError([] { parse("[]"); }, {"no pointcount"});
    expectError([] { parse(R"(["pointcount",3])"); }, {"'P'", "3 points"});
    expectError([] { parse(R"(["pointcount",-1])"); }, {"pointcount is -1"});
    expectError([] { parse(R"(["pointcount",1e3])"); }, {"pointcount is a real number"});
    expectError([] { parse(R"(["pointcount",1,"pointcount",2])"); }, {"twice"});
    expectError([] { parse(R"(["pointcount",99999999999])"); }, {"99999999999"});
    expectError([] { parse(R"(["a"}])"); }, {"end of an array or map"});
    expectError([] { parse(R"(["a",wrong])"); }, {"'wrong'"});
    expectError([] { parse("[\"a\"," + std::string(300, '[')); }, {"200"});
    expectError([] { parse("\x7fNSJb[\x26\x01"s); }, {"string 1", "defined"});
    expectError([] { parse("\x7fNSJb[\x99"s); }, {"0x99", "token"});
    expectError([] { parse("\x7fNSJb[\x27\x01x\x40\x13\xf8\xff\xff\xff\xff\xff\xff\xff\x7f"s); },
                {"array of numbers", "truncated"});
    expectError([] { parse("\x7fNSJb[\x27\x01x\x40\x13\xf8\xff\xff\xff\xff\xff\xff\xff\xff"s); }, {"length", "-1"});
    expectError([] { parse("\x7fNSJb[\x27\xf8\xff\xff\xff\xff\xff\xff\xff\x7f"s); }, {"text", "truncated"});
    expectError([] { parse("\x7fNSJb[\x27\xf3"s); }, {"0xf3"});
    expectError([] { parse("\x7fNSJb[\x27\x01x\x40\x5b\x01"s); }, {"0x5b"});
    const auto ofA = [](int size, const std::string& storage, const std::string& values) {
        return [=] { parse(geometry(2, attribute("a", size, storage, values))); };
    };
    expectError(ofA(1, "int32", R"("rawpagedata",[1])"), {"'a'", "1 numbers", "2 rows"});
    expectError(ofA(1, "int32", R"("rawpagedata",[1,2,3])"), {"'a'", "more numbers"});
    expectError(ofA(1, "int32", R"("rawpagedata",[1,2.5])"), {"2.5", "integer"});
    expectError(ofA(1, "int32", R"("rawpagedata",[1,4294967296])"), {"4294967296", "32 bits"});
    expectError(ofA(2, "int32", R"("packing",[1,2],"rawpagedata",[1,2])"), {"packing", "size 2"});
    expectError(ofA(1, "int32", R"("pagesize",0,"rawpagedata",[1,2])"), {"pages of 0 rows"});
    expectError(ofA(1, "int32", R"("constantpageflags",[[true,true]],"rawpagedata",[1,2])"),
                {"constantpageflags", "expected 1"});
    expectError(ofA(2, "int32", R"("tuples",[[1,2],[3]])"), {"tuple of 1"});
    expectError(ofA(2, "int32", R"("arrays",[[1,2]])"), {"fewer arrays"});
    expectError(ofA(1, "int32", R"("rawpagedata",[1,2],"size",2)"), {"before"});
    const auto withPrimitives = [](const std::string& primitives) {
        return [=] { parse(geometry(3, "", "\"primitives\",[" + primitives + "]", "0,1,2")); };
    };
    expectError(withPrimitives(R"([["type","p_r"],["s_v",0,"n_p",2,"r_v",[3,2]]])"), {"2 polygons", "3"});
    expectError(withPrimitives(R"([["type","p_r"],["s_v",0,"n_p",2,"r_v",[3,1]]])"), {"1 polygons", "expected 2"});
    expectError(withPrimitives(R"([["type","p_r"],["s_v",0,"n_p",1,"r_v",[3]]])"), {"pairs"});
    expectError(withPrimitives(R"([["type","Poly"],["vertex",[0,1,3]]])"), {"vertex of a polygon is 3"});
    expectError(withPrimitives(R"([["type","Sphere"],["vertex",0]])"), {"Sphere"});
    expectError([] { parse(geometry(1, "", "", "1")); }, {"point of a vertex is 1"});
    expectError(
        [] {
            parse(
                geometry(2, "", R"("pointgroups",[[["name","g"],["selection",["unordered",["boolRLE",[3,true]]]]]])"));
        },
        {"'g'", "3 members"});
}

TEST(HoudiniFile, WritersRefuseWhatTheFormatCannotHold) {
    Particles p = sampleParticles(2, true, true, false);
    p.attributes = {{"P", 1, {1, 2}, {}}};
    expectError([&] { encoded(p); }, {"'P'", "in use"});
    p.attributes = {{"a", 1, {1}, {}}};
    expectError([&] { encoded(p); }, {"'a'", "1 rows"});
    Mesh mesh = sampleMesh(3, true, false);
    mesh.triangles = {{0, 1, 3}};
    expectError([&] { encoded(mesh); }, {"vertex 3"});
}

TEST(HoudiniScf, BlocksComeBackWhateverThePiecesTheyAreMadeOf) {
    for (const std::size_t size : {0U, 1U, 1048576U, 1048577U, 20000000U}) {
        SCOPED_TRACE(size);
        Bytes plain(size);
        for (std::size_t i = 0; i < size; ++i) plain[i] = static_cast<std::byte>(i * i / 977 % 251);
        const Bytes packed = scf(plain);
        EXPECT_TRUE(unscf(packed) == plain);
        Bytes again;
        ScfWriter writer(
            [&](std::span<const std::byte> piece) { again.insert(again.end(), piece.begin(), piece.end()); });
        writer.write(plain);
        writer.finish();
        EXPECT_TRUE(again == packed);
    }
}

TEST(HoudiniScf, DamageIsReported) {
    Bytes plain(3000000);
    for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = static_cast<std::byte>(i * i / 977 % 251);
    const Bytes packed = scf(plain);
    const auto damaged = [&](std::size_t at, std::uint8_t value) {
        Bytes bytes = packed;
        bytes[at] = std::byte{value};
        return [bytes] { unscf(bytes); };
    };
    const auto cut = [&](std::size_t size) {
        return [bytes = Bytes(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size))] { unscf(bytes); };
    };
    expectError(damaged(12, 9), {"t.bgeo.sc", "block 0", "damaged"});
    expectError(damaged(12 + 7, 0x7f), {"block 0"});
    expectError(damaged(12 + 12, 1), {"block 0"});
    expectError(damaged(packed.size() - 1, 'x'), {"1fcs"});
    expectError(damaged(packed.size() - 5, 9), {"size of the table", "expected 32"});
    expectError(damaged(packed.size() - 13, 9), {"size of the last block"});
    expectError(damaged(packed.size() - 29, 9), {"offset of a block"});
    expectError(cut(packed.size() - 3), {"1fcs"});
    expectError(cut(packed.size() / 2), {"t.bgeo.sc"});
    expectError(cut(20), {"block"});
    expectError([] { parse(std::span<const std::byte>(scf(bytesOf("nothing of ours")))); }, {"Houdini's JSON"});
}

TEST(HoudiniFile, RealFilesOfHoudini) {
    if (!std::filesystem::exists(kFiles)) GTEST_SKIP() << "no real files in " << kFiles;
    struct Expected {
        const char* file;
        std::size_t points, triangles, attributes;
        std::array<float, 6> bounds;  // info.bounds of the file: lower and upper of each axis
    };
    const std::array<float, 6> ten{-1.07095671F, 0.342897117F,  -0.549226701F,
                                   0.245002538F, -0.611521006F, 0.349550486F};
    for (const Expected& e :
         {Expected{"chunleili__h21_default.bgeo", 16, 24, 1, {-0.5F, 0.5F, -0.5F, 0.5F, -0.5F, 0.5F}},
          Expected{"gamedev__calculate_occlusion.1.bgeo.sc", 2766, 5330, 1, {-5, 5, 0, 2.0999999F, -5, 5}},
          Expected{"gamedev__delete_small_parts.1.bgeo.sc",
                   464,
                   696,
                   1,
                   {-1.07281184F, 1.03564429F, -1.04028654F, 1.0692209F, -1.07229745F, 1.07349312F}},
          Expected{"houio__test_box.bgeo", 8, 12, 0, {-0.5F, 0.5F, -0.5F, 0.5F, -0.5F, 0.5F}},
          Expected{"laika__empty_16_5.bgeo", 0, 0, 0, {}}, Expected{"laika__points_noprim_16_5.bgeo", 10, 0, 1, ten},
          Expected{"laika__points_noprim_16_5.geo", 10, 0, 1, ten},
          Expected{"laika__points_partsys_16.bgeo", 10, 0, 1, ten},
          Expected{"laika__simple_partanim.0017.bgeo",
                   10,
                   0,
                   12,
                   {-12.0477552F, 18.6682453F, -1.0234859F, 11.7645292F, -8.97026157F, 14.9641275F}}}) {
        SCOPED_TRACE(e.file);
        const FileContents contents = parseHoudini(openFile(kFiles / e.file));
        EXPECT_EQ(contents.position.size(), e.points);
        EXPECT_EQ(contents.triangles.size(), e.triangles);
        EXPECT_EQ(contents.attributes.size(), e.attributes);
        for (int axis = 0; axis < 3 && e.points > 0; ++axis) {
            const auto less = [&](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; };
            const auto [lower, upper] = std::minmax_element(contents.position.begin(), contents.position.end(), less);
            EXPECT_EQ((*lower)[axis], e.bounds[2 * static_cast<std::size_t>(axis)]);
            EXPECT_EQ((*upper)[axis], e.bounds[2 * static_cast<std::size_t>(axis) + 1]);
        }
    }
    const FileContents binary = parseHoudini(openFile(kFiles / "laika__points_noprim_16_5.bgeo"));
    const FileContents text = parseHoudini(openFile(kFiles / "laika__points_noprim_16_5.geo"));
    EXPECT_EQ(binary.position, text.position);
    EXPECT_EQ(binary.attributes.at(0).real, text.attributes.at(0).real);
    EXPECT_EQ(binary.position[0], Vec3f(-1.0709567070007324F, 0.24500253796577454F, 0.04586875066161156F));
    const FileContents animated = parseHoudini(openFile(kFiles / "laika__simple_partanim.0017.bgeo"));
    EXPECT_EQ(animated.id, (std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(animated.attributes.back().name, "group:stream_source_first_input");
    EXPECT_EQ(particlesFrom(animated, {}, "f").velocity.at(0),
              Vec3f(5.419951438903809F, -1.1178148984909058F, 5.419951438903809F));
    expectError([] { parseHoudini(openFile(kFiles / "laika__packed_points_simple_16_5.bgeo")); }, {"PackedGeometry"});
}

TEST(HoudiniFile, RealFilesOfTheClassicFormatAreToldByTheirContent) {
    if (!std::filesystem::exists(kFiles)) GTEST_SKIP() << "no real files in " << kFiles;
    EXPECT_EQ(parseHoudini(openFile(kFiles / "partio__base.bgeo")).format, "bgeo V5");
    EXPECT_EQ(parseHoudini(openFile(kFiles / "splish__sphere.bgeo")).format, "bgeo V5, gzip");
    EXPECT_EQ(parseHoudini(openFile(kFiles / "splish__sphere.bgeo")).position.size(), 12394U);
    expectError([] { parseHoudini(openFile(kFiles / "partio__test.geo")); }, {"classic", "text"});
}

}  // namespace betamesh
