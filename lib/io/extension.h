// The table of file formats: by extension, what each holds and the functions that read and write it.

#pragma once

#include "betamesh/io.h"
#include "io/bytes.h"
#include "io/file_contents.h"
#include "io/output_file.h"
#include "io/up_axis.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace betamesh {

enum class Access { read, write };

/// A function that encodes data for the file of a name, which is for messages; null: the format cannot hold such data.
template <typename Data>
class Encoder {
public:
    constexpr Encoder(std::nullptr_t) {}
    constexpr Encoder(void (*encode)(ByteWriter&, const Data&, const std::string&)) : encode_(encode) {}
    /// For formats that have a place for some of the options, or write something that depends on them.
    constexpr Encoder(void (*encode)(ByteWriter&, const Data&, const std::string&, const WriteOptions&))
        : encode_with_options_(encode) {}

    /// Encodes data. For up axis z, rotates them first: the functions find data that are rotated already.
    void operator()(ByteWriter& out, const Data& data, const std::string& file, const WriteOptions& options) const {
        if (options.up_axis == UpAxis::z)
            call(out, withZUp(data), file, options);
        else
            call(out, data, file, options);
    }

    constexpr explicit operator bool() const { return encode_ != nullptr || encode_with_options_ != nullptr; }
    constexpr bool operator==(std::nullptr_t) const { return !*this; }

private:
    void call(ByteWriter& out, const Data& data, const std::string& file, const WriteOptions& options) const {
        if (encode_with_options_ != nullptr)
            encode_with_options_(out, data, file, options);
        else
            encode_(out, data, file);
    }

    void (*encode_)(ByteWriter&, const Data&, const std::string&) = nullptr;
    void (*encode_with_options_)(ByteWriter&, const Data&, const std::string&, const WriteOptions&) = nullptr;
};

/// One file format. Everything that depends on the format of a file follows from these rows: which function reads or
/// writes it, error messages, help, warnings, memory estimates and the manual.
struct FileFormat {
    std::string_view name;              ///< "OpenVDB points"
    std::string_view read_extensions;   ///< lower case, separated by spaces; empty: the format cannot be read
    std::string_view write_extensions;  ///< .gz: through gzip; .sc: in a Blosc container

    /// Whether a file that begins with these bytes (up to kSignatureBytes, decompressed) has the format. Null: files of
    /// this format have no signature.
    bool (*hasSignature)(std::string_view begin) = nullptr;
    bool may_be_gzip = false;  ///< the reader decompresses gzip, whatever the extension

    FileContents (*read)(const std::filesystem::path& path, const ReadOptions& options) = nullptr;
    bool reads_particles = false;
    bool reads_surfaces = false;  ///< meshes and curves

    /// Null: the format cannot hold it.
    Encoder<Particles> write_particles = nullptr;
    Encoder<Mesh> write_mesh = nullptr;
    Encoder<Curves> write_curves = nullptr;
    Encoder<Spheres> write_spheres = nullptr;

    // What is written.
    bool is_drawing = false;        ///< a picture of planar curves, which writeSvg() writes
    bool holds_attributes = true;   ///< velocity is one of them
    bool holds_components = false;  ///< Mesh::component
    int id_bits = 0;                ///< of Particles::id

    double particle_bytes = 30;  ///< typical size of a particle with velocity and id on disk, without gzip or Blosc

    std::string_view test;   ///< a test of the format, SUITE.NAME
    std::string_view proof;  ///< the foreign program whose reader or files prove the format
};

inline constexpr std::size_t kSignatureBytes = 512;

/// All formats, in the order of messages and of the manual.
std::span<const FileFormat> fileFormats();

/// The format for the extension of a file name, in upper or lower case.
///
/// errors  an extension that is unknown, or whose format cannot be read or written or does not hold `kind`. The message
///         lists the extensions that can be used
const FileFormat& formatOf(const std::filesystem::path& path, FileKind kind, Access access);

/// Whether formatOf() does not throw.
bool canHold(const std::filesystem::path& path, FileKind kind, Access access);

/// The extensions of all formats that formatOf() accepts, separated by spaces.
std::string extensionsFor(FileKind kind, Access access);
/// Those that can be read, whatever they hold.
std::string readableExtensions();

/// What there is to write besides positions and corners.
struct Extras {
    bool velocity = true, attributes = false, components = false;
};

/// What of `extras` a file of this name cannot hold, as in "velocity and attributes"; empty: it holds everything.
std::string lossesOf(const std::filesystem::path& path, FileKind kind, const Extras& extras);

/// Estimated bytes on disk of one particle in a file of this name.
double fileBytesPerParticle(const std::filesystem::path& path);

/// An extension of the format that a file has which begins with these bytes; empty if they are no known signature.
std::string extensionOfContents(std::string_view begin);

/// Whether the extension is .vdb, in upper or lower case.
bool isVdb(const std::filesystem::path& path);

/// Reads a file that holds `kind`, in the format of its extension.
///
/// errors  those of formatOf() and of the reader; contents that have the signature of another format, which is named
FileContents readFormat(const std::filesystem::path& path, FileKind kind, const ReadOptions& options);

/// Reads a file in the format of its contents, whatever its extension. note: says so if the two differ, else empty.
FileContents readByContents(const std::filesystem::path& path, const ReadOptions& options, std::string& note);

/// A path without its extension, and the extension: that of splash.0001.bgeo.gz is ".bgeo.gz".
std::pair<std::string, std::string> splitExtension(const std::string& path);

/// Creates a file and fills it by calling encode, through gzip if the name ends in .gz, in a Blosc container if it ends
/// in .sc. The caller has to commit() it.
OutputFile encodedFile(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);
/// The same, and commits the file.
void writeEncoded(const std::filesystem::path& path, const std::function<void(ByteWriter&)>& encode);

}  // namespace betamesh
