// Alembic archives of other structure than the writer makes: transforms, several samples, indexed attributes.

#pragma once

#include "io/alembic_layout.h"
#include "io/ogawa.h"
#include "support/file_samples.h"

#include <cstring>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace betamesh {

inline std::string numbers(std::initializer_list<double> values) {
    std::string text(8 * values.size(), '\0');
    std::memcpy(text.data(), std::data(values), text.size());
    return text;
}

template <typename T>
std::string packed(const std::vector<T>& values) {
    std::string text(sizeof(T) * values.size(), '\0');
    std::memcpy(text.data(), values.data(), text.size());
    return text;
}

constexpr std::uint32_t flagsOf(std::uint32_t kind, AlembicType type, std::uint32_t extent) {
    return kind | static_cast<std::uint32_t>(type) << kTypeShift | kSameSize | extent << kExtentShift;
}

/// Builds archives object by object.
struct TestArchive {
    struct Properties {
        std::vector<OgawaChild> groups;
        std::string headers;
    };

    OgawaWriter file;
    std::string metadata;  ///< table
    int next_metadata = 1;

    int addMetadata(const std::string& text) {
        metadata += static_cast<char>(text.size()) + text;
        return next_metadata++;
    }
    /// samples: those that are stored; range: number of all samples, the first and the last that are not stored
    /// elsewhere, if flags has kHasChangedRange. With kHasTimeSampling the property has time sampling 1.
    void property(Properties& parent, const std::string& name, std::uint32_t flags,
                  const std::vector<std::string>& samples, int meta = 0, const std::string& range = "") {
        std::vector<OgawaChild> children;
        for (const std::string& sample : samples) {
            children.push_back(file.data(std::string(16, 'd') + sample));
            if ((flags & kPropertyKind) != kScalar) children.push_back(kEmptyData);
        }
        parent.groups.push_back(file.group(children));
        parent.headers += packed<std::uint32_t>({flags | static_cast<std::uint32_t>(meta) << kMetadataShift});
        parent.headers += range.empty() ? std::string(1, static_cast<char>(samples.size())) : range;
        if ((flags & kHasTimeSampling) != 0) parent.headers += '\1';
        parent.headers += static_cast<char>(name.size()) + name;
    }
    void compound(Properties& parent, const std::string& name, Properties child, int meta = 0) {
        parent.groups.push_back(group(child));
        parent.headers += packed<std::uint32_t>({static_cast<std::uint32_t>(meta) << kMetadataShift});
        parent.headers += static_cast<char>(name.size()) + name;
    }
    OgawaChild group(Properties& properties) {
        properties.groups.push_back(file.data(properties.headers));
        return file.group(properties.groups);
    }
    /// One object; returns its group.
    OgawaChild object(const std::string& compound_name, Properties inside,
                      const std::vector<std::pair<std::string, std::pair<int, OgawaChild>>>& children = {}) {
        Properties properties;
        if (!compound_name.empty()) compound(properties, compound_name, std::move(inside));
        std::vector<OgawaChild> parts{compound_name.empty() ? kEmptyGroup : group(properties)};
        std::string headers;
        for (const auto& [name, child] : children) {
            parts.push_back(child.second);
            headers += packed<std::uint32_t>({static_cast<std::uint32_t>(name.size())}) + name;
            headers += static_cast<char>(child.first);
        }
        parts.push_back(file.data(headers + std::string(32, '\0')));
        return file.group(parts);
    }
    Bytes bytes(OgawaChild top, const std::string& time_samplings = numbers({0})) {
        const OgawaChild root = file.group({file.data(std::string(4, '\0')), file.data(packed<std::int32_t>({10800})),
                                            top, kEmptyData, file.data(time_samplings), file.data(metadata)});
        return bytesOf([&](ByteWriter& out) { file.write(out, root); });
    }
};

inline const std::string kTetrahedron = packed<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});

/// The geometry of a mesh of one tetrahedron with corners in the order of Alembic.
inline TestArchive::Properties tetrahedron(TestArchive& archive, const std::vector<std::string>& positions) {
    TestArchive::Properties geometry;
    archive.property(geometry, "P", flagsOf(kArray, AlembicType::float32, 3), positions);
    archive.property(geometry, ".faceIndices", flagsOf(kArray, AlembicType::int32, 1),
                     {packed<std::int32_t>({0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2})});
    archive.property(geometry, ".faceCounts", flagsOf(kArray, AlembicType::int32, 1),
                     {packed<std::int32_t>({3, 3, 3, 3})});
    return geometry;
}

/// A mesh below two transforms.
inline Bytes transformedMesh(const std::string& operations, const std::string& values, bool moves = false,
                             bool inherits = true) {
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1"),
              transform = archive.addMetadata("schema=AbcGeom_Xform_v3");
    const int vector = archive.addMetadata("interpretation=vector"),
              normal = archive.addMetadata("geoScope=vtx;interpretation=normal");
    TestArchive::Properties geometry = tetrahedron(archive, {kTetrahedron});
    archive.property(geometry, ".velocities", flagsOf(kArray, AlembicType::float32, 3), {kTetrahedron}, vector);
    archive.property(geometry, "N", flagsOf(kArray, AlembicType::float32, 3),
                     {packed<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0.6F, 0.8F, 0})}, normal);
    const OgawaChild shape = archive.object(".geom", geometry);
    TestArchive::Properties inner, outer;
    const auto extent = static_cast<std::uint32_t>(values.size() / 8);
    archive.property(inner, ".inherits", flagsOf(kScalar, AlembicType::boolean, 1), {std::string(1, inherits ? 1 : 0)});
    archive.property(inner, ".ops", flagsOf(kScalar, AlembicType::uint8, static_cast<std::uint32_t>(operations.size())),
                     {operations});
    archive.property(inner, ".vals", flagsOf(kScalar, AlembicType::float64, extent),
                     moves ? std::vector<std::string>{values, values} : std::vector<std::string>{values});
    archive.property(outer, ".ops", flagsOf(kScalar, AlembicType::uint8, 1), {std::string(1, 0x10)});
    archive.property(outer, ".vals", flagsOf(kScalar, AlembicType::float64, 3), {numbers({100, 0, 0})});
    const OgawaChild inside = archive.object(".xform", inner, {{"shape", {mesh, shape}}});
    const OgawaChild outside = archive.object(".xform", outer, {{"inner", {transform, inside}}});
    return archive.bytes(archive.object("", {}, {{"outer", {transform, outside}}}));
}

/// A mesh below transforms with an indexed attribute, in the file that several fuzzed readings begin with.
inline Bytes archiveOfManyKinds() {
    TestArchive archive;
    const int mesh = archive.addMetadata("schema=AbcGeom_PolyMesh_v1"), vertex = archive.addMetadata("geoScope=vtx"),
              transform = archive.addMetadata("schema=AbcGeom_Xform_v3"),
              points = archive.addMetadata("schema=AbcGeom_Points_v1");
    TestArchive::Properties geometry = tetrahedron(archive, {kTetrahedron, kTetrahedron}), parameters, indexed, moved;
    archive.property(indexed, ".vals", flagsOf(kArray, AlembicType::float64, 2), {numbers({1, 2, 3, 4})});
    archive.property(indexed, ".indices", flagsOf(kArray, AlembicType::uint32, 1),
                     {packed<std::uint32_t>({1, 0, 0, 1})});
    archive.compound(parameters, "heat", indexed, vertex);
    archive.property(parameters, "big", flagsOf(kArray, AlembicType::uint64, 1), {packed<std::uint64_t>({1, 2, 3, 4})},
                     vertex);
    archive.compound(geometry, ".arbGeomParams", parameters);
    const OgawaChild shape = archive.object(".geom", geometry);
    TestArchive::Properties drops;
    archive.property(drops, "P", flagsOf(kArray, AlembicType::float64, 3), {numbers({1, 2, 3, 4, 5, 6})});
    archive.property(drops, ".pointIds", flagsOf(kArray, AlembicType::uint64, 1), {packed<std::uint64_t>({7, 9})});
    const OgawaChild cloud = archive.object(".geom", drops);
    archive.property(moved, ".ops", flagsOf(kScalar, AlembicType::uint8, 3), {std::string("\x10\x20\0", 3)});
    archive.property(moved, ".vals", flagsOf(kScalar, AlembicType::float64, 10),
                     {numbers({1, 2, 3, 0, 1, 1, 45, -1, 2, 2})});
    const OgawaChild below = archive.object(".xform", moved, {{"m", {mesh, shape}}, {"p", {points, cloud}}});
    return archive.bytes(archive.object("", {}, {{"move", {transform, below}}}));
}

}  // namespace betamesh
