// The table of file formats: what each holds and the functions that read and write it.

#pragma once

#include "betamesh/io.h"
#include "io/bytes.h"
#include "io/file_contents.h"
#include "io/up_axis.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
    std::string_view name;              ///< "PLY"
    std::string_view read_extensions;   ///< lower case, separated by spaces; empty: the format cannot be read
    std::string_view write_extensions;  ///< .gz: through gzip; .sc: in a Blosc container

    /// Whether a file that begins with these bytes (up to kSignatureBytes, decompressed) has the format. Null: files of
    /// this format have no signature.
    bool (*hasSignature)(std::string_view begin) = nullptr;
    bool may_be_gzip = false;  ///< the reader decompresses gzip, whatever the extension

    FileContents (*read)(const std::filesystem::path& path, const ReadOptions& options) = nullptr;
    bool reads_particles = false;
    bool reads_surfaces = false;  ///< meshes and curves
    bool has_grids = false;       ///< several sets of points, from which ParticleInput::grid chooses
    /// As betamesh::sampleTimes(). Null: a file holds one frame.
    std::vector<double> (*sampleTimes)(const std::filesystem::path& path, const ReadOptions& options) = nullptr;

    /// Null: the format cannot hold it.
    Encoder<Particles> write_particles = nullptr;
    Encoder<Mesh> write_mesh = nullptr;
    Encoder<Curves> write_curves = nullptr;
    Encoder<Spheres> write_spheres = nullptr;

    // What is written.
    bool is_drawing = false;        ///< a drawing of planar curves, which writeSvg() writes
    bool holds_attributes = true;   ///< velocity is one of them
    bool holds_normals = false;     ///< of meshes, without other attributes
    bool holds_components = false;  ///< Mesh::component
    bool is_volume = false;       ///< a mesh is written as a level set, which has no attributes; velocity is an option
    int id_bits = 0;              ///< of Particles::id; 64: negative ids, too
    bool has_signed_ids = false;  ///< holds ids of 32 bits with sign, too
    bool holds_frame_rate = false;
    bool holds_units = false;  ///< the up axis and the length of a unit

    std::string_view reserved_names = "P v";        ///< that attributes cannot have, separated by spaces
    std::string_view reserved_of_particles = "id";  ///< those that particles and spheres cannot have either
    /// Whether a name of an attribute can have a character. Null: all but white space and zero bytes.
    bool (*isInNames)(char character) = nullptr;
    /// The names that the writer gives to attributes. Null: the same.
    std::vector<std::string> (*namesInFile)(const std::vector<std::string>& attributes) = nullptr;

    double particle_bytes = 30;  ///< typical size of a particle with velocity and id on disk, without gzip or Blosc

    std::string_view test;   ///< a test of the format, SUITE.NAME
    std::string_view proof;  ///< the foreign program whose reader or files prove the format
};

inline constexpr std::size_t kSignatureBytes = 512;

/// All formats, in the order of messages and of the manual.
std::span<const FileFormat> fileFormats();

}  // namespace betamesh
