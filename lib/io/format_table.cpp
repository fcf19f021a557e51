#include "io/format_table.h"

#include "io/alembic.h"
#include "io/bgeo.h"
#include "io/houdini_geo.h"
#include "io/level_set.h"
#include "io/obj.h"
#include "io/ply.h"
#include "io/prt.h"
#include "io/stl.h"
#include "io/table.h"
#include "io/usd.h"
#include "io/vdb.h"
#include "io/vtk.h"

#include <array>

namespace betamesh {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

template <FileContents (*parse)(Cursor, const ReadOptions&)>
FileContents readWith(const fs::path& path, const ReadOptions& options) {
    return parse(openFile(path), options);
}

FileContents readObj(const fs::path& path, const ReadOptions&) { return parseObj(readWholeFile(path), path.string()); }

std::vector<double> usdSampleTimes(const fs::path& path, const ReadOptions& options) {
    return usdaSampleTimes(openFile(path), options);
}

void writeVdb(ByteWriter& out, const Particles& particles, const std::string& file) {
    out.text(encodeVdb(particles, file));
    out.flush();
}

void writeLevelSet(ByteWriter& out, const Mesh& mesh, const std::string& file, const WriteOptions& options) {
    out.text(encodeLevelSet(mesh, file, options.level_set, options.warn != nullptr ? *options.warn : WarningHandler()));
    out.flush();
}

/// Spheres as particles whose radius is the attribute `name`.
template <void (*encode)(ByteWriter&, const Particles&, const std::string&), const char* name>
void writeSpheresAs(ByteWriter& out, const Spheres& spheres, const std::string& file) {
    encode(out, particlesOf(spheres, name, file), file);
}
constexpr char kRadius[] = "radius", kScale[] = "pscale";

void writeAbcSpheres(ByteWriter& out, const Spheres& spheres, const std::string& file, const WriteOptions& options) {
    encodeAbc(out, particlesOf(spheres, kRadius, file), file, options);
}

void writeUsdSpheres(ByteWriter& out, const Spheres& spheres, const std::string& file, const WriteOptions& options) {
    encodeUsda(out, particlesOf(spheres, kScale, file), file, options);
}

bool isInVdbNames(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '|' ||
           c == ':';
}
bool isInAbcNames(char c) { return c != '/'; }

bool isHoudini(std::string_view begin) {
    for (const std::string_view magic : {"\x7fNSJb"sv,
                                         "\x7f"
                                         "bJSN"sv,
                                         "["sv, "{"sv, "scf1"sv, "BgeoV"sv, "PGEOMETRY"sv})
        if (begin.starts_with(magic)) return true;
    return false;
}
bool isPly(std::string_view begin) { return begin.starts_with("ply\n"sv) || begin.starts_with("ply\r"sv); }
bool isOpenVdb(std::string_view begin) { return begin.starts_with(" BDV\0\0\0\0"sv); }
bool isOgawa(std::string_view begin) { return begin.starts_with("Ogawa"sv); }
bool isLegacyVtk(std::string_view begin) { return begin.starts_with("# vtk DataFile"sv); }
bool isXmlVtk(std::string_view begin) { return begin.find("<VTKFile"sv) != std::string_view::npos; }
bool isUsda(std::string_view begin) { return begin.starts_with("#usda"sv); }
bool isPrt(std::string_view begin) { return begin.starts_with("\xc0PRT"sv); }
bool isSvg(std::string_view begin) { return begin.find("<svg"sv) != std::string_view::npos; }
bool isTextStl(std::string_view begin) {
    return begin.starts_with("solid"sv) && begin.find("facet"sv) != std::string_view::npos;
}

constexpr std::array kFormats = std::to_array<FileFormat>({
    {.name = "Houdini geometry",
     .read_extensions = ".bgeo .bgeo.gz .bgeo.sc .geo",
     .write_extensions = ".bgeo .bgeo.gz .bgeo.sc",
     .hasSignature = isHoudini,
     .may_be_gzip = true,
     .read = readWith<parseHoudini>,
     .reads_particles = true,
     .reads_surfaces = true,
     .write_particles = encodeBgeoJson,
     .write_mesh = encodeBgeoJson,
     .write_curves = encodeBgeoJson,
     .write_spheres = writeSpheresAs<encodeBgeoJson, kScale>,
     .holds_components = true,
     .id_bits = 64,
     .particle_bytes = 28,
     .test = "golden.ForeignFiles",
     .proof = "files of Houdini 13 to 21; a reader in Python"},
    {.name = "classic Houdini geometry",
     .read_extensions = ".bhclassic",
     .write_extensions = ".bhclassic",
     .hasSignature = isHoudini,
     .may_be_gzip = true,
     .read = readWith<parseHoudini>,
     .reads_particles = true,
     .reads_surfaces = true,
     .write_particles = encodeBgeo,
     .write_mesh = encodeBgeo,
     .write_curves = encodeBgeo,
     .write_spheres = writeSpheresAs<encodeBgeo, kScale>,
     .holds_components = true,
     .id_bits = 32,
     .particle_bytes = 32,
     .test = "golden.ForeignFiles",
     .proof = "files of partio and SPlisHSPlasH"},
    {.name = "PLY",
     .read_extensions = ".ply",
     .write_extensions = ".ply",
     .hasSignature = isPly,
     .read = readWith<parsePly>,
     .reads_particles = true,
     .reads_surfaces = true,
     .write_particles = encodePly,
     .write_mesh = encodePly,
     .write_curves = encodePly,
     .write_spheres = encodePly,
     .holds_components = true,
     .id_bits = 32,
     .has_signed_ids = true,
     .reserved_names = "x y z vx vy vz v id",
     .particle_bytes = 28,
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it"},
    {.name = "OpenVDB points and level sets",
     .read_extensions = ".vdb",
     .write_extensions = ".vdb",
     .hasSignature = isOpenVdb,
     .read = readVdb,
     .reads_particles = true,
     .has_grids = true,
     .write_particles = writeVdb,
     .write_mesh = writeLevelSet,
     .is_volume = true,
     .id_bits = 64,
     .isInNames = isInVdbNames,
     .particle_bytes = 12,
     .test = "VdbFile.ReadsQuantisedPointsOfSeveralGrids",
     .proof = "the OpenVDB library reads and writes it"},
    {.name = "Alembic",
     .read_extensions = ".abc",
     .write_extensions = ".abc",
     .hasSignature = isOgawa,
     .read = readAbc,
     .reads_particles = true,
     .reads_surfaces = true,
     .has_grids = true,
     .sampleTimes = abcSampleTimes,
     .write_particles = encodeAbc,
     .write_mesh = encodeAbc,
     .write_spheres = writeAbcSpheres,
     .holds_components = true,
     .id_bits = 64,
     .holds_frame_rate = true,
     .reserved_names = "P v component",
     .isInNames = isInAbcNames,
     .particle_bytes = 32,
     .test = "batch.Interop.Alembic",
     .proof = "the Alembic library reads it; files of that library"},
    {.name = "XML of VTK",
     .read_extensions = ".vtp .vtu",
     .write_extensions = ".vtp",
     .hasSignature = isXmlVtk,
     .read = readWith<parseVtkXml>,
     .reads_particles = true,
     .reads_surfaces = true,
     .write_particles = encodeVtp,
     .write_mesh = encodeVtp,
     .write_curves = encodeVtp,
     .write_spheres = writeSpheresAs<encodeVtp, kRadius>,
     .holds_components = true,
     .id_bits = 64,
     .reserved_names = "velocity Points Normals",
     .particle_bytes = 30,  // 48 in files of this program; others compress by zlib
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it; files of splashsurf"},
    {.name = "text of USD",
     .read_extensions = ".usda .usd",
     .write_extensions = ".usda",
     .hasSignature = isUsda,
     .read = readWith<parseUsda>,
     .reads_particles = true,
     .reads_surfaces = true,
     .has_grids = true,
     .sampleTimes = usdSampleTimes,
     .write_particles = encodeUsda,
     .write_mesh = encodeUsda,
     .write_spheres = writeUsdSpheres,
     .holds_components = true,
     .id_bits = 64,
     .holds_frame_rate = true,
     .holds_units = true,
     .reserved_names = "points velocities",
     .reserved_of_particles = "ids widths",
     .namesInFile = usdNames,
     .particle_bytes = 80,
     .test = "batch.Interop.Usd",
     .proof = "OpenUSD and TinyUSDZ read it; files of both"},
    {.name = "legacy VTK",
     .read_extensions = ".vtk",
     .write_extensions = "",
     .hasSignature = isLegacyVtk,
     .read = readWith<parseVtk>,
     .reads_particles = true,
     .reads_surfaces = true,
     .particle_bytes = 40,
     .test = "golden.ForeignFiles",
     .proof = "VTK reads the same; files of splashsurf"},
    {.name = "Thinkbox PRT",
     .read_extensions = ".prt",
     .write_extensions = "",
     .hasSignature = isPrt,
     .read = readWith<parsePrt>,
     .reads_particles = true,
     .particle_bytes = 20,
     .test = "golden.ForeignFiles",
     .proof = "files of Thinkbox Krakatoa"},
    {.name = "table of text",
     .read_extensions = ".csv .xyz",
     .write_extensions = ".csv",
     .read = readWith<parseTable>,
     .reads_particles = true,
     .write_particles = encodeTable,
     .id_bits = 64,
     .reserved_names = "x y z P vx vy vz v id",
     .particle_bytes = 40,  // 70 in files of this program; 27 without velocity and id
     .test = "batch.Interop.Vtk",
     .proof = "the csv module of Python reads it"},
    {.name = "Wavefront OBJ",
     .read_extensions = ".obj",
     .write_extensions = ".obj",
     .read = readObj,
     .reads_surfaces = true,
     .write_mesh = encodeObj,
     .write_curves = encodeObj,
     .holds_attributes = false,
     .holds_normals = true,
     .holds_components = true,
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it"},
    {.name = "STL",
     .read_extensions = "",
     .write_extensions = ".stl",
     .hasSignature = isTextStl,
     .write_mesh = encodeStl,
     .holds_attributes = false,
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it"},
    {.name = "SVG",
     .read_extensions = "",
     .write_extensions = ".svg",
     .hasSignature = isSvg,
     .is_drawing = true,
     .test = "batch.Interop.Vtk",
     .proof = "the XML module of Python reads it"},
});

}  // namespace

std::span<const FileFormat> fileFormats() { return kFormats; }

}  // namespace betamesh
