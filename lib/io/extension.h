// Finds the format of a file, by extension or contents, and what it can hold.

#pragma once

#include "io/format_table.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace betamesh {

/// A path without its extension, and the extension: that of splash.0001.bgeo.gz is ".bgeo.gz".
std::pair<std::string, std::string> splitExtension(const std::string& path);

/// The format for the extension of a file name, in upper or lower case.
///
/// errors  an extension that is unknown, or whose format cannot be read or written or does not hold `kind`. The message
///         lists the extensions that can be used
const FileFormat& formatOf(const std::filesystem::path& path, FileKind kind, Access access);

/// Whether formatOf() does not throw.
bool canHold(const std::filesystem::path& path, FileKind kind, Access access);
/// Whether a mesh file of this name holds the normals of vertices that an attribute gives.
bool holdsNormals(const std::filesystem::path& path);

/// The extensions of all formats that formatOf() accepts, separated by spaces.
std::string extensionsFor(FileKind kind, Access access);
/// Those that can be read, whatever they hold.
std::string readableExtensions();

/// What there is to write besides positions and corners.
struct Extras {
    bool velocity = true, attributes = false, components = false;
};

/// What of `extras` a file of this name cannot hold, as in "velocity and attributes"; empty: it holds everything.
/// options: of the writer.
std::string lossesOf(const std::filesystem::path& path, FileKind kind, const Extras& extras,
                     const WriteOptions& options = {});

/// Whether a format can store ids without changing the numbers.
bool holdsIds(const FileFormat& format, const std::vector<std::uint64_t>& ids);

/// The names under which a writer of this format can store attributes. A character that it cannot store becomes an
/// underscore, an empty name `unnamed`; names of the format's own get an underscore at the end, and so do further
/// characters ("a_2") where two become the same. Names are cut after 200 characters.
///
/// same    names that need no change keep theirs
std::vector<std::string> writableNames(const FileFormat& format, FileKind kind, const std::vector<std::string>& names);

/// Renames attributes to writableNames().
void makeNamesWritable(const FileFormat& format, FileKind kind, std::vector<Attribute>& attributes);

/// Calls write(data) with data whose attributes have names that the format can store: `data` itself if all have.
template <typename Data, typename Write>
void writeWithNames(const FileFormat& format, FileKind kind, const Data& data, const Write& write) {
    std::vector<Attribute> names;
    for (const Attribute& a : data.attributes) names.push_back({a.name, a.components, {}, {}});
    makeNamesWritable(format, kind, names);
    const auto isSame = [](const Attribute& a, const Attribute& b) { return a.name == b.name; };
    if (std::equal(names.begin(), names.end(), data.attributes.begin(), isSame)) return write(data);
    Data renamed = data;
    for (std::size_t i = 0; i < names.size(); ++i) renamed.attributes[i].name = std::move(names[i].name);
    write(renamed);
}

/// The attributes that get another name in a file of this name, as in "'a.b' is written as 'a_b', 'P' is written as
/// 'P_' (that name is not free)"; empty: none.
std::string renamingsIn(const std::filesystem::path& path, FileKind kind, const std::vector<std::string>& attributes);

/// Estimated bytes on disk of one particle in a file of this name.
double fileBytesPerParticle(const std::filesystem::path& path);

/// An extension of the format that a file has which begins with these bytes; empty if they are no known signature.
std::string extensionOfContents(std::string_view begin);

/// Whether files of this name have several sets of points, from which ParticleInput::grid chooses.
bool hasGrids(const std::filesystem::path& path);

/// Whether the extension is .vdb, in upper or lower case.
bool isVdb(const std::filesystem::path& path);

/// Reads a file that holds `kind`, in the format of its extension.
///
/// errors  those of formatOf() and of the reader; contents that have the signature of another format, which is named
FileContents readFormat(const std::filesystem::path& path, FileKind kind, const ReadOptions& options);

/// The format of a file's contents, which can be read. note: says so if it is not that of the extension, else empty.
///
/// errors  contents and an extension that are not known, or that cannot be read
const FileFormat& formatByContents(const std::filesystem::path& path, std::string& note);

/// Reads a file in the format of its contents, whatever its extension. note: as of formatByContents().
FileContents readByContents(const std::filesystem::path& path, const ReadOptions& options, std::string& note);

}  // namespace betamesh
