#include "io/alembic_archive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace betamesh {

namespace {

constexpr double kAcyclic = 1e30;  // seconds from which a cycle is none

/// A number of 1, 2 or 4 bytes.
std::uint32_t sized(Cursor& in, std::size_t bytes, const char* what) {
    if (bytes == 1) return takeLittle<std::uint8_t>(in, what);
    return bytes == 2 ? takeLittle<std::uint16_t>(in, what) : takeLittle<std::uint32_t>(in, what);
}

std::string textOf(Cursor& in, std::size_t length, const char* what) {
    const auto* text = reinterpret_cast<const char*>(in.take(length, what));
    return {text, length};
}

Matrix4 identity() {
    Matrix4 m{};
    for (std::size_t i = 0; i < 4; ++i) m[i][i] = 1;
    return m;
}

Matrix4 product(const Matrix4& a, const Matrix4& b) {
    Matrix4 m{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
    return m;
}

/// Rotation about an axis, for row vectors. Rodrigues' formula.
Matrix4 rotation(std::array<double, 3> axis, double degrees) {
    const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    Matrix4 m = identity();
    if (!(length > 0)) return m;
    for (double& x : axis) x /= length;
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    const Matrix4 cross{{{0, axis[2], -axis[1], 0}, {-axis[2], 0, axis[0], 0}, {axis[1], -axis[0], 0, 0}, {}}};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) m[i][j] = (i == j ? c : 0) + (1 - c) * axis[i] * axis[j] + s * cross[i][j];
    return m;
}

/// The operations of a transform, as their codes are numbered.
enum class Operation : std::uint8_t { scale, translate, rotate, matrix, rotate_x, rotate_y, rotate_z };

std::size_t numbersOf(Operation operation) {
    switch (operation) {
        case Operation::scale:
        case Operation::translate:
            return 3;
        case Operation::rotate:
            return 4;
        case Operation::matrix:
            return 16;
        default:
            return 1;
    }
}

Matrix4 matrixOf(Operation operation, std::span<const double> x) {
    Matrix4 m = identity();
    switch (operation) {
        case Operation::scale:
            for (std::size_t i = 0; i < 3; ++i) m[i][i] = x[i];
            return m;
        case Operation::translate:
            for (std::size_t i = 0; i < 3; ++i) m[3][i] = x[i];
            return m;
        case Operation::rotate:
            return rotation({x[0], x[1], x[2]}, x[3]);
        case Operation::matrix:
            for (std::size_t i = 0; i < 16; ++i) m[i / 4][i % 4] = x[i];
            return m;
        case Operation::rotate_x:
            return rotation({1, 0, 0}, x[0]);
        case Operation::rotate_y:
            return rotation({0, 1, 0}, x[0]);
        case Operation::rotate_z:
            return rotation({0, 0, 1}, x[0]);
    }
    return m;
}

}  // namespace

std::string AlembicProperty::meta(const std::string& key) const {
    const auto found = metadata.find(key);
    return found == metadata.end() ? std::string() : found->second;
}

AlembicArchive::AlembicArchive(OgawaReader file) : file_(std::move(file)) {
    constexpr std::size_t kVersion = 0, kTop = 2, kTimeSamplings = 4, kMetadata = 5;
    const std::vector<OgawaChild> root = file_.group(file_.root(), "root");
    if (root.size() <= kMetadata) fail("an Ogawa file, but not one of Alembic. It is damaged.");
    const Bytes version = file_.data(root[kVersion], "version");
    if (version.size() != 4 || loadLittle<std::int32_t>(version.data()) != 0)
        fail("the version of the layout is unknown. 0 was expected.");
    const Bytes table = file_.data(root[kMetadata], "metadata table");
    Cursor in(table, "metadata table");
    metadata_.emplace_back();
    while (in.remaining() > 0 && metadata_.size() < kInlineMetadata) {
        const auto length = takeLittle<std::uint8_t>(in, "metadata");
        metadata_.push_back(textOf(in, length, "metadata"));
    }
    readTimeSamplings(file_.data(root[kTimeSamplings], "time samplings"));
    addObjects(file_.group(root[kTop], "top object"), "", std::nullopt, 0);
}

void AlembicArchive::readTimeSamplings(const Bytes& samplings) {
    constexpr double kDigits = 1e6;  // of a frame rate, which is stored as the time of a frame
    Cursor in(samplings, "time samplings");
    constexpr std::size_t kHeader = 4 + 8 + 4;
    for (std::size_t i = 0; in.remaining() >= kHeader; ++i) {  // the geometry does not need them: damage is no error
        takeLittle<std::uint32_t>(in, "time sampling");
        const auto step = takeLittle<double>(in, "time sampling");
        const auto times = takeLittle<std::uint32_t>(in, "time sampling");
        if (times > in.remaining() / sizeof(double)) return;
        TimeSampling& sampling = time_samplings_.emplace_back(TimeSampling{step, {}});
        for (std::uint32_t k = 0; k < times; ++k) sampling.times.push_back(takeLittle<double>(in, "times"));
        if (i == 0 || times != 1 || !(step > 0 && step < kAcyclic) || frames_per_second_) continue;
        frames_per_second_ = std::round(kDigits / step) / kDigits;
    }
}

std::map<std::string, std::string> AlembicArchive::metadataOf(std::uint32_t index, Cursor& in,
                                                              std::size_t length_bytes) {
    std::string text;
    if (index == kInlineMetadata)
        text = textOf(in, sized(in, length_bytes, "metadata"), "metadata");
    else if (index < metadata_.size())
        text = metadata_[index];
    else
        in.fail("metadata " + std::to_string(index) + " are not in the table, which has " +
                std::to_string(metadata_.size()));
    std::map<std::string, std::string> metadata;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(';', begin), text.size());
        const std::string entry = text.substr(begin, end - begin);
        if (const std::size_t equals = entry.find('='); equals != std::string::npos)
            metadata.emplace(entry.substr(0, equals), entry.substr(equals + 1));
        begin = end + 1;
    }
    return metadata;
}

void AlembicArchive::addObjects(const std::vector<OgawaChild>& children, const std::string& path,
                                const std::optional<Matrix4>& world, int depth) {
    constexpr int kMaxDepth = 100;
    constexpr std::size_t kMaxObjects = 100000;
    if (depth > kMaxDepth) fail("objects are nested more than " + std::to_string(kMaxDepth) + " deep");
    if (children.empty()) return;
    const Bytes headers = file_.data(children.back(), "headers of objects");
    if (headers.size() <= 2 * kDigestBytes) return;
    const std::span<const std::byte> before_digests(headers.data(), headers.size() - 2 * kDigestBytes);
    Cursor in(before_digests, "headers of the objects in '" + path + "/'");
    for (std::size_t child = 1; in.remaining() > 0; ++child) {
        const auto length = takeLittle<std::uint32_t>(in, "name of an object");
        const std::string object = path + '/' + textOf(in, length, "name of an object");
        const auto index = takeLittle<std::uint8_t>(in, "metadata");
        const auto metadata = metadataOf(index, in, 4);
        if (child + 1 >= children.size()) fail("object '" + object + "' is missing. The file is damaged.");
        if (objects_.size() >= kMaxObjects) fail("more than " + std::to_string(kMaxObjects) + " objects");
        const auto found = metadata.find("schema");
        const std::string schema = found == metadata.end() ? "" : found->second;
        const std::vector<OgawaChild> parts = file_.group(children[child], "object");
        const OgawaChild object_properties = parts.empty() ? kEmptyGroup : parts.front();
        std::optional<Matrix4> transform = world;
        if (schema == kTransformSchema)
            transform = transformOf(object_properties, object, world);
        else
            objects_.push_back({object, schema, object_properties, world});
        addObjects(parts, object, transform, depth + 1);
    }
}

std::optional<Matrix4> AlembicArchive::transformOf(OgawaChild group, const std::string& path,
                                                   const std::optional<Matrix4>& parent) {
    Bytes codes, values;
    bool inherits = true;
    for (const AlembicProperty& compound : properties(group)) {
        if (compound.name != ".xform" || !compound.isCompound()) continue;
        for (const AlembicProperty& p : properties(compound.content)) {
            const bool is_codes = p.name == ".ops" && p.type == AlembicType::uint8;
            const bool is_values = p.name == ".vals" && p.type == AlembicType::float64;
            const bool is_inherits = p.name == ".inherits" && p.type == AlembicType::boolean;
            if (p.isCompound() || (!is_codes && !is_values && !is_inherits)) continue;
            if (p.changes)
                fail("the transform '" + path + "' moves. Export the object in world space, one frame per file.");
            const Bytes sample = firstSample(p);
            if (is_inherits && !sample.empty()) inherits = sample.front() != std::byte{0};
            if (is_codes) codes = sample;
            if (is_values) values = sample;
        }
    }
    std::vector<double> numbers(values.size() / sizeof(double));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = loadLittle<double>(values.data() + i * sizeof(double));
    Matrix4 local = identity();
    std::size_t used = 0;
    for (const std::byte code : codes) {
        const auto operation = static_cast<Operation>(code >> 4);
        if (operation > Operation::rotate_z) fail("the transform '" + path + "' has an unknown operation");
        const std::size_t count = numbersOf(operation);
        if (count > numbers.size() - used) fail("the transform '" + path + "' has too few numbers");
        local = product(matrixOf(operation, std::span(numbers).subspan(used, count)), local);
        used += count;
    }
    if (inherits && parent) local = product(local, *parent);
    return local == identity() ? std::nullopt : std::optional(local);
}

std::vector<AlembicProperty> AlembicArchive::properties(OgawaChild group) {
    const std::vector<OgawaChild> children = file_.group(group, "properties");
    std::vector<AlembicProperty> properties;
    if (children.empty()) return properties;
    const Bytes headers = file_.data(children.back(), "headers of properties");
    Cursor in(headers, "headers of properties");
    while (in.remaining() > 0) {
        const auto flags = takeLittle<std::uint32_t>(in, "property");
        const std::size_t bytes = std::size_t{1} << (flags >> kSizeShift & 3);
        if (bytes > 4) in.fail("the size of numbers of a property is unknown");
        AlembicProperty p;
        p.kind = flags & kPropertyKind;
        if (!p.isCompound()) {
            if ((flags >> kTypeShift & 15) > static_cast<std::uint32_t>(AlembicType::wstring))
                in.fail("a property has numbers of an unknown type");
            p.type = static_cast<AlembicType>(flags >> kTypeShift & 15);
            p.extent = flags >> kExtentShift & 255;
            p.samples = sized(in, bytes, "property");
            if ((flags & kHasChangedRange) != 0) {
                p.first_changed = sized(in, bytes, "property");
                p.last_changed = sized(in, bytes, "property");
            } else if ((flags & kConstant) == 0 && p.samples > 1) {
                p.first_changed = 1;
                p.last_changed = p.samples - 1;
            }
            p.changes = p.last_changed > 0;
            if ((flags & kHasTimeSampling) != 0) p.time_sampling = sized(in, bytes, "property");
        }
        p.name = textOf(in, sized(in, bytes, "name of a property"), "name of a property");
        p.metadata = metadataOf(flags >> kMetadataShift & 255, in, bytes);
        if (properties.size() + 1 >= children.size())
            fail("property '" + p.name + "' is missing. The file is damaged.");
        p.content = children[properties.size()];
        properties.push_back(std::move(p));
    }
    return properties;
}

std::optional<double> AlembicArchive::timeOf(const AlembicProperty& property, std::uint32_t sample) const {
    constexpr double kRounding = 1e-3;  // frames; times are rounded when they are written
    if (!frames_per_second_ || property.time_sampling >= time_samplings_.size()) return std::nullopt;
    const auto& [cycle, times] = time_samplings_[property.time_sampling];
    const bool is_acyclic = !(cycle < kAcyclic);
    if (times.empty() || (is_acyclic && sample >= times.size())) return std::nullopt;
    const std::size_t cycles = sample / times.size();
    const double seconds = times[sample % times.size()] + (is_acyclic ? 0 : static_cast<double>(cycles) * cycle);
    const double frame = seconds * *frames_per_second_;
    return std::abs(frame - std::round(frame)) < kRounding ? std::round(frame) : frame;
}

std::uint32_t AlembicArchive::sampleAt(const AlembicProperty& property, double frame) const {
    std::uint32_t sample = 0, end = property.samples;
    while (end - sample > 1) {
        const std::uint32_t middle = sample + (end - sample) / 2;
        const auto time = timeOf(property, middle);
        (time && *time <= frame ? sample : end) = middle;
    }
    return sample;
}

Bytes AlembicArchive::sample(const AlembicProperty& property, std::uint32_t sample) {
    if (property.samples == 0) return {};
    const std::vector<OgawaChild> children = file_.group(property.content, "property");
    if (children.empty()) return {};
    // Samples that are the same as the one before are not stored.
    std::size_t stored = 0;
    if (property.changes && sample > 0 && sample >= property.first_changed)
        stored = std::min(sample, property.last_changed) - property.first_changed + std::size_t{1};
    const std::size_t child = property.kind == kScalar ? stored : 2 * stored;
    if (child >= children.size())
        fail("sample " + std::to_string(sample) + " of the property '" + property.name +
             "' is missing. The file is damaged.");
    return file_.data(children[child], property.name.c_str(), kDigestBytes);
}

}  // namespace betamesh
