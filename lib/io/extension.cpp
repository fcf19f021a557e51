#include "io/extension.h"

#include "base/nearest_word.h"
#include "betamesh/error.h"
#include "io/bgeo.h"
#include "io/gzip.h"
#include "io/houdini_geo.h"
#include "io/obj.h"
#include "io/ply.h"
#include "io/prt.h"
#include "io/stl.h"
#include "io/table.h"
#include "io/usd.h"
#include "io/vdb.h"
#include "io/vtk.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <system_error>
#include <vector>

namespace betamesh {

namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

template <FileContents (*parse)(Cursor, const ReadOptions&)>
FileContents readWith(const fs::path& path, const ReadOptions& options) {
    return parse(openFile(path), options);
}

FileContents readObj(const fs::path& path, const ReadOptions&) { return parseObj(readWholeFile(path), path.string()); }

void writeVdb(ByteWriter& out, const Particles& particles, const std::string& file) {
    out.text(encodeVdb(particles, file));
    out.flush();
}

/// Spheres as particles whose radius is the attribute `name`.
template <void (*encode)(ByteWriter&, const Particles&, const std::string&), const char* name>
void writeSpheresAs(ByteWriter& out, const Spheres& spheres, const std::string& file) {
    encode(out, particlesOf(spheres, name, file), file);
}
constexpr char kRadius[] = "radius", kScale[] = "pscale";

void writeUsdSpheres(ByteWriter& out, const Spheres& spheres, const std::string& file, const WriteOptions& options) {
    encodeUsda(out, particlesOf(spheres, kScale, file), file, options);
}

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
     .particle_bytes = 28,
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it"},
    {.name = "OpenVDB points",
     .read_extensions = ".vdb",
     .write_extensions = ".vdb",
     .hasSignature = isOpenVdb,
     .read = readVdb,
     .reads_particles = true,
     .has_grids = true,
     .write_particles = writeVdb,
     .id_bits = 64,
     .particle_bytes = 12,
     .test = "VdbFile.ReadsQuantisedPointsOfSeveralGrids",
     .proof = "the OpenVDB library reads and writes it"},
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
     .particle_bytes = 30,  // 48 in files of this program; others compress by zlib
     .test = "batch.Interop.Vtk",
     .proof = "VTK reads it; files of splashsurf"},
    {.name = "text of USD",
     .read_extensions = ".usda",
     .write_extensions = ".usda",
     .hasSignature = isUsda,
     .read = readWith<parseUsda>,
     .reads_particles = true,
     .reads_surfaces = true,
     .has_grids = true,
     .write_particles = encodeUsda,
     .write_mesh = encodeUsda,
     .write_spheres = writeUsdSpheres,
     .holds_components = true,
     .id_bits = 63,
     .nameInFile = usdName,
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

// Formats that are recognised only to say that they cannot be read.
struct ForeignFormat {
    std::string_view name, magic;
    std::string_view advice{};  ///< how to convert it; empty: to one of the formats that can be read
};
constexpr std::string_view kUsdcat = "Convert it to text: usdcat IN.usdc -o OUT.usda.";
constexpr std::array kForeign = std::to_array<ForeignFormat>({{"binary USD", "PXR-USDC", kUsdcat},
                                                              {"Alembic", "Ogawa"},
                                                              {"HDF5", "\x89HDF"},
                                                              {"a ZIP archive", "PK\3\4"},
                                                              {"glTF", "glTF"}});

std::string lowerName(const fs::path& path) {
    std::string name = path.filename().string();
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name;
}

std::vector<std::string> wordsOf(std::string_view text) {
    std::istringstream in{std::string(text)};
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

/// The extension of a list that a lower-case file name has; empty: none.
std::string extensionIn(std::string_view extensions, const std::string& name) {
    std::string longest;
    for (const std::string& extension : wordsOf(extensions))
        if (name.ends_with(extension) && extension.size() > longest.size()) longest = extension;
    return longest;
}

std::string_view extensionsOf(const FileFormat& format, Access access) {
    return access == Access::read ? format.read_extensions : format.write_extensions;
}

bool holds(const FileFormat& format, FileKind kind, Access access) {
    if (access == Access::read) return kind == FileKind::particles ? format.reads_particles : format.reads_surfaces;
    return kind == FileKind::particles ? format.write_particles != nullptr
           : kind == FileKind::mesh    ? format.write_mesh != nullptr
                                       : format.write_curves != nullptr || format.is_drawing;
}

const FileFormat* formatWith(const std::string& name, Access access) {
    for (const FileFormat& format : kFormats)
        if (!extensionIn(extensionsOf(format, access), name).empty()) return &format;
    return nullptr;
}

const char* nameOf(FileKind kind) {
    return kind == FileKind::particles ? "particles" : kind == FileKind::mesh ? "meshes" : "curves";
}

std::string extensionsWhere(Access access, const std::function<bool(const FileFormat&)>& wanted) {
    std::string all;
    for (const FileFormat& format : kFormats)
        if (!extensionsOf(format, access).empty() && wanted(format))
            all += (all.empty() ? "" : " ") + std::string(extensionsOf(format, access));
    return all;
}

// Recognising contents.

struct Signature {
    std::string begin;  // first bytes, decompressed if they are a gzip stream
    bool gzip = false;
};

/// The beginning of a regular file; empty for all others, which can be read only once.
Signature signatureOf(const fs::path& path) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return {};
    Cursor in = openFile(path);
    Signature signature;
    signature.gzip = isGzip(in);
    if (signature.gzip) {
        Cursor plain = gunzipped(std::move(in));
        signature.begin = plain.peek(kSignatureBytes).substr(0, kSignatureBytes);
    } else {
        signature.begin = in.peek(kSignatureBytes).substr(0, kSignatureBytes);
    }
    return signature;
}

bool matches(const FileFormat& format, const Signature& signature) {
    return format.hasSignature != nullptr && format.hasSignature(signature.begin);
}

/// The format of contents; `named` if they have its signature, null if they have none that is known.
const FileFormat* formatOfContents(const Signature& signature, const FileFormat* named) {
    if (named != nullptr && matches(*named, signature)) return named;
    for (const FileFormat& format : kFormats)
        if (matches(format, signature)) return &format;
    return nullptr;
}

std::string describe(const FileFormat& format, const Signature& signature) {
    return std::string(format.name) + (signature.gzip ? " compressed by gzip" : "");
}

std::string adviceToRename(const FileFormat& format, const Signature& signature) {
    return "Rename it so that it ends in " + wordsOf(format.read_extensions).front() + (signature.gzip ? ".gz." : ".");
}

/// Throws Error if the contents are of a kind of file that is not read.
void requireKnown(const fs::path& path, const Signature& signature) {
    for (const ForeignFormat& foreign : kForeign)
        if (signature.begin.starts_with(foreign.magic))
            throw Error(path.string() + ": contains " + std::string(foreign.name) + ", which cannot be read. " +
                        (foreign.advice.empty() ? "Convert it to one of " + readableExtensions() + "."
                                                : std::string(foreign.advice)));
}

void requireReadableGzip(const fs::path& path, const FileFormat& format, const Signature& signature) {
    if (signature.gzip && !format.may_be_gzip)
        throw Error(path.string() + ": contains " + describe(format, signature) +
                    ", which is not decompressed here. Run gunzip first.");
}

}  // namespace

std::span<const FileFormat> fileFormats() { return kFormats; }

const FileFormat& formatOf(const fs::path& path, FileKind kind, Access access) {
    const std::string name = lowerName(path);
    for (const FileFormat& format : kFormats)
        if (holds(format, kind, access) && !extensionIn(extensionsOf(format, access), name).empty()) return format;
    const Access other = access == Access::read ? Access::write : Access::read;
    const FileFormat* format = formatWith(name, other);
    const std::string known = extensionsFor(kind, access), extension = path.extension().string();
    std::string fault = ": '" + extension + "' is not a format for " + nameOf(kind), guess;
    if (extension == ".usdc" || extension == ".usd" || extension == ".usdz")
        guess = access == Access::write
                    ? " Binary USD is not written: write .usda and convert it, as in usdcat a.usda -o a.usdc."
                    : " Binary USD is not read: convert it to text, as in usdcat a.usdc -o a.usda.";
    else if (extension.empty())
        fault = ": the name has no extension, which selects the format";
    else if (format != nullptr && formatWith(name, access) == nullptr)
        fault = ": " + extension + " can be " +
                (access == Access::read ? "written, but not read" : "read, but not written");
    else
        guess = didYouMean(extension, wordsOf(known));
    throw Error(path.string() + fault + ". Use one of " + known + '.' + guess);
}

bool canHold(const fs::path& path, FileKind kind, Access access) {
    const std::string name = lowerName(path);
    return std::any_of(kFormats.begin(), kFormats.end(), [&](const FileFormat& format) {
        return holds(format, kind, access) && !extensionIn(extensionsOf(format, access), name).empty();
    });
}

std::string extensionsFor(FileKind kind, Access access) {
    return extensionsWhere(access, [&](const FileFormat& format) { return holds(format, kind, access); });
}

std::string readableExtensions() {
    return extensionsWhere(Access::read, [](const FileFormat&) { return true; });
}

std::string lossesOf(const fs::path& path, FileKind kind, const Extras& extras) {
    const FileFormat& format = formatOf(path, kind, Access::write);
    if (format.is_drawing) return {};
    std::vector<std::string> lost;
    if (!format.holds_attributes && extras.velocity) lost.push_back("velocity");
    if (!format.holds_attributes && extras.attributes) lost.push_back("attributes");
    if (!format.holds_components && extras.components) lost.push_back("components");
    std::string text;
    for (std::size_t i = 0; i < lost.size(); ++i)
        text += (i == 0 ? "" : i + 1 == lost.size() ? " and " : ", ") + lost[i];
    return text;
}

std::string renamingsIn(const fs::path& path, FileKind kind, const std::vector<std::string>& attributes) {
    const FileFormat& format = formatOf(path, kind, Access::write);
    std::string text;
    if (format.nameInFile == nullptr) return text;
    for (const std::string& name : attributes)
        if (const std::string other = format.nameInFile(name); other != name)
            text += (text.empty() ? "'" : ", '") + name + "' is written as '" + other + "'";
    return text;
}

double fileBytesPerParticle(const fs::path& path) {
    // Measured on frames of SPH and FLIP simulations, which compress to 0.52 and 0.43 of their size; text of Houdini.
    constexpr double kGzipRatio = 0.5, kBloscRatio = 0.43, kTextRatio = 4;
    const std::string name = lowerName(path);
    const FileFormat* format = formatWith(name, Access::read);
    const double bytes = (format != nullptr ? *format : kFormats[0]).particle_bytes;
    return bytes * (name.ends_with(".gz")    ? kGzipRatio
                    : name.ends_with(".sc")  ? kBloscRatio
                    : name.ends_with(".geo") ? kTextRatio
                                             : 1);
}

std::string extensionOfContents(std::string_view begin) {
    const bool gzip = begin.starts_with("\x1f\x8b"sv);
    for (const FileFormat& format : kFormats)
        if (format.read != nullptr && (gzip ? format.may_be_gzip : matches(format, {std::string(begin), false})))
            return wordsOf(format.read_extensions).front();
    return "";
}

bool hasGrids(const fs::path& path) {
    const FileFormat* format = formatWith(lowerName(path), Access::read);
    return format != nullptr && format->has_grids;
}

bool isVdb(const fs::path& path) { return lowerName(path).ends_with(".vdb"); }

FileContents readFormat(const fs::path& path, FileKind kind, const ReadOptions& options) {
    const FileFormat& format = formatOf(path, kind, Access::read);
    const Signature signature = signatureOf(path);
    const FileFormat* found = formatOfContents(signature, &format);
    requireKnown(path, signature);
    if (found != nullptr && found->read != format.read)
        throw Error(path.string() + ": contains " + describe(*found, signature) + ", not " + std::string(format.name) +
                    ". " + (found->read == nullptr ? "That cannot be read." : adviceToRename(*found, signature)));
    requireReadableGzip(path, format, signature);
    return format.read(path, options);
}

FileContents readByContents(const fs::path& path, const ReadOptions& options, std::string& note) {
    const std::string name = lowerName(path);
    const FileFormat* named = formatWith(name, Access::read);
    const Signature signature = signatureOf(path);
    requireKnown(path, signature);
    const FileFormat* found = formatOfContents(signature, named);
    if (found == nullptr) found = named;
    if (found == nullptr) {
        if (formatWith(name, Access::write) != nullptr)
            throw Error(path.string() + ": " + extensionIn(formatWith(name, Access::write)->write_extensions, name) +
                        " can be written, but not read. Use one of " + readableExtensions() + ".");
        throw Error(path.string() +
                    ": neither the extension nor the contents are those of a known format. Use one of " +
                    readableExtensions() + ".");
    }
    if (found->read == nullptr)
        throw Error(path.string() + ": contains " + std::string(found->name) + ", which cannot be read. Use one of " +
                    readableExtensions() + ".");
    requireReadableGzip(path, *found, signature);
    note = named != nullptr && named->read == found->read
               ? ""
               : "contains " + describe(*found, signature) +
                     ", which other commands do not expect with this extension. " + adviceToRename(*found, signature);
    return found->read(path, options);
}

}  // namespace betamesh
