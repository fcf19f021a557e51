// What the reader and the writer of Alembic files share.
//
// The root group of the Ogawa file: data version of the layout (0), version of Alembic, group of the top object, data
// metadata, data time samplings, data metadata table.
//   object       a group: group of properties, groups of child objects, data: for each child u32 length of its name,
//                name, u8 index of its metadata; then 16 bytes of digest of the properties, 16 of the children
//   properties   a group: a group for each property, data: their headers
//   array        a group: for each stored sample data of 16 bytes of digest and the numbers, data of the dimensions
//                (empty: one dimension)
//   scalar       a group: for each stored sample data of 16 bytes of digest and the numbers
//   time sampling  u32 largest number of samples, f64 seconds per cycle, u32 times in a cycle, f64 each
//   metadata table  for each entry u8 length, then "key=value;key=value"; index 0 is no metadata, 255: it follows
//                its index with its length
// Property header: u32 flags, then with the size that the flags state: number of samples, first and last sample that
// differs from its predecessor if kHasChangedRange, index of the time sampling if kHasTimeSampling (these four not for
// compounds), length of the name, name, and perhaps length of the metadata and metadata.
// Source: Alembic 1.8, lib/Alembic/AbcCoreOgawa, AbcGeom.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace betamesh {

/// The types of numbers, as Alembic counts them.
enum class AlembicType : std::uint8_t {
    boolean,
    uint8,
    int8,
    uint16,
    int16,
    uint32,
    int32,
    uint64,
    int64,
    float16,
    float32,
    float64,
    string,
    wstring
};

/// The name of a type in metadata.
inline const char* nameOf(AlembicType type) {
    constexpr std::array<const char*, 14> kNames{"bool_t",    "uint8_t",   "int8_t",   "uint16_t", "int16_t",
                                                 "uint32_t",  "int32_t",   "uint64_t", "int64_t",  "float16_t",
                                                 "float32_t", "float64_t", "string",   "wstring"};
    return kNames[static_cast<std::size_t>(type)];
}

/// Bytes of a number; 0 for strings.
inline constexpr std::size_t bytesOf(AlembicType type) {
    constexpr std::array<std::size_t, 14> kBytes{1, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8, 0, 0};
    return kBytes[static_cast<std::size_t>(type)];
}

// Flags of a property header.
inline constexpr std::uint32_t kPropertyKind = 3;  ///< mask; 0 compound, 1 scalar, 2 array, 3 array of one row
inline constexpr std::uint32_t kScalar = 1, kArray = 2;
inline constexpr int kSizeShift = 2;  ///< 2 bits: log2 of the bytes of the numbers in the header
inline constexpr int kTypeShift = 4;  ///< 4 bits: AlembicType
inline constexpr std::uint32_t kHasTimeSampling = 0x100;
inline constexpr std::uint32_t kHasChangedRange = 0x200;
inline constexpr std::uint32_t kSameSize = 0x400;  ///< all samples have the same number of rows
inline constexpr std::uint32_t kConstant = 0x800;  ///< all samples are the same, which is stored once
inline constexpr int kExtentShift = 12;            ///< 8 bits: numbers per row
inline constexpr int kMetadataShift = 20;          ///< 8 bits: index in the metadata table

inline constexpr std::uint32_t kInlineMetadata = 255;
inline constexpr std::size_t kDigestBytes = 16;

inline constexpr std::string_view kMeshSchema = "AbcGeom_PolyMesh_v1";
inline constexpr std::string_view kPointsSchema = "AbcGeom_Points_v1";
inline constexpr std::string_view kTransformSchema = "AbcGeom_Xform_v3";

}  // namespace betamesh
