// Provenance of meshes: what they were made from, so that a later run can tell whether they are up to date.

#pragma once

#include "batch/config/config.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace betamesh {

/// Size and time of a file, known without reading it.
struct FileFingerprint {
    std::uint64_t bytes = 0;
    std::int64_t modified = 0;  ///< nanoseconds since the epoch
    bool operator==(const FileFingerprint&) const = default;
};

struct FileIdentity {
    FileFingerprint fingerprint;  ///< modified is 0 if the file is so new that its time might miss a later change
    std::string content_hash;     ///< hashOf() its bytes
};

/// The provenance of a frame, as stored in its manifest.
struct Provenance {
    std::string version;                ///< of the program
    std::string config_hash;            ///< see configHash()
    std::string preview_hash;           ///< see previewHash(); empty: the mesh has no preview
    double radius = 0;                  ///< world units, after measuring the spacing
    double spacing = 0;                 ///< world units
    std::optional<FileIdentity> input;  ///< nullopt: the input was missing and an empty mesh was written
    std::map<std::string, std::uint64_t>
        files;                   ///< sizes in bytes of the written files, by path relative to the manifest
    Vec3 local_origin{0, 0, 0};  ///< has to be added to the mesh to return to the coordinates of the input; world units
    UpAxis up_axis = UpAxis::y;  ///< of the mesh
};

/// A 128 bit hash in hexadecimal digits. Not secure against forgery.
std::string hashOf(std::string_view bytes);

/// The hash of every key that can affect a mesh: not of paths, frames, previews and how the job runs.
std::string configHash(const Config& config);

/// The hash of every key of previews; of those of the mesh that they show see configHash().
std::string previewHash(const Config& config);

/// The name of a file in Provenance::files: its path from the folder of the output, or its absolute path if there is no
/// way from one to the other because only one of them is absolute.
std::string listedName(const std::string& file, const std::string& output);

/// errors  a file that cannot be accessed
FileFingerprint fileFingerprint(const std::string& file);

/// Reads the whole file.
///
/// errors  a file that cannot be read
FileIdentity fileIdentity(const std::string& file);

/// Whether the file has the same content. Reads it only if its size is the same and its time is not.
bool isSame(const std::string& file, const FileIdentity& identity);

}  // namespace betamesh
