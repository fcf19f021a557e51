#include "io/extension.h"

#include "base/lower_case.h"
#include "base/nearest_word.h"
#include "betamesh/error.h"
#include "io/gzip.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <system_error>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

// Formats that are recognised only to say that they cannot be read.
struct ForeignFormat {
    std::string_view name, magic;
    std::string_view advice{};  ///< how to convert it; empty: to one of the formats that can be read
};
constexpr std::string_view kUsdcat = "Convert it to text: usdcat IN.usdc -o OUT.usda.";
constexpr std::array kForeign = std::to_array<ForeignFormat>({{"binary USD", "PXR-USDC", kUsdcat},
                                                              {"HDF5, the older container of Alembic", "\x89HDF"},
                                                              {"a ZIP archive", "PK\3\4"},
                                                              {"glTF", "glTF"}});

std::string lowerName(const fs::path& path) { return lowerCase(path.filename().string()); }

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
    for (const FileFormat& format : fileFormats())
        if (!extensionIn(extensionsOf(format, access), name).empty()) return &format;
    return nullptr;
}

const char* nameOf(FileKind kind) {
    return kind == FileKind::particles ? "particles" : kind == FileKind::mesh ? "meshes" : "curves";
}

std::string extensionsWhere(Access access, const std::function<bool(const FileFormat&)>& wanted) {
    std::string all;
    for (const FileFormat& format : fileFormats())
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
///
/// in      named: the format of the extension; null: none is known
/// errors  a file of 0 bytes whose format has a signature
Signature signatureOf(const fs::path& path, const FileFormat* named) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return {};
    if (named != nullptr && named->hasSignature != nullptr && fs::file_size(path, ignored) == 0)
        throw Error(path.string() + ": empty file (0 bytes), expected " + std::string(named->name));
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
    for (const FileFormat& format : fileFormats())
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
    if (signature.begin.starts_with("{\"frame\":"))
        throw Error(path.string() + ": this is a manifest, the report beside a mesh. Give the mesh" +
                    (path.extension() == ".json" ? ", " + fs::path(path).replace_extension().string() : "") + '.');
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

std::pair<std::string, std::string> splitExtension(const std::string& path) {
    const fs::path whole(path);
    std::string extension = whole.extension().string();
    if (extension == ".gz" || extension == ".sc") extension = whole.stem().extension().string() + extension;
    return {path.substr(0, path.size() - extension.size()), extension};
}

const FileFormat& formatOf(const fs::path& path, FileKind kind, Access access) {
    const std::string name = lowerName(path);
    for (const FileFormat& format : fileFormats())
        if (holds(format, kind, access) && !extensionIn(extensionsOf(format, access), name).empty()) return format;
    const Access other = access == Access::read ? Access::write : Access::read;
    const FileFormat* format = formatWith(name, other);
    const std::string known = extensionsFor(kind, access), extension = path.extension().string();
    std::string fault = ": '" + extension + "' is not a format for " + nameOf(kind), guess;
    if (kind == FileKind::mesh && access == Access::read && isVdb(path))
        guess = " A level set becomes a mesh by vdb_tool: vdb_tool -read in.vdb -ls2mesh -write out.ply.";
    else if (extension == ".usdc" || extension == ".usd" || extension == ".usdz")
        guess = access == Access::write
                    ? " Binary USD is not written: write .usda and convert it, as in usdcat a.usda -o a.usdc."
                    : " Binary USD is not read: convert it to text, as in usdcat a.usdc -o a.usda.";
    else if (extension == ".json")
        guess = " The .json beside a mesh is its manifest, the report on it: give the mesh.";
    else if (extension.empty() && access == Access::write)
        fault = ": the name has no extension, which selects the format",
        guess = " For a folder give the names of the files in it, as in " + (path / "name.####.ply").string() + '.';
    else if (extension.empty())
        fault = ": the name has no extension, which selects the format";
    else if (format != nullptr && formatWith(name, access) == nullptr)
        fault = ": " + extension + " can be " +
                (access == Access::read ? "written, but not read" : "read, but not written");
    else if (formatWith(name, access) == nullptr)
        guess = didYouMean(extension, wordsOf(known));
    throw Error(path.string() + fault + ". Use one of " + known + '.' + guess);
}

bool canHold(const fs::path& path, FileKind kind, Access access) {
    const std::string name = lowerName(path);
    return std::any_of(fileFormats().begin(), fileFormats().end(), [&](const FileFormat& format) {
        return holds(format, kind, access) && !extensionIn(extensionsOf(format, access), name).empty();
    });
}

bool holdsNormals(const fs::path& path) {
    if (!canHold(path, FileKind::mesh, Access::write)) return false;
    const FileFormat& format = formatOf(path, FileKind::mesh, Access::write);
    return format.holds_normals || (format.holds_attributes && !format.is_volume);
}

std::string extensionsFor(FileKind kind, Access access) {
    return extensionsWhere(access, [&](const FileFormat& format) { return holds(format, kind, access); });
}

std::string readableExtensions() {
    return extensionsWhere(Access::read, [](const FileFormat&) { return true; });
}

std::string lossesOf(const fs::path& path, FileKind kind, const Extras& extras, const WriteOptions& options) {
    const FileFormat& format = formatOf(path, kind, Access::write);
    if (format.is_drawing) return {};
    std::vector<std::string> lost;
    const bool is_volume = format.is_volume && kind == FileKind::mesh;
    const bool has_velocity = is_volume ? options.level_set.velocity : format.holds_attributes;
    if (!has_velocity && extras.velocity) lost.push_back("velocity");
    if ((is_volume || !format.holds_attributes) && extras.attributes) lost.push_back("attributes");
    if (!format.holds_components && extras.components) lost.push_back("components");
    std::string text;
    for (std::size_t i = 0; i < lost.size(); ++i)
        text += (i == 0 ? "" : i + 1 == lost.size() ? " and " : ", ") + lost[i];
    return text;
}

bool holdsIds(const FileFormat& format, const std::vector<std::uint64_t>& ids) {
    if (format.id_bits == 64 || (format.has_signed_ids && haveSigned32Bits(ids))) return true;
    return std::none_of(ids.begin(), ids.end(), [&](std::uint64_t id) { return id >> format.id_bits != 0; });
}

std::string renamingsIn(const fs::path& path, FileKind kind, const std::vector<std::string>& attributes) {
    const FileFormat& format = formatOf(path, kind, Access::write);
    std::vector<std::string> names = writableNames(format, kind, attributes);
    if (format.namesInFile != nullptr) names = format.namesInFile(names);
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] != attributes[i])
            text += (text.empty() ? "'" : ", '") + attributes[i] + "' is written as '" + names[i] +
                    (names[i].starts_with(attributes[i] + '_') ? "' (that name is not free)" : "'");
    return text;
}

std::vector<std::string> writableNames(const FileFormat& format, FileKind kind, const std::vector<std::string>& names) {
    constexpr std::size_t kLongest = 200;
    std::vector<std::string> reserved = wordsOf(format.reserved_names), writable;
    if (kind == FileKind::particles)
        for (const std::string& name : wordsOf(format.reserved_of_particles)) reserved.push_back(name);
    for (const std::string& name : names) {
        std::string plain = name.substr(0, kLongest);
        for (char& c : plain)
            if (std::isspace(static_cast<unsigned char>(c)) != 0 || c == '\0' ||
                (format.isInNames != nullptr && !format.isInNames(c)))
                c = '_';
        if (plain.empty()) plain = "unnamed";
        if (std::find(reserved.begin(), reserved.end(), plain) != reserved.end()) plain += '_';
        writable.push_back(plain);
    }
    return distinctNames(names, std::move(writable), {});
}

void makeNamesWritable(const FileFormat& format, FileKind kind, std::vector<Attribute>& attributes) {
    std::vector<std::string> names;
    for (const Attribute& a : attributes) names.push_back(a.name);
    names = writableNames(format, kind, names);
    for (std::size_t i = 0; i < names.size(); ++i) attributes[i].name = std::move(names[i]);
}

double fileBytesPerParticle(const fs::path& path) {
    // Measured on frames of SPH and FLIP simulations, which compress to 0.52 and 0.43 of their size; text of Houdini.
    constexpr double kGzipRatio = 0.5, kBloscRatio = 0.43, kTextRatio = 4;
    const std::string name = lowerName(path);
    const FileFormat* format = formatWith(name, Access::read);
    const double bytes = (format != nullptr ? *format : fileFormats().front()).particle_bytes;
    return bytes * (name.ends_with(".gz")    ? kGzipRatio
                    : name.ends_with(".sc")  ? kBloscRatio
                    : name.ends_with(".geo") ? kTextRatio
                                             : 1);
}

std::string extensionOfContents(std::string_view begin) {
    const bool gzip = begin.starts_with("\x1f\x8b");
    for (const FileFormat& format : fileFormats())
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
    const Signature signature = signatureOf(path, &format);
    const FileFormat* found = formatOfContents(signature, &format);
    requireKnown(path, signature);
    if (found != nullptr && found->read != format.read)
        throw Error(path.string() + ": contains " + describe(*found, signature) + ", not " + std::string(format.name) +
                    ". " + (found->read == nullptr ? "That cannot be read." : adviceToRename(*found, signature)));
    requireReadableGzip(path, format, signature);
    return format.read(path, options);
}

const FileFormat& formatByContents(const fs::path& path, std::string& note) {
    const std::string name = lowerName(path);
    const FileFormat* named = formatWith(name, Access::read);
    const Signature signature = signatureOf(path, named);
    requireKnown(path, signature);
    const FileFormat* found = formatOfContents(signature, named);
    if (found == nullptr) found = named;
    if (found == nullptr) {
        if (formatWith(name, Access::write) != nullptr)
            throw Error(path.string() + ": " + extensionIn(formatWith(name, Access::write)->write_extensions, name) +
                        " can be written, but not read. Use one of " + readableExtensions() + ".");
        openFile(path);  // what cannot be opened has no contents to tell of
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
    return *found;
}

FileContents readByContents(const fs::path& path, const ReadOptions& options, std::string& note) {
    return formatByContents(path, note).read(path, options);
}

}  // namespace betamesh
