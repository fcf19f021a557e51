// Damaged files of every format. A reader must return a valid result or throw Error, and must not allocate more memory
// than the file's size justifies. The random seed is printed; trial i of a seed is always the same.

#include "io/alembic.h"
#include "io/bgeo.h"
#include "io/houdini_geo.h"
#include "io/houdini_scf.h"
#include "io/obj.h"
#include "io/output_file.h"
#include "io/ply.h"
#include "io/prt.h"
#include "io/table.h"
#include "io/usd.h"
#include "io/vdb.h"
#include "io/vtk.h"
#include "support/alembic_archive.h"
#include "support/file_checks.h"
#include "support/file_samples.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <map>
#include <new>
#include <random>

namespace {

// Largest single allocation that operator new grants; larger ones fail as if memory were exhausted.
std::atomic<std::size_t> allowed_bytes{SIZE_MAX};
std::atomic<std::size_t> refused{0};

}  // namespace

// noinline, so that the compiler does not warn about a visible malloc and a delete that it cannot see.
[[gnu::noinline]] void* operator new(std::size_t size) {
    if (size > allowed_bytes.load(std::memory_order_relaxed)) {
        ++refused;
        throw std::bad_alloc();
    }
    if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return size > allowed_bytes.load(std::memory_order_relaxed) ? nullptr : std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace betamesh {

namespace {

using Random = std::mt19937_64;

/// Numbers that are likely to break readers: negative, at limits, off by one.
constexpr std::array<std::uint32_t, 14> kAwkward{
    0, 1, 2, 3, 0x7f, 0xff, 0x7fff, 0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff, 0x00ffffff};

std::size_t below(Random& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

void overwrite(Bytes& bytes, std::size_t at, std::uint32_t number, std::size_t size, bool big) {
    for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i)
        bytes[at + i] = static_cast<std::byte>(number >> 8 * (big ? size - 1 - i : i));
}

/// The file with one to four random changes.
Bytes mutated(const Bytes& seed, Random& random) {
    static const std::array<std::string, 8> kWords{"-1",  "99999999999999999999", "nan",  "1e999",
                                                   "inf", "4294967296",           "list", "0x7"};
    Bytes bytes = seed;
    for (std::size_t changes = 1 + below(random, 4); changes > 0 && !bytes.empty(); --changes) {
        // Half of them near the start, where the counts are stored.
        const std::size_t range = below(random, 2) == 0 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size();
        const std::size_t at = below(random, range);
        const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        switch (below(random, 8)) {
            case 0:
                bytes[at] ^= static_cast<std::byte>(1U << below(random, 8));
                break;
            case 1:
                bytes[at] = static_cast<std::byte>(random());
                break;
            case 2:
                bytes.resize(at);
                break;
            case 3:
                bytes.erase(here, here + static_cast<std::ptrdiff_t>(below(random, bytes.size() - at) % 64));
                break;
            case 4: {  // inserts a copy of another part of the file
                const std::size_t from = below(random, bytes.size());
                const std::size_t length = std::min(below(random, 200), bytes.size() - from);
                const Bytes part(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                                 bytes.begin() + static_cast<std::ptrdiff_t>(from + length));
                bytes.insert(here, part.begin(), part.end());
                break;
            }
            case 5:
            case 6:
                overwrite(bytes, at, kAwkward[below(random, kAwkward.size())], std::size_t{1} << below(random, 3),
                          below(random, 2) == 0);
                break;
            default: {
                const Bytes word = bytesOf(kWords[below(random, kWords.size())]);
                bytes.insert(here, word.begin(), word.end());
            }
        }
    }
    return bytes;
}

struct Reader {
    std::string name;
    std::function<void(const Bytes&)> read;
};

Particles readAsParticles(const FileContents& contents) { return particlesFrom(contents, {}, "fuzz"); }

const Reader kPly{"ply", [](const Bytes& bytes) {
                      ReadOptions options;
                      const FileContents contents = parsePly({bytes, "fuzz"}, options);
                      for (const Triangle& t : contents.triangles)
                          for (const std::uint32_t corner : t) ASSERT_LT(corner, contents.position.size());
                      validate(readAsParticles(contents));
                      meshFrom(contents, "fuzz");
                  }};
const Reader kBgeo{"bgeo", [](const Bytes& bytes) {
                       const FileContents contents = parseBgeo({bytes, "fuzz"});
                       for (const Triangle& t : contents.triangles)
                           for (const std::uint32_t corner : t) ASSERT_LT(corner, contents.position.size());
                       validate(readAsParticles(contents));
                       meshFrom(contents, "fuzz");
                   }};
const Reader kHoudini{"houdini", [](const Bytes& bytes) {
                          ReadOptions points_only;
                          points_only.faces = false;
                          points_only.skip_unknown_faces = true;
                          std::optional<Error> failure;
                          try {
                              validate(readAsParticles(parseHoudini({bytes, "fuzz"}, points_only)));
                          } catch (const Error& error) {
                              failure = error;
                          }
                          const FileContents contents = parseHoudini({bytes, "fuzz"});
                          for (const Triangle& t : contents.triangles)
                              for (const std::uint32_t corner : t) ASSERT_LT(corner, contents.position.size());
                          for (const Edge& e : contents.edges)
                              for (const std::uint32_t corner : e) ASSERT_LT(corner, contents.position.size());
                          if (failure) throw *failure;
                          meshFrom(contents, "fuzz");
                          curvesFrom(contents, "fuzz");
                      }};
const Reader kObj{"obj", [](const Bytes& bytes) { meshFrom(parseObj(bytes, "fuzz"), "fuzz"); }};

/// Points, triangles and edges of a reader that has all of the file at once.
Reader reader(const std::string& name, FileContents (*parse)(Cursor, const ReadOptions&)) {
    return {name, [parse](const Bytes& bytes) {
                const FileContents contents = parse({bytes, "fuzz"}, {});
                for (const Triangle& t : contents.triangles)
                    for (const std::uint32_t corner : t) ASSERT_LT(corner, contents.position.size());
                validate(readAsParticles(contents));
                meshFrom(contents, "fuzz");
            }};
}

/// A number from the environment, by which long runs are configured.
std::uint64_t fromEnvironment(const char* name, std::uint64_t fallback) {
    const char* text = std::getenv(name);
    return text == nullptr ? fallback : std::stoull(text);
}

struct Tally {
    std::size_t valid = 0;
    std::size_t errors = 0;
};

/// Reads one damaged file; anything but a result or an Error fails the test.
void attempt(const Reader& reader, const Bytes& bytes, std::size_t allowed, Tally& tally) {
    const std::size_t refused_before = refused;
    allowed_bytes = allowed;
    try {
        reader.read(bytes);
        ++tally.valid;
    } catch (const Error&) {
        ++tally.errors;
    } catch (const std::exception& error) {
        allowed_bytes = SIZE_MAX;
        ADD_FAILURE() << reader.name << ": " << error.what();
    }
    allowed_bytes = SIZE_MAX;
    EXPECT_EQ(refused, refused_before) << reader.name << " asked for more than " << allowed << " bytes at once";
}

void fuzz(const Reader& reader, const Bytes& seed, std::size_t trials) {
    const std::uint64_t first = fromEnvironment("BETAMESH_FUZZ_SEED", 20240607);
    // A byte of the file becomes at most a triangle (12 bytes) or a 64-bit integer (8) in a vector that doubles as it
    // grows. 2 MiB are for buffers and messages, whose size does not depend on the file.
    const std::size_t allowed = 40 * seed.size() + (std::size_t{2} << 20);
    Tally tally;
    attempt(reader, seed, allowed, tally);
    ASSERT_EQ(tally.valid, 1U) << "the seed itself must be valid";

    // Overwrites every position near the start, and so every count.
    for (std::size_t at = 0; at < std::min<std::size_t>(seed.size(), 300); ++at)
        for (const std::uint32_t number : kAwkward)
            for (const bool big : {false, true}) {
                Bytes bytes = seed;
                overwrite(bytes, at, number, 4, big);
                attempt(reader, bytes, allowed, tally);
            }
    // Truncates the file at up to 600 lengths.
    for (std::size_t length = 0; length < seed.size(); length += 1 + seed.size() / 600)
        attempt(reader, Bytes(seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>(length)), allowed, tally);

    for (std::size_t trial = 0; trial < trials && !testing::Test::HasFailure(); ++trial) {
        SCOPED_TRACE("seed " + std::to_string(first) + ", trial " + std::to_string(trial));
        Random random(first + trial);
        attempt(reader, mutated(seed, random), allowed, tally);
    }
    testing::Test::RecordProperty(reader.name + "_valid", static_cast<int>(tally.valid));
    testing::Test::RecordProperty(reader.name + "_errors", static_cast<int>(tally.errors));
    std::printf("%s: %zu valid, %zu errors\n", reader.name.c_str(), tally.valid, tally.errors);
}

const std::size_t kTrials = fromEnvironment("BETAMESH_FUZZ_TRIALS", 20000);

}  // namespace

// Points and faces are read one after the other, as the commands of the program do.
const Reader kAlembic{"alembic", [](const Bytes& bytes) {
                          ReadOptions points_only;
                          points_only.faces = false;
                          std::optional<Error> failure;
                          try {
                              validate(readAsParticles(parseAbc(bytes, "fuzz", points_only)));
                          } catch (const Error& error) {
                              failure = error;
                          }
                          ReadOptions summary;
                          summary.summary = true;
                          const FileContents contents = parseAbc(bytes, "fuzz", summary);
                          for (const Triangle& t : contents.triangles)
                              for (const std::uint32_t corner : t) ASSERT_LT(corner, contents.position.size());
                          if (failure) throw *failure;
                          meshFrom(contents, "fuzz");
                      }};

TEST(ReaderFuzz, PlyBinary) {
    fuzz(kPly, bytesOf([](ByteWriter& out) { encodePly(out, sampleParticles(40, true, true, true), ""); }), kTrials);
    fuzz(kPly, bytesOf([](ByteWriter& out) { encodePly(out, withComponents(sampleMesh(40, true, true)), ""); }),
         kTrials);
    fuzz(kPly,
         bytesOf(raw("ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty uchar y\n"
                     "property list uchar ushort tags\nproperty double z\nproperty double id\nelement face 2\n"
                     "property list short int vertex_index\nelement edge 1\nproperty int vertex1\nend_header\n"
                     "\0\1\2\2\0\7\0\7\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
                     "\0\1\2\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
                     "\0\1\2\1\0\7\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
                     "\0\3\0\0\0\0\0\0\0\1\0\0\0\2\0\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\0\0\0\0\1")),
         kTrials);
}

TEST(ReaderFuzz, PlyAscii) {
    fuzz(kPly,
         bytesOf("ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty double y\n"
                 "property float z\nproperty float vx\nproperty float vy\nproperty float vz\nproperty int id\n"
                 "property uchar red\nproperty list uchar int tags\nelement face 2\n"
                 "property list uchar int vertex_indices\nend_header\n"
                 "0 0 0 1 2 3 7 255 2 1 2\n1 0 0 1.5 -2e-3 3 8 0 0\n1 1 0 1 2 3 9 1 1 5\n0 1 0 1 2 3 10 2 0\n"
                 "3 0 1 2\n4 0 1 2 3\n"),
         kTrials);
}

TEST(ReaderFuzz, Bgeo) {
    fuzz(kBgeo, bytesOf([](ByteWriter& out) { encodeBgeo(out, sampleParticles(40, true, true, true), ""); }), kTrials);
    const Bytes mesh =
        bytesOf([](ByteWriter& out) { encodeBgeo(out, withComponents(sampleMesh(40, true, true)), ""); });
    fuzz(kBgeo, mesh, kTrials);
    fuzz(kBgeo, gzip(mesh), kTrials / 10);
}

TEST(ReaderFuzz, BgeoWithStringsVertexAttributesAndAParticleSystem) {
    fuzz(kBgeo,
         bytesOf(raw("BgeoV\0\0\0\5\0\0\0\3\0\0\0\2\0\0\0\0\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0\1\0\0\0\0"
                     "\0\4name\0\1\0\0\0\4\0\0\0\2\0\1a\0\2bc"
                     "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
                     "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\1"
                     "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\1"
                     "\0\2uv\0\1\0\0\0\0\0\0\0\0"
                     "\0\1k\0\1\0\0\0\1\0\0\0\0"
                     "\377\377\377\377\0\1\0\0\0\1\0\0\0\3<\0\0\0\0\0\0\0\1\0\0\0\0\0\2\0\0\0\0\0\0\0\7"
                     "\0\0\200\0\0\0\0\2\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0\7\0\377")),
         kTrials);
}

Bytes scf(std::span<const std::byte> plain) {
    Bytes packed;
    ScfWriter writer(
        [&](std::span<const std::byte> piece) { packed.insert(packed.end(), piece.begin(), piece.end()); });
    writer.write(plain);
    writer.finish();
    return packed;
}

TEST(ReaderFuzz, Houdini) {
    fuzz(kHoudini, bytesOf([](ByteWriter& out) { encodeBgeoJson(out, sampleParticles(40, true, true, true), ""); }),
         kTrials);
    const Bytes mesh =
        bytesOf([](ByteWriter& out) { encodeBgeoJson(out, withComponents(sampleMesh(40, true, true)), ""); });
    fuzz(kHoudini, mesh, kTrials);
    fuzz(kHoudini, scf(mesh), kTrials);
    fuzz(kHoudini, gzip(mesh), kTrials / 10);
}

TEST(ReaderFuzz, HoudiniText) {
    fuzz(kHoudini, bytesOf(R"(["fileversion","13.0","pointcount",4,"vertexcount",10,"primitivecount",7,
"topology",["pointref",["indices",[0,1,2, 0,1,2,3]]],"attributes",["pointattributes",[
[["type","numeric","name","P"],["size",4,"storage","fpreal32","values",["size",4,"storage","fpreal32","pagesize",2,
"packing",[3,1],"constantpageflags",[[],[true,true]],"rawpagedata",[0,0,0,1,0,0,1, 0,1,0,0,0,1,1]]]],
[["type","numeric","name","id"],["size",1,"storage","int64","values",["arrays",[[1,2,3,9007199254740993]]]]],
[["type","numeric","name","v"],["size",3,"storage","fpreal64","values",["tuples",[[1,2,3],[1,2,3],[1,2,3],[1,2,3]]]]],
[["type","string","name","s"],["size",1,"storage","int32","strings",["\u00e9"],"indices",["arrays",[[0,0,0,0]]]]]],
"primitiveattributes",[[["type","numeric","name","component"],["size",1,"storage","int32","values",
["pagesize",1024,"constantpageflags",[[true]],"rawpagedata",[3]]]]]],
"primitives",[[["type","p_r"],["s_v",0,"n_p",2,"r_v",[3,1,4,1]]],[["type","c_r"],["s_v",4,"n_p",1,"n_v",[3]]],
[["type","Poly"],["vertex",[6,5,4],"closed",true]],[["type","run","runtype","Poly","varyingfields",["vertex"],
"uniformfields",{"closed":false}],[[[0,1]],[[1,2]]]],[["type","Part"],["vertex",[0,1]]]],
"pointgroups",[[["name","g"],["selection",["unordered",["boolRLE",[1,false,3,true]]]]],
[["name","h"],["selection",["unordered",["i8",[1,0,0,1]]]]],[["name","o"],["selection",["ordered",[2,1]]]]]])"),
         kTrials);
}

// Strings that are defined once, old runs of polygons, pages with constant parts, arrays of booleans.
TEST(ReaderFuzz, HoudiniFilesOfHoudini) {
    const std::filesystem::path folder = std::filesystem::path(BETAMESH_SHARED) / "data/formats";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real files in " << folder;
    for (const char* name : {"chunleili__h21_default.bgeo", "houio__test_box.bgeo", "laika__points_partsys_16.bgeo",
                             "laika__simple_partanim.0017.bgeo", "gamedev__delete_small_parts.1.bgeo.sc"})
        fuzz(kHoudini, readWholeFile(folder / name), kTrials);
}

TEST(ReaderFuzz, Obj) {
    fuzz(kObj, bytesOf([](ByteWriter& out) { encodeObj(out, withComponents(sampleMesh(30, false, false)), ""); }),
         kTrials);
    fuzz(kObj, bytesOf("v 0 0 0\nv 1 0 0 1 1 1\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1/1 2//1 3 4\nf -4 -3 -2\nl 1 2 3\n"),
         kTrials);
}

TEST(ReaderFuzz, VtkXml) {
    const Reader xml = reader("vtk xml", parseVtkXml);
    fuzz(xml, bytesOf([](ByteWriter& out) { encodeVtp(out, sampleParticles(40, true, true, true), ""); }), kTrials);
    fuzz(xml, bytesOf([](ByteWriter& out) { encodeVtp(out, withComponents(sampleMesh(40, true, true)), ""); }),
         kTrials);
    const std::string points =
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"%><UnstructuredGrid><Piece NumberOfPoints=\"2\">"
        "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"binary\">$</DataArray></Points><Cells>"
        "<DataArray type=\"Int8\" Name=\"connectivity\" format=\"ascii\">0 1 0</DataArray><DataArray type=\"UInt8\" "
        "Name=\"offsets\" format=\"ascii\">3</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5"
        "</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
    const auto with = [&](const std::string& head, const std::string& data) {
        std::string text = points;
        text.replace(text.find('%'), 1, head);
        text.replace(text.find('$'), 1, data);
        return bytesOf(text);
    };
    fuzz(xml, with("", "GAAAAAAAAAAAAIA/AAAAQAAAQEAAAIBAAACgQA=="), kTrials);
}

TEST(ReaderFuzz, VtkLegacy) {
    const Reader legacy = reader("vtk legacy", parseVtk);
    fuzz(legacy,
         bytesOf("# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
                 "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\nPOINT_DATA 3\n"
                 "SCALARS d double 1\nLOOKUP_TABLE t\n1 2 3\nVECTORS v float\n1 2 3 4 5 6 7 8 9\n"
                 "FIELD f 1\nid 1 3 int\n5 6 7\n"),
         kTrials);
    fuzz(legacy,
         bytesOf("# vtk DataFile Version 4.1\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n" +
                 std::string(36, '\1') + "\nCELLS 1 4\n" + raw("\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2") +
                 "\nCELL_TYPES 1\n" + raw("\0\0\0\5") + "\nPOINT_DATA 3\nSCALARS id unsigned_int 1\nLOOKUP_TABLE d\n" +
                 std::string(12, '\1') + "\nFIELD F 1\nv 3 3 float\n" + std::string(36, '\1') + "\n"),
         kTrials);
}

TEST(ReaderFuzz, Alembic) {
    fuzz(kAlembic, bytesOf([](ByteWriter& out) { encodeAbc(out, sampleParticles(40, true, true, true), ""); }),
         kTrials);
    fuzz(kAlembic, bytesOf([](ByteWriter& out) { encodeAbc(out, withComponents(sampleMesh(40, true, true)), ""); }),
         kTrials);
    fuzz(kAlembic, archiveOfManyKinds(), kTrials);
}

TEST(ReaderFuzz, Table) {
    const Reader table = reader("table", parseTable);
    fuzz(table, bytesOf("x,y,z,vx,vy,vz,id,\"a:0\"\n1,2,3,0,0,1,7,1\n4,5,6,0,1,0,8,2\n7,8,9,1,0,0,9,3\n"), kTrials);
    fuzz(table, bytesOf("2\nwater\nO 1 2 3\nH 4 5 6\n"), kTrials);
}

TEST(ReaderFuzz, Usda) {
    const Reader usda = reader("usda", parseUsda);
    const WriteOptions frame{.frame = 7};
    fuzz(usda, bytesOf([&](ByteWriter& out) { encodeUsda(out, sampleParticles(40, true, true, true), "", frame); }),
         kTrials);
    fuzz(usda,
         bytesOf([&](ByteWriter& out) { encodeUsda(out, withComponents(sampleMesh(40, true, true)), "", frame); }),
         kTrials);
    fuzz(usda, bytesOf(R"(#usda 1.0
(upAxis = "Z" metersPerUnit = 0.01)
def Xform "w" (kind = "component") {
double3 xformOp:translate = (1, 2, 3)
matrix4d xformOp:transform:m.timeSamples = { 1: ( (1,0,0,0), (0,2,0,0), (0,0,1,0), (0,0,0,1) ) }
uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate", "xformOp:transform:m"]
def Mesh "a" { int[] faceVertexCounts = [4, 3]; int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 2]
point3d[] points.timeSamples = { 1: [(0,0,0), (1,0,0), (1,1,0), (0,1,0)], 2: None }
uniform token orientation = "leftHanded"
normal3f[] normals = [(0,0,1), (0,0,1), (0,0,1), (0,0,1)] (interpolation = "vertex")
half[] primvars:h = [1, 2, 3, 4] (displayName = "x.y") # comment
rel r = [</w>, </w/a>]
string s = """a"b"""; asset f = @a@
float[] primvars:e = [1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3] (elementSize = 3 interpolation = "vertex") }
def Mesh "b" { point3f[] points = [(0,0,0)]; int[] faceVertexCounts = []; int[] faceVertexIndices = [] }
over "c" (references = @x@) { variantSet "v" = { "x" { } } } }
def Points "p" { point3f[] points = [(1,2,3), (4,5,6)]; float[] widths = [1]; uint64[] ids = [1, 18446744073709551615] }
)"),
         kTrials);
}

TEST(ReaderFuzz, Prt) {
    std::string file = raw("\xc0PRT\r\n\x1a\n\x38\0\0\0") + "Extensible Particle Format" + std::string(6, '\0') +
                       raw("\1\0\0\0\2\0\0\0\0\0\0\0\4\0\0\0\2\0\0\0\x2c\0\0\0");
    const auto channel = [&](std::string name, const std::string& rest) {
        name.resize(32);
        file += name + rest;
    };
    channel("Position", raw("\4\0\0\0\3\0\0\0\0\0\0\0"));
    channel("Density", raw("\3\0\0\0\1\0\0\0\14\0\0\0"));
    const std::string rows(28, '\0');  // a zlib stream that stores them
    file += raw("\x78\1\1\x1c\0\xe3\xff") + rows + raw("\0\x1c\0\1");
    fuzz(reader("prt", parsePrt), bytesOf(file), kTrials);
}

TEST(ReaderFuzz, PrtInChunks) {
    const std::string rows(24, '\1');  // a zlib stream that stores them
    fuzz(reader("prt2", parsePrt),
         bytesOf(raw("\xc0PRT2\r\n\x1a\3\0\0\0Chan\x17\0\0\0\0\0\0\0\1\10Position\13") + "3 * float32" +
                 raw("\14Meta\2\0\0\0\0\0\0\0\0\0Part\x4b\0\0\0\0\0\0\0\0\16transpose-zlib\2\0\0\0\0\0\0\0\1\0\0\0"
                     "\0\0\0\0\x23\0\0\0\2\0\0\0\x78\1\1\x18\0\xe7\xff") +
                 rows + raw("\1\x44\0\x19")),
         kTrials);
}

Reader vdbReader(const std::string& file) {
    return {"vdb", [file](const Bytes& damaged) {
                std::ofstream(file, std::ios::binary)
                    .write(reinterpret_cast<const char*>(damaged.data()), static_cast<std::streamsize>(damaged.size()));
                validate(readAsParticles(readVdb(file)));
            }};
}

// OpenVDB parses the grids and trusts the sizes in them. A file that is cut short is an Error wherever it ends.
TEST(ReaderFuzz, VdbTruncated) {
    const TemporaryFolder folder;
    const std::string bytes = encodeVdb(sampleParticles(300, true, true, true), "");
    Tally tally;
    const Reader reader = vdbReader(folder / "a.vdb");
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 400)
        attempt(reader, bytesOf(std::string_view(bytes).substr(0, length)), std::size_t{1} << 30, tally);
    EXPECT_EQ(tally.valid, 0U);
}

/// How a process ends that reads a damaged file.
enum class End { valid, error, crash, other };

/// A crash includes the reports of sanitizers. A process that takes longer than a minute has not ended.
End endOfReading(const Reader& reader, const Bytes& bytes) {
    constexpr int kValid = 10, kError = 11, kOther = 12;
    const pid_t process = fork();
    if (process == 0) {
        alarm(60);
        allowed_bytes = std::size_t{1} << 30;
        try {
            reader.read(bytes);
            _exit(kValid);
        } catch (const Error&) {
            _exit(kError);
        } catch (...) {
            _exit(kOther);
        }
    }
    int status = 0;
    waitpid(process, &status, 0);
    if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGALRM ? End::other : End::crash;
    if (WEXITSTATUS(status) == kValid) return End::valid;
    if (WEXITSTATUS(status) == kError) return End::error;
    return WEXITSTATUS(status) == kOther ? End::other : End::crash;
}

// OpenVDB writes out of bounds for some damaged files, which ends the process now and then: a job runs in a process
// under supervision for that. What is promised here is that reading ends, and that exceptions are Errors. Only bytes
// are changed, because most other damage is found before OpenVDB reads the file.
TEST(ReaderFuzz, VdbDamaged) {
    constexpr std::size_t kTextsEnd = 2000;  // headers and names; the values of particles follow
    const std::size_t trials = kTrials / 20;
    const std::uint64_t first = fromEnvironment("BETAMESH_FUZZ_SEED", 20240607);
    const TemporaryFolder folder;
    const Bytes seed = bytesOf(encodeVdb(sampleParticles(300, true, true, true), ""));
    const Reader reader = vdbReader(folder / "a.vdb");
    std::map<End, std::size_t> ends;
    for (std::size_t trial = 0; trial < trials && !testing::Test::HasFailure(); ++trial) {
        SCOPED_TRACE("seed " + std::to_string(first) + ", trial " + std::to_string(trial));
        Random random(first + trial);
        Bytes bytes = seed;
        for (std::size_t changes = 1 + below(random, 2); changes > 0; --changes)
            overwrite(
                bytes, below(random, below(random, 2) == 0 ? kTextsEnd : bytes.size()),
                below(random, 2) == 0 ? kAwkward[below(random, kAwkward.size())] : static_cast<std::uint32_t>(random()),
                std::size_t{1} << below(random, 3), false);
        const End end = endOfReading(reader, bytes);
        EXPECT_NE(end, End::other);
        ++ends[end];
    }
    std::printf("vdb: %zu valid, %zu errors, %zu crashes\n", ends[End::valid], ends[End::error], ends[End::crash]);
}

}  // namespace betamesh
