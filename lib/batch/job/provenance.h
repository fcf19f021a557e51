// What the bytes of a mesh were made from, so that a later run can tell whether it would make the same ones.

#pragma once

#include "batch/config/config.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace betamesh {

/// What the file system says of a file without reading it.
struct FileFingerprint {
    std::uint64_t bytes = 0;
    std::int64_t modified = 0;  ///< nanoseconds of the system's clock
    bool operator==(const FileFingerprint&) const = default;
};

struct FileIdentity {
    FileFingerprint stamp;      ///< modified is 0 where a change in the same tick of a clock could have gone unnoticed
    std::string content;  ///< its fingerprint
};

/// What a manifest tells of how its frame was made.
struct Provenance {
    std::string version;        ///< of the program
    std::string configuration;  ///< fingerprint of the keys that shape the mesh
    double radius = 0;          ///< world units, as they came out of the configuration and the first frame
    double spacing = 0;
    std::optional<FileIdentity> input;           ///< none: there was no input, an empty mesh was asked for
    std::map<std::string, std::uint64_t> files;  ///< what was written, seen from the manifest's folder: bytes
};

/// 128 bits in hexadecimal digits. Tells files apart, no adversaries.
std::string fingerprintOf(std::string_view bytes);

/// Of every key that shapes a mesh, or its picture where there is one: neither paths and frames nor how the job runs.
/// The values of other configurations differ where their meshes may.
std::string fingerprintOf(const Config& config);

/// errors  a file that cannot be looked at
FileFingerprint stampOf(const std::string& file);

/// Reads the file.
///
/// errors  a file that cannot be read
FileIdentity identityOf(const std::string& file);

/// Whether the file has still, or again, the content it had. Reads it only where its size is right and its time is not.
bool isSame(const std::string& file, const FileIdentity& identity);

}  // namespace betamesh
