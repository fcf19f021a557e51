// Primitives of Houdini's geometry as they are stored in its JSON: polygons become triangles and edges.

#pragma once

#include "io/file_contents.h"
#include "io/houdini_json.h"

#include <cstdint>
#include <string>
#include <vector>

namespace betamesh {

/// Reads the points of vertices or the vertices of polygons from an array: each has to be less than end.
void readHoudiniIndices(HoudiniJsonReader& json, const char* what, std::uint64_t end,
                        std::vector<std::uint32_t>& indices);

/// Reads primitives, which a file lists after its points and attributes.
class HoudiniPrimitiveReader {
public:
    /// in      vertices: the point of each; component: of each primitive, or empty
    /// out     contents: triangles, component, edges, declares_faces and declares_edges, if the options ask for faces;
    ///         unread_polygons: those that are closed, if the options do not; passed_over: other primitives, if the
    ///         options allow them
    HoudiniPrimitiveReader(HoudiniJsonReader& json, const ReadOptions& options,
                           const std::vector<std::uint32_t>& vertices, const std::vector<std::int32_t>& component,
                           FileContents& contents)
        : json_(json), options_(options), vertices_(vertices), component_(component), contents_(contents) {}

    /// The next value is the array of all primitives.
    void read();

    bool hasPolygons() const { return has_polygons_; }
    /// The points that place volumes.
    const std::vector<std::uint32_t>& volumePoints() const { return volume_points_; }

private:
    struct Definition {
        std::string type;
        bool is_run = false;
        std::vector<std::string> varying_fields;  // of a run
        bool closed = true;                       // among the uniform fields of a run
    };

    Definition readDefinition();
    void readPrimitive(const Definition& definition);
    void skip(const Definition& definition);
    void countPolygons(const Definition& definition);
    void readVolume();
    void readPolygonRun(bool closed);
    void readPolygon();
    void readOldRun(const Definition& definition);
    void addPolygons(std::uint64_t count, std::uint64_t corners, bool closed, std::uint64_t& vertex);
    void addPolygon(std::span<const std::uint32_t> points, bool closed);
    std::int64_t readNumber(const char* what, std::int64_t end);
    std::vector<std::uint32_t> pointsOf(const std::vector<std::uint32_t>& vertices) const;

    HoudiniJsonReader& json_;
    const ReadOptions& options_;
    const std::vector<std::uint32_t>& vertices_;
    const std::vector<std::int32_t>& component_;
    FileContents& contents_;
    std::uint64_t primitive_ = 0;                    // the one that is read
    std::map<std::string, std::uint64_t> left_out_;  // number of primitives that are not polygons, by type
    bool has_polygons_ = false;
    std::vector<std::uint32_t> volume_points_;
    std::vector<std::uint32_t> polygon_;
};

}  // namespace betamesh
