// Objects and properties of an Alembic archive.

#pragma once

#include "io/alembic_layout.h"
#include "io/ogawa.h"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace betamesh {

/// An affine map of row vectors: (x, y, z, 1) times the matrix.
using Matrix4 = std::array<std::array<double, 4>, 4>;

struct AlembicObject {
    std::string path;              ///< "/sim/liquid"
    std::string schema;            ///< "AbcGeom_PolyMesh_v1"
    OgawaChild properties;         ///< group of its properties
    std::optional<Matrix4> world;  ///< product of the transforms above it; none: the identity
};

struct AlembicProperty {
    std::string name;
    std::uint32_t kind = 0;  ///< as kPropertyKind
    AlembicType type{};
    std::uint32_t extent = 0;  ///< numbers per row
    std::uint32_t samples = 0;
    bool changes = false;                               ///< not all samples are the same
    std::uint32_t first_changed = 0, last_changed = 0;  ///< samples before and after are the same as their neighbours
    std::uint32_t time_sampling = 0;                    ///< index in the table of the archive
    OgawaChild content = kEmptyGroup;                   ///< group of its samples or, of a compound, its properties
    std::map<std::string, std::string> metadata{};

    bool isCompound() const { return kind == 0; }
    /// A value of the metadata; empty: it has none.
    std::string meta(const std::string& key) const;
};

class AlembicArchive {
public:
    /// errors  a file that is no complete Alembic archive; objects that are nested too deep
    explicit AlembicArchive(OgawaReader file);

    /// All objects but the transforms, parents before children.
    const std::vector<AlembicObject>& objects() const { return objects_; }

    /// Of the first time sampling with equal steps; nullopt: there is none.
    std::optional<double> framesPerSecond() const { return frames_per_second_; }

    /// The properties of an object or compound, which can be asked for once. Compounds that are named like properties
    /// of a schema, such as ".geom", are ordinary ones.
    std::vector<AlembicProperty> properties(OgawaChild group);

    /// The time of a sample in frames; nullopt: the archive has no frame rate or does not tell the time.
    std::optional<double> timeOf(const AlembicProperty& property, std::uint32_t sample) const;
    /// The sample that holds at a time in frames: the latest until then, or else the first.
    std::uint32_t sampleAt(const AlembicProperty& property, double frame) const;
    /// The numbers of a sample, without digest; none if there are no samples.
    Bytes sample(const AlembicProperty& property, std::uint32_t sample);
    Bytes firstSample(const AlembicProperty& property) { return sample(property, 0); }

    [[noreturn]] void fail(const std::string& text) const { file_.fail(0, text); }

private:
    void readTimeSamplings(const Bytes& samplings);
    /// index: in the table, or kInlineMetadata if they follow in the file.
    std::map<std::string, std::string> metadataOf(std::uint32_t index, Cursor& in, std::size_t length_bytes);
    /// Adds the objects below one, whose group has these children.
    void addObjects(const std::vector<OgawaChild>& children, const std::string& path,
                    const std::optional<Matrix4>& world, int depth);
    /// Position in the world of what is below a transform; none: the identity.
    std::optional<Matrix4> transformOf(OgawaChild properties, const std::string& path,
                                       const std::optional<Matrix4>& parent);

    /// When the samples of properties were taken: `times` in seconds, and again after each cycle.
    struct TimeSampling {
        double cycle = 0;  ///< seconds; from kAcyclic on the times are not repeated
        std::vector<double> times;
    };

    OgawaReader file_;
    std::vector<TimeSampling> time_samplings_;
    std::vector<std::string> metadata_;  // by index
    std::optional<double> frames_per_second_;
    std::vector<AlembicObject> objects_;
};

}  // namespace betamesh
